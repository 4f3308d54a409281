#!/usr/bin/env python3
"""Pictures as Pillow reads them: picture.py LAMELLA. Ends with 77 where Pillow is missing."""

from support import box_stl, main, need

numpy, Image = need("numpy", "PIL.Image")

COLOURS = [(0x1F, 0x6F, 0xB4), (0xF2, 0x8E, 0x2B)]


def where(pixels, colour):
    """Rows and columns of the pixels of this colour, below the heading."""
    rows, columns = numpy.nonzero(numpy.all(pixels == colour, axis=2))
    return rows[rows > 40], columns[rows > 40]


def test(run):
    folder = run.folder

    def read(file):
        image = Image.open(folder / file)
        image.load()
        assert image.format == "PNG" and image.mode == "RGB" and not image.info.get("dpi"), image.info
        return numpy.asarray(image)

    # In RAS: one box is to the right and in front of the other.
    (folder / "a.stl").write_bytes(box_stl((0, 0, 0), (10, 10, 20)))
    (folder / "b.stl").write_bytes(box_stl((20, 30, 5), (24, 40, 9)))
    words = ["a.stl", "b.stl", "--spacing", "1,1,1", "--frame", "ras"]
    run("slice", *words, "-o", "layer.png", "--picture-layer", "7")
    pixels = read("layer.png")
    a, b = where(pixels, COLOURS[0]), where(pixels, COLOURS[1])
    assert a[0].size > 0 and b[0].size > 0
    # Areas: 10 x 10 and 4 x 10 mm.
    assert abs(a[0].size / b[0].size - 2.5) < 0.05, (a[0].size, b[0].size)
    # As radiologists see it: the patient's right is at the left, the front at the top.
    assert b[1].max() < a[1].min() and b[0].max() < a[0].min()
    run("slice", *words, "-o", "sheet.png", "--threads", "1")
    sheet = read("sheet.png")
    cells = where(sheet, COLOURS[0])[0].size / where(sheet, COLOURS[1])[0].size
    assert abs(cells - 2.5 * 20 / 4) < 1.5, cells
    run("slice", *words, "-o", "again.png", "--threads", "3")
    assert (folder / "again.png").read_bytes() == (folder / "sheet.png").read_bytes()


main(test)
