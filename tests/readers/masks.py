#!/usr/bin/env python3
"""Masks as nibabel, Teem and plastimatch read them: masks.py LAMELLA. Ends with 77 where nibabel is missing."""

import pathlib
import shutil
import subprocess
import sys
import tempfile

try:
    import nibabel
    import numpy
except ImportError:
    print("not tested: python3-nibabel is missing")
    sys.exit(77)

from support import box_stl


def marker_of(path):
    """Where the voxels of label 1 lie in RAS: the least and the largest corner, by nibabel."""
    image = nibabel.load(path)
    assert numpy.allclose(image.get_qform(), image.get_sform(), atol=1e-5), path
    inside = numpy.argwhere(numpy.asarray(image.dataobj) == 1)
    places = nibabel.affines.apply_affine(image.affine, inside)
    half = numpy.abs(image.affine[:3, :3]).sum(axis=1) / 2
    return places.min(axis=0) - half, places.max(axis=0) + half


def check_plastimatch(folder, run):
    """plastimatch converts masks to its own images, which say where the marker lies in LPS: its corners, within a voxel."""
    for end in ("nii.gz", "nrrd", "seg.nrrd"):
        run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "-o", f"p.{end}")
        subprocess.run(["plastimatch", "convert", "--input", f"p.{end}", "--output-img", "p.mha"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        low, high = marker_of_metaimage(folder / "p.mha")
        expected = numpy.sort([[-10, -20, 30], [-14, -26, 38]], axis=0)
        assert numpy.all(numpy.abs(low - expected[0]) <= [1.01, 0.76, 0.51]), (end, low)
        assert numpy.all(numpy.abs(high - expected[1]) <= [1.01, 0.76, 0.51]), (end, high)


def marker_of_metaimage(path):
    """As marker_of(), in LPS, of an uncompressed MetaImage."""
    keys, data, at = {}, path.read_bytes(), 0
    while keys.get("ElementDataFile") != "LOCAL":
        end = data.index(b"\n", at)
        key, value = data[at:end].decode().split(" = ", 1)
        keys[key], at = value.strip(), end + 1
    size, spacing, offset, matrix = (numpy.array([float(x) for x in keys[key].split()])
                                     for key in ("DimSize", "ElementSpacing", "Offset", "TransformMatrix"))
    kind = {"MET_UCHAR": numpy.uint8, "MET_USHORT": numpy.uint16, "MET_SHORT": numpy.int16, "MET_FLOAT": numpy.float32}
    voxels = numpy.frombuffer(data[at:], kind[keys["ElementType"]]).reshape(size.astype(int), order="F")
    axes = matrix.reshape(3, 3).T * spacing  # a column each; MetaImage has a row each
    places = numpy.argwhere(voxels == 1) @ axes.T + offset
    half = numpy.abs(axes).sum(axis=1) / 2
    return places.min(axis=0) - half, places.max(axis=0) + half


def main():
    lamella = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def run(*words):
            subprocess.run([lamella, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)

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
            assert numpy.allclose(nibabel.load(folder / f"t.{end}").affine, turn, atol=1e-4)
            low, high = marker_of(folder / f"t.{end}")
            assert numpy.all(numpy.abs(low - [10, 20, 30]) <= [1.01, 0.76, 0.51]), low
            assert numpy.all(numpy.abs(high - [14, 26, 38]) <= [1.01, 0.76, 0.51]), high
        run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "--subslices", "4", "-o", "share.nii.gz")
        volume = nibabel.load(folder / "share.nii.gz").get_fdata().sum() * 3
        assert abs(volume - 4 * 6 * 8) < 4 * 6 * 8 * 0.01, volume
        if unu := shutil.which("teem-unu"):
            run("slice", "box.stl", "--like", "like.nii.gz", "--frame", "ras", "-o", "t.nrrd")
            subprocess.run([unu, "save", "-f", "nrrd", "-e", "raw", "-i", "t.nrrd", "-o", "raw.nrrd"], cwd=folder, check=True)
            voxels = (folder / "raw.nrrd").read_bytes()[-30 * 20 * 40 :]
            same = numpy.asarray(nibabel.load(folder / "t.nii").dataobj).ravel(order="F").tobytes()
            assert voxels == same, "Teem reads other voxels than nibabel"
        if shutil.which("plastimatch"):
            check_plastimatch(folder, run)
    print("passed")


main()
