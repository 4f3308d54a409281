#!/usr/bin/env python3
"""Archives as h5py reads them: archive.py LAMELLA. Ends with 77 where h5py is missing."""

import csv
import zlib

from support import main, need

h5py, numpy = need("h5py", "numpy")


def areas_of(archive):
    """The area of each layer in mm^2, from nothing but the points."""
    points = archive["points"][...].astype(numpy.float64) * archive.attrs["grid_mm"]
    first_point = archive["contours/first_point"][...]
    first_contour = archive["layers/first_contour"][...]
    role = archive["contours/role"][...]
    areas = []
    for begin, end in zip(first_contour[:-1], first_contour[1:]):
        area = 0
        for c in range(begin, end):
            x, y = points[first_point[c] : first_point[c + 1]].T
            if role[c] < 2:
                area += 0.5 * numpy.sum(x * numpy.roll(y, -1) - y * numpy.roll(x, -1))
        areas.append(area)
    return numpy.array(areas)


def check_checksum(file):
    """Of all bytes before the last line."""
    before, line = file.read_bytes()[:-1].rsplit(b"\n", 1)
    assert line == b"lamella archive 3, CRC-32 of all before: %08x" % zlib.crc32(before), line


def check_columns(archive):
    """Units and lengths."""

    def visit(name, item):
        if isinstance(item, h5py.Dataset):
            assert item.attrs.get("unit", b"") in (b"", b"mm", b"mm^2", b"grid unit"), name
            assert item.compression is None and item.chunks is None, name

    archive.visititems(visit)
    contours = len(archive["contours/parent"])
    assert archive["layers/first_contour"][-1] == contours
    assert len(archive["contours/first_point"]) == contours + 1
    assert archive["contours/first_point"][-1] == len(archive["points"])
    assert archive.attrs["format"] == b"lamella archive"


def test(run):
    folder = run.folder
    run("make", "gyroid", "--triangles", "20000", "--height", "40", "-o", "g.stl")
    run("slice", "g.stl", "--layer-height", "0.5", "-o", "g.h5", "-o", "g.csv", "-o", "g.svg", "--threads", "1")
    run("slice", "g.stl", "--layer-height", "0.5", "-o", "two.h5", "--threads", "2")
    check_checksum(folder / "g.h5")
    with h5py.File(folder / "g.h5") as archive:
        check_columns(archive)
        rows = list(csv.DictReader(open(folder / "g.csv")))
        heights = archive["layers/plane_mm"][...]
        assert len(rows) == len(heights) > 20
        assert numpy.array_equal(heights, [float(row["height_mm"]) for row in rows])
        listed = numpy.array([float(row["area_mm2"]) for row in rows])
        assert numpy.allclose(areas_of(archive), listed, rtol=1e-12, atol=1e-9)
        owner = numpy.repeat(numpy.arange(len(rows)), numpy.diff(archive["layers/first_contour"][...].astype(int)))
        sums = numpy.bincount(owner, weights=archive["contours/area_mm2"][...], minlength=len(rows))
        assert numpy.allclose(sums, listed, rtol=1e-12, atol=1e-9)
        assert archive["mesh"].attrs["name"] == b"g" and archive["options"].attrs["layer_height_mm"] == 0.5
        low, high = (archive["mesh"].attrs[f"{end}_mm"][2] for end in ("min", "max"))
        assert low < heights[0] and heights[-1] < high, (low, high)
    with h5py.File(folder / "two.h5") as archive:
        assert archive["mesh"].attrs["name"] == b"g"
    assert (folder / "two.h5").read_bytes() == (folder / "g.h5").read_bytes(), "bytes depend on threads"
    stl = bytearray((folder / "g.stl").read_bytes())
    stl[80:84] = (int.from_bytes(stl[80:84], "little") - 9).to_bytes(4, "little")
    (folder / "open.stl").write_bytes(stl[: 84 + 9000 * 50] + stl[84 + 9009 * 50 :])
    run("slice", "open.stl", "--layer-height", "0.5", "--stitch", "0", "-o", "open.h5", "-o", "open.csv")
    with h5py.File(folder / "open.h5") as archive:
        empty = [row["area_mm2"] == "" for row in csv.DictReader(open(folder / "open.csv"))]
        assert any(empty) and archive["layers/open"][...].tolist() == empty and archive["layers/open"].attrs["meaning"]
    run("slice", "g.stl", "--spacing", "0.5,0.5,1", "--frame", "lps", "-o", "image.h5", "-o", "image.nrrd")
    with h5py.File(folder / "image.h5") as archive:
        image = archive["image"].attrs
        assert image["spacing_mm"].tolist() == [0.5, 0.5, 1] and archive["mesh"].attrs["patient_frame"] == b"LPS"
        assert image["size_k"] == len(archive["options/heights_mm"]) == len(archive["options/layer_of_height"])
    run("convert", "image.h5", "-o", "again.nrrd")
    assert (folder / "again.nrrd").read_bytes() == (folder / "image.nrrd").read_bytes(), "another mask"
    for end in ("csv", "svg"):
        run("convert", "g.h5", "-o", f"again.{end}")
        assert (folder / f"again.{end}").read_bytes() == (folder / f"g.{end}").read_bytes(), f"another {end}"


main(test)
