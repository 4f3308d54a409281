#!/usr/bin/env python3
"""Masks as nibabel, Teem and plastimatch read them: masks.py LAMELLA. Ends with 77 where nibabel is missing."""

import shutil
import subprocess

from support import box_stl, main, need

nibabel, numpy = need("nibabel", "numpy")


def marker_of(path):
    """Where the voxels of label 1 lie in RAS: the least and the largest corner, by nibabel."""
    image = nibabel.load(path)
    places = nibabel.affines.apply_affine(image.affine, numpy.argwhere(numpy.asarray(image.dataobj) == 1))
    half = numpy.abs(image.affine[:3, :3]).sum(axis=1) / 2
    return places.min(axis=0) - half, places.max(axis=0) + half


def check_near(path):
    """The marker in an image that is turned: within a voxel."""
    low, high = marker_of(path)
    assert numpy.all(numpy.abs(low - [10, 20, 30]) <= [1.01, 0.76, 0.51]), (path, low)
    assert numpy.all(numpy.abs(high - [14, 26, 38]) <= [1.01, 0.76, 0.51]), (path, high)


def check_plastimatch(run):
    """Images that plastimatch makes of masks have the marker at its place."""
    for end in ("nii.gz", "nrrd", "seg.nrrd", "mha"):
        run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "-o", f"p.{end}")
        subprocess.run(["plastimatch", "convert", "--input", f"p.{end}", "--output-img", "of.nii"], cwd=run.folder, check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        check_near(run.folder / "of.nii")


def check_vtk(run):
    """MetaImage: VTK reads the voxels of the NIfTI mask. It takes no directions from the file."""
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOImage import vtkMetaImageReader
    except ImportError as error:
        print("not tested:", error)
        return
    run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "-o", "t.mha")
    reader = vtkMetaImageReader()
    reader.SetFileName(str(run.folder / "t.mha"))
    reader.Update()
    mine = numpy.asarray(nibabel.load(run.folder / "t.nii").dataobj).ravel(order="F")
    assert numpy.array_equal(vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()), mine)
    assert reader.GetOutput().GetSpacing() == (1.5, 2.0, 1.0) and reader.GetOutput().GetOrigin() == (-30.0, -5.0, 60.0)


def check_layers(run, unu):
    """Meshes that overlap lie in as few layers as hold them, each in voxels of its own, by Teem."""
    places = [((0, 0, 0), (6, 6, 4)), ((3, 3, 1), (9, 9, 5)), ((8, 8, 2), (12, 11, 6)), ((7, 1, 0), (11, 2.5, 6)), ((1, 1, 1), (11, 11, 5))]
    for i, place in enumerate(places):
        (run.folder / f"l{i}.stl").write_bytes(box_stl(*place))
    meshes = [f"l{i}.stl" for i in range(len(places))]
    (run.folder / "l.csv").write_text("label,color,type,name\n2,#336699,SCT^71341001^Femur,\"femur, left\"\n")
    run("slice", *meshes, "--like", "like.nii", "--frame", "ras", "--label-table", "l.csv", "-o", "l.seg.nrrd")
    assert not (run.folder / "l.labels.csv").exists()
    subprocess.run([unu, "save", "-f", "nrrd", "-e", "raw", "-i", "l.seg.nrrd", "-o", "raw.nrrd"], cwd=run.folder, check=True)
    header, voxels = (run.folder / "raw.nrrd").read_bytes().split(b"\n\n", 1)
    lines = header.decode().split("\n")
    assert "sizes: 3 14 13 8" in lines and "kinds: list domain domain domain" in lines and "Segment1_Name:=femur, left" in lines
    assert any(line.startswith("Segment1_Tags:=") and "~SCT^71341001^Femur~" in line for line in lines)
    assert "Segment1_Color:=0.2 0.4 0.6" in lines
    array = numpy.frombuffer(voxels, numpy.uint8).reshape((3, 14, 13, 8), order="F")
    keys = dict(line.split(":=", 1) for line in lines if ":=" in line)
    assert [keys[f"Segment{i}_Layer"] for i in range(5)] == ["0", "1", "0", "0", "2"], keys
    for i, mesh in enumerate(meshes):
        run("slice", mesh, "--like", "like.nii", "--frame", "ras", "-o", "one.nii")
        mine = array[int(keys[f"Segment{i}_Layer"])] == int(keys[f"Segment{i}_LabelValue"])
        assert numpy.array_equal(mine, numpy.asarray(nibabel.load(run.folder / "one.nii").dataobj) == 1) and mine.any()


def test(run):
    folder = run.folder
    (folder / "box.stl").write_bytes(box_stl((10, 20, 30), (14, 26, 38)))
    for frame, sign in (("ras", 1), ("lps", -1)):
        run("slice", "box.stl", "--spacing", "1,2,4", "--frame", frame, "-o", "m.nii.gz")
        low, high = marker_of(folder / "m.nii.gz")
        expected = numpy.sort([[sign * 10, sign * 20, 30], [sign * 14, sign * 26, 38]], axis=0)
        assert numpy.allclose(low, expected[0]) and numpy.allclose(high, expected[1]), (frame, low, high)  # voxels fill the box
    # An image of another program, turned and left-handed: the marker stays at its place.
    turn = numpy.array([[0, -2.0, 0, 30], [1.5, 0, 0, 5], [0, 0, -1, 60], [0, 0, 0, 1]])
    nibabel.save(nibabel.Nifti1Image(numpy.zeros((30, 20, 40), numpy.uint8), turn), folder / "like.nii.gz")
    for end in ("nii.gz", "nii"):
        run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "-o", f"t.{end}")
        image = nibabel.load(folder / f"t.{end}")
        assert numpy.allclose(image.get_qform(), turn, atol=1e-4) and numpy.allclose(image.get_sform(), turn, atol=1e-4)
        check_near(folder / f"t.{end}")
    likes = ["two.nii"]
    nibabel.save(nibabel.Nifti2Image(numpy.zeros((30, 20, 40), numpy.uint8), turn), folder / likes[0])
    if shutil.which("plastimatch"):
        likes += ["like.mha", "like.mhd"]
    for like in likes[1:]:
        subprocess.run(["plastimatch", "convert", "--input", "like.nii.gz", "--output-img", like], cwd=folder, check=True,
                       capture_output=True)
    for like in likes:
        run("slice", "box.stl", "--like", like, "--frame", "ras", "-o", "same.nii")
        assert numpy.allclose(nibabel.load(folder / "same.nii").affine, turn, atol=1e-4), like
        assert (folder / "same.nii").read_bytes()[352:] == (folder / "t.nii").read_bytes()[352:], like
    run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "--subslices", "4", "-o", "share.nii.gz")
    volume = nibabel.load(folder / "share.nii.gz").get_fdata().sum() * 3
    assert abs(volume - 4 * 6 * 8) < 4 * 6 * 8 * 0.01, volume
    if unu := shutil.which("teem-unu"):
        run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "-o", "t.nrrd")
        subprocess.run([unu, "save", "-f", "nrrd", "-e", "raw", "-i", "t.nrrd", "-o", "raw.nrrd"], cwd=folder, check=True)
        voxels = (folder / "raw.nrrd").read_bytes()[-30 * 20 * 40 :]
        same = numpy.asarray(nibabel.load(folder / "t.nii").dataobj).ravel(order="F").tobytes()
        assert voxels == same, "Teem reads other voxels than nibabel"
        nibabel.save(nibabel.Nifti1Image(numpy.zeros((14, 13, 8), numpy.uint8), numpy.eye(4)), folder / "like.nii")
        check_layers(run, unu)
    check_vtk(run)
    if shutil.which("plastimatch"):
        check_plastimatch(run)


main(test)
