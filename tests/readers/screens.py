#!/usr/bin/env python3
"""Pictures for resin printers as Python's zipfile and Pillow read them: screens.py LAMELLA. Ends with 77 where Pillow is missing."""

import configparser
import csv
import io
import zipfile

from support import box_stl, main, need

numpy, images = need("numpy", "PIL.Image")
images.MAX_IMAGE_PIXELS = None


def pixels_of(archive, name):
    with images.open(io.BytesIO(archive.read(name))) as image:
        assert image.mode == "L" and image.format == "PNG", (name, image.mode)
        return numpy.asarray(image)


def boundary_pixels(grey):
    """Those unlike a neighbour: all that lie partly inside are among them."""
    unlike = numpy.zeros(grey.shape, bool)
    for one, other in ((numpy.s_[1:], numpy.s_[:-1]), (numpy.s_[:, 1:], numpy.s_[:, :-1])):
        change = grey[one] != grey[other]
        unlike[one] |= change
        unlike[other] |= change
    return numpy.count_nonzero(unlike)


def check_areas(folder, levels, pixel_mm2, every):
    """Each layer's grey is its area, within half a level a boundary pixel."""
    areas = [float(row["area_mm2"]) for row in csv.DictReader((folder / "bone.csv").open())]
    with zipfile.ZipFile(folder / "bone.zip") as archive:
        assert archive.testzip() is None
        assert archive.namelist() == [f"{i + 1}.png" for i in range(len(areas))] + ["manifest.uvtools"]
        for layer in range(every // 2, len(areas), every):
            grey = pixels_of(archive, f"{layer + 1}.png")
            off = abs(grey.sum(dtype=int) / 255 - areas[layer] / pixel_mm2) * (levels - 1)
            assert areas[layer] > 0 and off <= boundary_pixels(grey) / 2, (layer, levels, off)
            assert levels == 256 or numpy.all(grey % (255 // (levels - 1)) == 0)


def test(run):
    folder = run.folder
    run("make", "bone", "--triangles", "40000", "-o", "bone.stl")
    fine = ["slice", "bone.stl", "--layer-height", "0.16", "--screen", "Saturn 3 Ultra", "-o", "bone.zip"]
    run(*fine, "-o", "bone.csv", "--threads", "2")
    check_areas(folder, 256, 0.019 * 0.024, 193)
    before = (folder / "bone.zip").read_bytes()
    for other in (["--threads", "1"], ["--memory", "2M", "--threads", "3"]):
        run(*fine, *other)
        assert (folder / "bone.zip").read_bytes() == before, other
    for levels in (2, 16, 256):
        run("slice", "bone.stl", "--layer-height", "2", "--screen", "1500X1000", "--pixel", "0.031,0.0401", "--turn", "180", "--levels",
            str(levels), "-o", "bone.zip", "-o", "bone.csv")
        check_areas(folder, levels, 0.031 * 0.0401, 1)
    # A box at the left, seen as it lies: mirrored, as an SL1 has it, it is at the right.
    (folder / "box.stl").write_bytes(box_stl((1, 2, 0), (4, 4, 1)))
    place = ["--screen", "sl1", "--place", "as-is", "--layer-height", "0.1", "--exposure", "6.5"]
    for mirror, columns in (([], (1440 - 4 / 0.04725, 1440 - 1 / 0.04725)), (["--mirror", "none"], (1 / 0.04725, 4 / 0.04725))):
        run("slice", "box.stl", *place, *mirror, "-o", "box.sl1")
        with zipfile.ZipFile(folder / "box.sl1") as archive:
            seen = numpy.argwhere(pixels_of(archive, "JOB00009.png"))
            assert (seen[:, 1].min(), seen[:, 1].max()) == tuple(map(int, columns)), mirror
            for settings in ("config.ini", "prusaslicer.ini"):
                keys = configparser.ConfigParser()
                keys.read_string("[all]\n" + archive.read(settings).decode())
                assert keys["all"].get("expTime", keys["all"].get("exposure_time")) == "6.5", settings
    # More entries than the zip format had room for at first.
    (folder / "tall.stl").write_bytes(box_stl((0, 0, 0), (4, 2, 70)))
    run("slice", "tall.stl", "--layer-height", "0.001", "--screen", "8x4", "--pixel", "1", "-o", "tall.zip")
    with zipfile.ZipFile(folder / "tall.zip") as archive:
        assert len(archive.namelist()) == 70001 and archive.testzip() is None
        assert pixels_of(archive, "70000.png").sum() == 8 * 255
    run("slice", "bone.stl", "--screen", "9x9", "--pixel", "1", "-o", "no.zip", status=2, says="beyond the screen in x")
    run("slice", "bone.stl", "--screen", "ultra", "-o", "no.zip", status=2, says="could be Elegoo Mars 4 Ultra, ")
    run("slice", "bone.stl", "-o", "no.sl1", status=2, says="needs --screen")
    assert not list(folder.glob("no.*"))


main(test)
