#!/usr/bin/env python3
"""Masks beside those of VTK's stencil: stencil.py LAMELLA. Ends with 77 where python3-vtk9 is missing.

vtkPolyDataToImageStencil cuts the mesh at the heights of voxel centres and fills between rounded crossings. It rounds: with a
tolerance of 2^-17 of a voxel at edges, and in single precision where points are. So voxels may differ, but only those whose
centre lies so near to the surface. They are counted and printed, and the distance of each is checked.
"""

from support import box_stl, main, need

nibabel, numpy, vtk, numpy_support = need("nibabel", "numpy", "vtk", "vtk.util.numpy_support")

SPACING = (1.0, 0.75, 1.5)
SLACK_MM = 2e-5  # 2^-17 of a voxel, and single precision of coordinates up to 100 mm


def vtk_mesh(path):
    reader = vtk.vtkSTLReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def stencil(mesh, size, spacing, origin):
    """What VTK finds inside, as an array [i, j, k]."""
    to_stencil = vtk.vtkPolyDataToImageStencil()
    to_stencil.SetInputData(mesh)
    to_stencil.SetOutputSpacing(*spacing)
    to_stencil.SetOutputOrigin(*origin)
    to_stencil.SetOutputWholeExtent(0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1)
    image = vtk.vtkImageData()
    image.SetDimensions(*size)
    image.SetSpacing(*spacing)
    image.SetOrigin(*origin)
    image.AllocateScalars(vtk.VTK_UNSIGNED_CHAR, 1)
    image.GetPointData().GetScalars().Fill(1)
    masked = vtk.vtkImageStencil()
    masked.SetInputData(image)
    masked.SetStencilConnection(to_stencil.GetOutputPort())
    masked.SetBackgroundValue(0)
    masked.Update()
    return numpy_support.vtk_to_numpy(masked.GetOutput().GetPointData().GetScalars()).reshape(size, order="F")


def distances(mesh, centres):
    """From each centre to the surface, in space: where it is nearly flat its contour moves far when the plane moves little."""
    distance = vtk.vtkImplicitPolyDataDistance()
    distance.SetInput(mesh)
    return numpy.array([abs(distance.EvaluateFunction(*centre)) for centre in centres])


def compare(run, name):
    # The marker's frame is LPS, as VTK knows no frame; nibabel gives RAS.
    run("slice", f"{name}.stl", "--spacing", ",".join(map(str, SPACING)), "--frame", "lps", "-o", f"{name}.nii")
    image = nibabel.load(run.folder / f"{name}.nii")
    ours = numpy.asarray(image.dataobj)
    origin = image.affine[:3, 3] * (-1, -1, 1)
    mesh = vtk_mesh(run.folder / f"{name}.stl")
    theirs = stencil(mesh, ours.shape, SPACING, origin)
    different = numpy.argwhere(ours != theirs)
    far = distances(mesh, origin + different * SPACING)
    print(f"{name}: {ours.sum()} voxels inside by lamella, {theirs.sum()} by VTK, {len(different)} differ", end="")
    print(f", the farthest by {far.max():.2g} mm from the surface" if len(different) else "")
    assert ours.sum() > 1000, "the shape is too small to tell anything"
    assert (far <= SLACK_MM).all(), f"{name}: {(far > SLACK_MM).sum()} voxels differ for no reason"
    return len(different)


def test(run):
    for shape in ("sphere", "torus", "bone", "gyroid"):
        run("make", shape, "--triangles", "20000", "--height", "60", "-o", f"{shape}.stl")
    # A box whose sides lie on no centre, and one whose sides all do: two others place the voxels around them.
    (run.folder / "box.stl").write_bytes(box_stl((10.2, 20.3, 30.4), (40.7, 41.9, 52.3)))
    boxes = [box_stl((0, 0, 0), (2, 2, 2)), box_stl((10.5, 15.375, 30.75), (30.5, 36.375, 51.75)), box_stl((38, 43, 58), (40, 45, 60))]
    (run.folder / "on_centres.stl").write_bytes(boxes[0][:80] + (36).to_bytes(4, "little") + b"".join(box[84:] for box in boxes))
    for shape in ("sphere", "torus", "bone", "gyroid", "box"):
        assert compare(run, shape) <= 2, f"{shape}: more voxels differ than rounding explains"
    # Here the rules differ: with lamella left and bottom sides are inside, right and top ones are not.
    assert compare(run, "on_centres") > 0


main(test)
