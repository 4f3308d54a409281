#!/usr/bin/env python3
"""Meshes that nibabel and VTK write, or read beside lamella: surfaces.py LAMELLA. Ends with 77 where nibabel, numpy or VTK is missing."""

import base64
import json
import struct

import support

numpy, nibabel, gltf, core, filters = support.need(
    "numpy", "nibabel", "vtkmodules.vtkIOGeometry", "vtkmodules.util.numpy_support", "vtkmodules.vtkFiltersGeometry"
)

BOX = numpy.array(support.box((10, 0, 0), (12, 2, 3)), dtype=numpy.float32)


def indexed(triangles):
    points, faces = numpy.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    return points, faces.reshape(-1, 3).astype(numpy.int32)


def triangles_of(path):
    rows = struct.iter_unpack("<12f2x", path.read_bytes()[84:])
    return numpy.array([row[3:] for row in rows], dtype=numpy.float32).reshape(-1, 3, 3)


def gifti_image(points, faces, encoding, order):
    kinds = (points, "POINTSET", "FLOAT32"), (faces, "TRIANGLE", "INT32")
    arrays = [
        nibabel.gifti.GiftiDataArray(data, intent=f"NIFTI_INTENT_{intent}", datatype=f"NIFTI_TYPE_{kind}", encoding=f"GIFTI_ENCODING_{encoding}", ordering=order)
        for data, intent, kind in kinds
    ]
    return nibabel.gifti.GiftiImage(darrays=arrays)


def scene(points, faces):
    """A scene of two boxes under a turned, scaled and mirrored node, as JSON with a buffer of base64, and as one file."""
    data = points.astype("<f4").tobytes() + faces.astype("<u2").tobytes()
    views = [{"buffer": 0, "byteLength": points.nbytes}, {"buffer": 0, "byteOffset": points.nbytes, "byteLength": 2 * faces.size}]
    low, high = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": low, "max": high},
        {"bufferView": 1, "componentType": 5123, "count": faces.size, "type": "SCALAR"},
    ]
    half = 0.5**0.5
    nodes = [
        {"children": [1, 2], "translation": [1, 2, 3], "rotation": [0, half, 0, half], "scale": [1, -2, 0.5]},
        {"mesh": 0, "name": "first"},
        {"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 30, 1]},
    ]
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes, "accessors": accessors, "bufferViews": views}
    document["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    document["buffers"] = [{"byteLength": len(data)}]
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    chunks = struct.pack("<I4s", len(words), b"JSON") + words + struct.pack("<I4s", len(data), b"BIN\0") + data
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(document, indent=1).encode(), struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def by_vtk(path):
    reader = gltf.vtkGLTFReader()
    reader.SetFileName(str(path))
    surface = filters.vtkCompositeDataGeometryFilter()
    surface.SetInputConnection(reader.GetOutputPort())
    surface.Update()
    mesh = surface.GetOutput()
    corners = core.vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return core.vtk_to_numpy(mesh.GetPoints().GetData())[corners]


def volume(triangles):
    return numpy.linalg.det(triangles.astype(float)).sum() / 6


def test(run):
    points, faces = indexed(BOX)
    files = {"lh.pial": lambda path: nibabel.freesurfer.write_geometry(path, points, faces)}
    for encoding, order in (("ASCII", "RowMajorOrder"), ("B64BIN", "RowMajorOrder"), ("B64BIN", "ColumnMajorOrder"), ("B64GZ", "ColumnMajorOrder")):
        files[f"{encoding}{order}.surf.gii"] = lambda path, form=(encoding, order): nibabel.save(gifti_image(points, faces, *form), path)
    for name, write in files.items():
        write(str(run.folder / name))
        run("convert", name, "-o", "out.stl")
        assert numpy.array_equal(triangles_of(run.folder / "out.stl"), points[faces]), name
    for name, data in zip(("a.gltf", "a.glb"), scene(points, faces)):
        (run.folder / name).write_bytes(data)
        run("convert", name, "-o", "out.stl")
        own, other = triangles_of(run.folder / "out.stl"), by_vtk(run.folder / name)
        assert own.shape == other.shape == (24, 3, 3), name
        assert abs(numpy.sort(own.mean(axis=1), axis=0) - numpy.sort(other.mean(axis=1), axis=0)).max() < 1e-5, name
        assert abs(volume(own) - 24) < 1e-4, name  # two boxes of 12, which face outwards though mirrored
    return f"{len(files)} files of nibabel, 2 of glTF as VTK reads them"


support.main(test)
