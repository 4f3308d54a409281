#!/usr/bin/python3
"""Measures what `lamella batch` estimates: bytes of file and of peak memory a triangle, by file format.

    bench/scripts/batch_memory.py LAMELLA [--triangles 1000000] [--readme bench/README.md]

Slices the same bone of 100 mm, in every format, into SVG at 0.2 and 0.05 mm, and into a mask of 0.5 mm with a table; prints a
table. Peak memory is what /usr/bin/time says, less that of the smallest mesh. Needs numpy and the package time.
"""

import gzip
import pathlib
import shutil
import sys
import tempfile

from readme_table import compare, markdown_table, run, usage_of

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
import mesh_formats  # noqa: E402

BARE_TRIANGLES = 1000
WORK = {
    "SVG, 0.2 mm": ["--layer-height", "0.2", "-o", "out.svg"],
    "SVG, 0.05 mm": ["--layer-height", "0.05", "-o", "out.svg"],
    "mask and table, 0.5 mm": ["--spacing", "0.5,0.5,0.5", "--frame", "lps", "-o", "out.nii.gz", "-o", "out.csv"],
}


# By the names in the table: those of mesh_formats.py.
FORMATS = {"text.stl": "stl_ascii.stl", "text.obj": "obj.obj", "text.off": "off.off", "text.ply": "ply_ascii.ply", "text.vtk": "vtk_ascii.vtk",
           "text.vtp": "vtp_ascii.vtp", "binary.stl": "stl_binary.stl", "binary.ply": "ply_little_endian.ply", "binary.vtk": "vtk_binary.vtk",
           "raw.vtp": "vtp_raw.vtp", "zip.3mf": "3mf.3mf"}


def write_formats(stl, folder):
    """Files of the same mesh, and those that are not packed by themselves packed by gzip."""
    mesh = mesh_formats.Mesh(stl)
    mesh_formats.write(mesh_formats.vtp_zlib(mesh, "raw"), folder / "zlib.vtp")
    for name, form in FORMATS.items():
        mesh_formats.write(mesh_formats.FORMATS[form](mesh), folder / name)
        if name != "zip.3mf":
            with open(folder / name, "rb") as plain, gzip.open(folder / (name + ".gz"), "wb", compresslevel=6) as packed:
                shutil.copyfileobj(plain, packed)


def peak_bytes(tool, mesh, work, folder):
    return usage_of(tool, "slice", mesh, "--threads", "1", *work, cwd=folder).peak_bytes


def tables(arguments, _bars):
    tool, rows = arguments.tool, []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for path, triangles in (("bone.stl", arguments.triangles), ("bare.stl", BARE_TRIANGLES)):
            run(tool, "make", "bone", "--triangles", str(triangles), "--height", "100", "-o", folder / path)
        bare = {what: peak_bytes(tool, "bare.stl", work, folder) for what, work in WORK.items()}
        triangles = ((folder / "bone.stl").stat().st_size - 84) // 50
        files = folder / "files"
        files.mkdir()
        write_formats(folder / "bone.stl", files)
        for file in sorted(files.iterdir()):
            peaks = [f"{(peak_bytes(tool, file, work, folder) - bare[what]) / triangles:.0f}" for what, work in WORK.items()]
            rows.append([file.name, f"{file.stat().st_size / triangles:.1f}", *peaks])
    return [markdown_table(["format", "bytes of file a triangle", *WORK], rows),
            f"Bare process: {max(bare.values()) / 1e6:.0f} MB; {triangles:,} triangles."]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "batch memory", tables, "tool", triangles=1_000_000))
