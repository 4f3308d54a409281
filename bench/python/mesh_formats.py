#!/usr/bin/python3
"""Writes a mesh in every format that the library reads, as common programs write it.

    bench/python/mesh_formats.py MESH.stl FOLDER

The files are named as benchmarks name the formats: stl_ascii.stl, vtp_zlib.vtp and so on. Decimals are the shortest that read
back as the same numbers. Needs numpy.
"""

import base64
import io
import pathlib
import struct
import sys
import zipfile
import zlib

import numpy as np

from meshes import STL_FACET, read_stl

VTP_BLOCK = 32768  # bytes, VTK's default
TYPES = ('<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension='
         '"model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')  # fmt: skip
RELATIONSHIPS = ('<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
                 '<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/'
                 '3dmodel"/></Relationships>')  # fmt: skip


def words_of(array):
    return [" ".join(row) for row in array.astype(str).tolist()]


class Mesh:
    """Vertices, faces, and both as lines of words."""

    def __init__(self, stl):
        self.vertices, self.faces = read_stl(stl)
        self.points, self.corners = words_of(self.vertices), words_of(self.faces)

    def lines(self, before_vertex, before_face):
        return "".join(before_vertex + row + "\n" for row in self.points) + "".join(before_face + row + "\n" for row in self.corners)


def stl_ascii(mesh):
    vertices = [f"  vertex {row}\n" for row in mesh.points]
    facets = (f"facet normal 0 0 0\n outer loop\n{vertices[a]}{vertices[b]}{vertices[c]} endloop\nendfacet\n"
              for a, b, c in mesh.faces.tolist())  # fmt: skip
    return "solid mesh\n" + "".join(facets) + "endsolid mesh\n"


def stl_binary(mesh):
    facets = np.zeros(len(mesh.faces), dtype=STL_FACET)
    facets["corners"] = mesh.vertices[mesh.faces]
    return b" " * 80 + struct.pack("<I", len(facets)) + facets.tobytes()


def obj(mesh):
    vertices = "".join(f"v {row}\n" for row in mesh.points)
    return "# a mesh\no mesh\n" + vertices + "".join(f"f {row}\n" for row in words_of(mesh.faces + 1))


def off(mesh):
    return f"OFF\n{len(mesh.vertices)} {len(mesh.faces)} 0\n" + mesh.lines("", "3 ")


def ply_header(mesh, form):
    return (f"ply\nformat {form} 1.0\nelement vertex {len(mesh.vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n")  # fmt: skip


def ply_ascii(mesh):
    return ply_header(mesh, "ascii") + mesh.lines("", "3 ")


def ply_binary(mesh, form, order):
    rows = np.zeros(len(mesh.faces), dtype=[("count", "u1"), ("corners", order + "i4", 3)])
    rows["count"], rows["corners"] = 3, mesh.faces
    return ply_header(mesh, form).encode() + mesh.vertices.astype(order + "f4").tobytes() + rows.tobytes()


def vtk_header(mesh, version, form):
    return f"# vtk DataFile Version {version}\nmesh\n{form}\nDATASET POLYDATA\nPOINTS {len(mesh.vertices)} float\n"


def vtk_ascii(mesh):
    """Three points a line, as VTK writes them."""
    points = "".join(row + (" \n" if i % 3 == 2 else " ") for i, row in enumerate(mesh.points))
    polygons = f"\nPOLYGONS {len(mesh.faces)} {4 * len(mesh.faces)}\n" + "".join(f"3 {row} \n" for row in mesh.corners)
    return vtk_header(mesh, "4.2", "ASCII") + points + polygons


def vtk_binary(mesh):
    """Each cell's number of corners, then the corners."""
    cells = np.hstack([np.full((len(mesh.faces), 1), 3), mesh.faces]).astype(">i4").tobytes()
    polygons = f"\nPOLYGONS {len(mesh.faces)} {4 * len(mesh.faces)}\n".encode()
    return vtk_header(mesh, "4.2", "BINARY").encode() + mesh.vertices.astype(">f4").tobytes() + polygons + cells + b"\n"


def vtk5_binary(mesh):
    """The offsets, then all corners."""
    offsets = np.arange(0, mesh.faces.size + 1, 3).astype(">i8").tobytes()
    polygons = f"\nPOLYGONS {len(mesh.faces) + 1} {mesh.faces.size}\nOFFSETS vtktypeint64\n".encode()
    points = vtk_header(mesh, "5.1", "BINARY").encode() + mesh.vertices.astype(">f4").tobytes()
    return points + polygons + offsets + b"\nCONNECTIVITY vtktypeint64\n" + mesh.faces.astype(">i8").tobytes()


def zlib_blocks(data):
    """A table of lengths, and the blocks."""
    blocks = [zlib.compress(data[at : at + VTP_BLOCK], 5) for at in range(0, len(data), VTP_BLOCK)]
    return struct.pack(f"<3Q{len(blocks)}Q", len(blocks), VTP_BLOCK, len(data) % VTP_BLOCK, *map(len, blocks)), b"".join(blocks)


def with_length(data):
    return struct.pack("<Q", len(data)) + data


def vtp(mesh, form, pack=with_length, attributes="", encoding="raw"):
    """XML polydata; the form is ascii, binary (base64 within the arrays' elements) or appended."""
    ends = np.arange(3, mesh.faces.size + 1, 3)
    arrays = [('type="Float32" Name="Points" NumberOfComponents="3"', mesh.points, mesh.vertices.astype("<f4")),
              ('type="Int64" Name="connectivity"', mesh.corners, mesh.faces.astype("<i8")),
              ('type="Int64" Name="offsets"', map(str, ends.tolist()), ends.astype("<i8"))]  # fmt: skip
    elements, appended = [], b""
    for what, words, array in arrays:
        if form == "appended":
            body = f' offset="{len(appended)}">'
            appended += pack(array.tobytes())
        else:
            body = ">\n" + ("\n".join(words) if form == "ascii" else base64.b64encode(pack(array.tobytes())).decode())
        elements.append(f'<DataArray {what} format="{form}"{body}\n</DataArray>\n')
    head = ('<?xml version="1.0"?><VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64"'
            f'{attributes}>\n<PolyData>\n<Piece NumberOfPoints="{len(mesh.vertices)}" NumberOfPolys="{len(mesh.faces)}">\n<Points>\n'
            f'{elements[0]}</Points>\n<Polys>\n{"".join(elements[1:])}</Polys>\n</Piece>\n</PolyData>\n')  # fmt: skip
    tail = f'<AppendedData encoding="{encoding}">\n_'.encode() + appended + b"\n</AppendedData>\n" if appended else b""
    return head.encode() + tail + b"</VTKFile>\n"


def vtp_zlib(mesh, encoding="base64"):
    encode = base64.b64encode if encoding == "base64" else bytes
    return vtp(mesh, "appended", lambda data: b"".join(map(encode, zlib_blocks(data))), ' compressor="vtkZLibDataCompressor"', encoding)


def threemf(mesh):
    vertices = "".join('<vertex x="{}" y="{}" z="{}"/>\n'.format(*row.split()) for row in mesh.points)
    triangles = "".join('<triangle v1="{}" v2="{}" v3="{}"/>\n'.format(*row.split()) for row in mesh.corners)
    model = ('<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/'
             'core/2015/02">\n<resources>\n<object id="1" type="model">\n<mesh>\n<vertices>\n' + vertices + "</vertices>\n<triangles>\n"
             + triangles + "</triangles>\n</mesh>\n</object>\n</resources>\n<build>\n<item objectid=\"1\"/>\n</build>\n</model>\n")  # fmt: skip
    package = io.BytesIO()
    with zipfile.ZipFile(package, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in (("[Content_Types].xml", TYPES), ("_rels/.rels", RELATIONSHIPS), ("3D/3dmodel.model", model)):
            archive.writestr(name, text)
    return package.getvalue()


FORMATS = {
    "stl_ascii.stl": stl_ascii, "obj.obj": obj, "off.off": off, "ply_ascii.ply": ply_ascii, "vtk_ascii.vtk": vtk_ascii,
    "vtp_ascii.vtp": lambda mesh: vtp(mesh, "ascii"), "stl_binary.stl": stl_binary,
    "ply_little_endian.ply": lambda mesh: ply_binary(mesh, "binary_little_endian", "<"),
    "ply_big_endian.ply": lambda mesh: ply_binary(mesh, "binary_big_endian", ">"),
    "vtk_binary.vtk": vtk_binary, "vtk5_binary.vtk": vtk5_binary, "vtp_raw.vtp": lambda mesh: vtp(mesh, "appended"),
    "vtp_base64.vtp": lambda mesh: vtp(mesh, "binary"),
    "vtp_zlib.vtp": vtp_zlib, "3mf.3mf": threemf,
}  # fmt: skip


def write(contents, path):
    path.write_bytes(contents.encode() if isinstance(contents, str) else contents)


def main():
    mesh, folder = Mesh(sys.argv[1]), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for name, form in FORMATS.items():
        write(form(mesh), folder / name)


if __name__ == "__main__":
    main()
