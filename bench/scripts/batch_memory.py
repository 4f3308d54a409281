#!/usr/bin/python3
"""Measures what `lamella batch` estimates: bytes of file and of peak memory a triangle, by file format.

    bench/scripts/batch_memory.py LAMELLA [--triangles 1000000] [--readme bench/README.md]

Slices the same bone of 100 mm, in every format, into SVG at 0.2 and 0.05 mm, and into a mask of 0.5 mm with a table; prints a
table. Peak memory is what /usr/bin/time says, less that of the smallest mesh. Needs numpy and the package time.
"""

import argparse
import gzip
import pathlib
import shutil
import struct
import subprocess
import tempfile
import zipfile
import zlib

import numpy as np

from readme_table import replace_table

BARE_TRIANGLES = 1000
WORK = {
    "SVG, 0.2 mm": ["--layer-height", "0.2", "-o", "out.svg"],
    "SVG, 0.05 mm": ["--layer-height", "0.05", "-o", "out.svg"],
    "mask and table, 0.5 mm": ["--spacing", "0.5,0.5,0.5", "--frame", "lps", "-o", "out.nii.gz", "-o", "out.csv"],
}


def soup_of(path):
    rows = np.fromfile(path, dtype=np.dtype([("normal", "<f4", 3), ("corners", "<f4", 9), ("more", "<u2")]), offset=84)
    return rows["corners"].reshape(-1, 3)


def lines_of(array, form):
    return "".join((form + "\n") % tuple(row) for row in array.tolist())


def vtp_array(values):
    """Raw, and as VTK packs it: blocks of 32 KiB, each by zlib, and a table of their lengths."""
    data = values.tobytes()
    blocks = [zlib.compress(data[at : at + 32768]) for at in range(0, len(data), 32768)]
    table = struct.pack(f"<3I{len(blocks)}I", len(blocks), 32768, len(data) % 32768, *map(len, blocks))
    return struct.pack("<I", len(data)) + data, table + b"".join(blocks)


def write_vtp(vertices, faces, points, folder):
    """XML polydata: text, raw and packed, with 64-bit indices as VTK writes them."""
    ends = np.arange(3, 3 * len(faces) + 1, 3, dtype="<i8")
    arrays = [("Float32", "points", 3, vertices.astype("<f4")), ("Int64", "connectivity", 1, faces.astype("<i8")),
              ("Int64", "offsets", 1, ends)]  # fmt: skip
    packed = [vtp_array(values) for *_, values in arrays]
    texts = [points, lines_of(faces, "%d %d %d"), " ".join(map(str, ends.tolist()))]
    for name, compressor, form in (("text.vtp", "", None), ("raw.vtp", "", 0), ("zlib.vtp", ' compressor="vtkZLibDataCompressor"', 1)):
        at, elements = 0, []
        for i, (kind, title, width, _) in enumerate(arrays):
            head = f'<DataArray type="{kind}" Name="{title}" NumberOfComponents="{width}" format='
            elements.append(head + (f'"ascii">\n{texts[i]}</DataArray>' if form is None else f'"appended" offset="{at}"/>'))
            at += 0 if form is None else len(packed[i][form])
        appended = b"" if form is None else b'<AppendedData encoding="raw">_' + b"".join(p[form] for p in packed) + b"</AppendedData>"
        (folder / name).write_bytes(
            f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt32"{compressor}>'
            f'<PolyData><Piece NumberOfPoints="{len(vertices)}" NumberOfPolys="{len(faces)}"><Points>{elements[0]}</Points>'
            f"<Polys>{elements[1]}{elements[2]}</Polys></Piece></PolyData>".encode() + appended + b"</VTKFile>\n")  # fmt: skip


def write_formats(stl, folder):
    """Files of the same mesh; text with seven digits, vertices shared."""
    soup = soup_of(stl)
    vertices, indices = np.unique(soup, axis=0, return_inverse=True)
    faces = indices.reshape(-1, 3)
    points, corners = lines_of(vertices, "%.7g %.7g %.7g"), lines_of(faces, "3 %d %d %d")
    facet = "facet normal 0 0 0\nouter loop\n" + 3 * "vertex %.7g %.7g %.7g\n" + "endloop\nendfacet"
    (folder / "text.stl").write_text("solid bone\n" + lines_of(soup.reshape(-1, 9), facet) + "endsolid bone\n")
    (folder / "text.obj").write_text(lines_of(vertices, "v %.7g %.7g %.7g") + lines_of(faces + 1, "f %d %d %d"))
    (folder / "text.off").write_text(f"OFF\n{len(vertices)} {len(faces)} 0\n" + points + corners)
    header = (f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")  # fmt: skip
    (folder / "text.ply").write_text("ply\nformat ascii 1.0\n" + header + points + corners)
    packed = np.zeros(len(faces), dtype=np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    packed["n"], packed["v"] = 3, faces
    binary = vertices.astype("<f4").tobytes() + packed.tobytes()
    (folder / "binary.ply").write_bytes(b"ply\nformat binary_little_endian 1.0\n" + header.encode() + binary)
    vtk = ("# vtk DataFile Version 3.0\nbone\n{}\nDATASET POLYDATA\n" + f"POINTS {len(vertices)} float\n",
           f"\nPOLYGONS {len(faces)} {4 * len(faces)}\n")  # fmt: skip
    (folder / "text.vtk").write_text(vtk[0].format("ASCII") + points + vtk[1] + corners)
    polygons = np.hstack([np.full((len(faces), 1), 3), faces]).astype(">i4").tobytes()
    (folder / "binary.vtk").write_bytes(
        vtk[0].format("BINARY").encode() + vertices.astype(">f4").tobytes() + vtk[1].encode() + polygons + b"\n")  # fmt: skip
    with zipfile.ZipFile(folder / "zip.3mf", "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("[Content_Types].xml", '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/'
                         'content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
                         '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')  # fmt: skip
        package.writestr("_rels/.rels", '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/'
                         'relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/'
                         '3dmanufacturing/2013/01/3dmodel"/></Relationships>')  # fmt: skip
        package.writestr("3D/3dmodel.model", '<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/'
                         '3dmanufacturing/core/2015/02"><resources><object id="1" type="model"><mesh><vertices>'
                         + lines_of(vertices, '<vertex x="%.7g" y="%.7g" z="%.7g"/>') + "</vertices><triangles>"
                         + lines_of(faces, '<triangle v1="%d" v2="%d" v3="%d"/>')
                         + '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>')  # fmt: skip
    shutil.copy(stl, folder / "binary.stl")
    write_vtp(vertices, faces, points, folder)
    for name in ("binary.stl", "text.stl", "text.obj", "text.off", "text.ply", "binary.ply", "text.vtk", "binary.vtk", "text.vtp",
                 "raw.vtp"):  # fmt: skip
        with open(folder / name, "rb") as plain, gzip.open(folder / (name + ".gz"), "wb", compresslevel=6) as packed_file:
            shutil.copyfileobj(plain, packed_file)


def peak_bytes(tool, mesh, work, folder):
    command = ["/usr/bin/time", "-f", "%M", tool, "slice", str(mesh), "--threads", "1", *work]
    done = subprocess.run(command, check=True, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    return 1024 * int(done.stderr.splitlines()[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool")
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--readme", type=pathlib.Path)
    arguments = parser.parse_args()
    tool = str(pathlib.Path(arguments.tool).resolve())
    lines = ["| format | bytes of file a triangle | " + " | ".join(WORK) + " |", "|" + "---|" * (len(WORK) + 2)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for path, triangles in (("bone.stl", arguments.triangles), ("bare.stl", BARE_TRIANGLES)):
            make = [tool, "make", "bone", "--triangles", str(triangles), "--height", "100", "-o", str(folder / path)]
            subprocess.run(make, check=True, stdout=subprocess.DEVNULL)
        bare = {what: peak_bytes(tool, "bare.stl", work, folder) for what, work in WORK.items()}
        triangles = ((folder / "bone.stl").stat().st_size - 84) // 50
        files = folder / "files"
        files.mkdir()
        write_formats(folder / "bone.stl", files)
        for file in sorted(files.iterdir()):
            cells = [f"{file.stat().st_size / triangles:.1f}"]
            cells += [f"{(peak_bytes(tool, file, work, folder) - bare[what]) / triangles:.0f}" for what, work in WORK.items()]
            lines.append(f"| {file.name} | " + " | ".join(cells) + " |")
    lines.append(f"\nBare process: {max(bare.values()) / 1e6:.0f} MB; {triangles:,} triangles.")
    table = "\n".join(lines)
    print(table)
    if arguments.readme:
        replace_table(arguments.readme, "batch memory", table + "\n")


if __name__ == "__main__":
    main()
