"""Meshes in every form, and what is said of those that are none."""

import pathlib
import types
import zipfile

import numpy as np
import pytest
from support import write_off

import lamella
from lamella._mesh import as_view


def hash_of(*mesh, **options):
    return lamella.slice(*mesh, layer_height=0.7, **options).hash


@pytest.mark.parametrize("coordinates", ["f4", "f8", "i4", "i8", "f2", "i2", "u2", "u4", "u8", ">f4", ">i8"])
@pytest.mark.parametrize("indices", ["i4", "u4", "i8", "u8", "i2", "u1", ">i4"])
def test_all_number_types_give_the_same_slice(cube, coordinates, indices):
    vertices, faces = cube
    assert hash_of(vertices.astype(coordinates), faces.astype(indices)) == hash_of(vertices, faces)


def test_lists_of_numbers_are_meshes(cube):
    vertices, faces = cube
    assert hash_of(vertices.tolist(), faces.tolist()) == hash_of(vertices, faces)
    assert hash_of(vertices[faces].tolist()) == hash_of(vertices, faces)


def padded(array, front, back):
    """The same numbers within wider rows."""
    wide = np.full((len(array), front + array.shape[1] + back), 77, dtype=array.dtype)
    wide[:, front : front + array.shape[1]] = array
    return wide[:, front : front + array.shape[1]]


@pytest.mark.parametrize("dtype", ["f4", "f8", "i4", "i8"])
def test_strided_rows_are_read_where_they_lie(torus, dtype):
    vertices, faces = torus
    vertices = (8 * vertices).astype(dtype)
    expected = hash_of(vertices, faces)
    assert hash_of(padded(vertices, 2, 1), padded(faces, 1, 3)) == expected
    assert hash_of(np.repeat(vertices, 2, axis=0)[::2], np.repeat(faces, 3, axis=0)[::3]) == expected
    assert hash_of(np.asfortranarray(vertices), np.asfortranarray(faces)) == expected
    assert hash_of(vertices[::-1][::-1], faces) == expected
    assert hash_of(vertices[::-1], len(vertices) - 1 - faces) == expected


@pytest.mark.parametrize("coordinates", ["f4", "f8", "i4", "i8"])
@pytest.mark.parametrize("indices", ["i4", "u4", "i8", "u8"])
def test_what_the_engine_can_read_is_not_copied(cube, coordinates, indices):
    vertices, faces = padded(cube[0].astype(coordinates), 1, 1), padded(cube[1].astype(indices), 0, 2)
    triangles = np.repeat(cube[0][cube[1]].astype(coordinates), 2, axis=0)[::2]
    led = np.insert(cube[1].astype(indices), 0, 3, axis=1).ravel()

    def read(*mesh):
        return as_view(*mesh, unit=None)._meshes[0]

    assert np.shares_memory(read(vertices, faces).vertices, vertices)
    assert np.shares_memory(read(vertices, faces).faces, faces)
    assert np.shares_memory(read(triangles, None).vertices, triangles)
    assert np.shares_memory(read(types.SimpleNamespace(points=vertices, faces=led), None).faces, led)


def test_unaligned_numbers_are_read(cube):
    vertices, faces = cube
    raw = np.zeros(vertices.nbytes + 1, dtype="u1")
    raw[1:] = np.frombuffer(vertices.tobytes(), dtype="u1")
    odd = raw[1:].view("f8").reshape(-1, 3)
    assert not odd.flags.aligned
    assert hash_of(odd, faces) == hash_of(vertices, faces)


@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_triangles_of_any_layout_are_read(torus, dtype):
    vertices, faces = torus
    triangles = vertices[faces].astype(dtype)
    expected = hash_of(vertices.astype(dtype), faces)
    wide = np.zeros((len(triangles), 4, 3), dtype=dtype)
    wide[:, 1:] = triangles
    assert hash_of(triangles) == expected
    assert hash_of(triangles.reshape(-1, 9)) == expected
    assert hash_of(wide[:, 1:]) == expected
    assert hash_of(np.asfortranarray(triangles)) == expected
    assert hash_of(np.repeat(triangles, 2, axis=0)[::2]) == expected
    assert hash_of(triangles[::-1]) == expected


def test_read_only_arrays_are_read(cube):
    for array in cube:
        array.setflags(write=False)
    assert len(lamella.slice(*cube)) == 50


def test_objects_with_vertices_and_faces_are_meshes(cube):
    assert hash_of(types.SimpleNamespace(vertices=cube[0], faces=cube[1])) == hash_of(*cube)


def test_meshes_of_meshio_are_read(cube):
    vertices, faces = cube
    block = types.SimpleNamespace(type="triangle", data=faces)
    edges = types.SimpleNamespace(type="line", data=faces[:, :2])
    assert hash_of(types.SimpleNamespace(points=vertices, cells=[edges, block])) == hash_of(vertices, faces)
    assert hash_of(types.SimpleNamespace(points=vertices, cells={"triangle": faces})) == hash_of(vertices, faces)
    halves = [types.SimpleNamespace(type="triangle", data=half) for half in (faces[:5], faces[5:])]
    assert hash_of(types.SimpleNamespace(points=vertices, cells=halves)) == hash_of(vertices, faces)
    quads = types.SimpleNamespace(type="quad", data=faces)
    with pytest.raises(lamella.InvalidArgumentError, match="must be triangles, and are quad"):
        lamella.slice(types.SimpleNamespace(points=vertices, cells=[block, quads]))


def test_meshio_itself_is_understood(cube):
    meshio = pytest.importorskip("meshio")
    assert hash_of(meshio.Mesh(cube[0], [("triangle", cube[1])])) == hash_of(*cube)


def test_meshes_of_pyvista_are_read(cube):
    vertices, faces = cube
    led = np.insert(faces, 0, 3, axis=1)
    assert hash_of(types.SimpleNamespace(points=vertices, faces=led.ravel())) == hash_of(vertices, faces)
    assert hash_of(types.SimpleNamespace(points=vertices, faces=led)) == hash_of(vertices, faces)
    assert hash_of(types.SimpleNamespace(points=vertices, cells=led.ravel())) == hash_of(vertices, faces)
    led[4, 0] = 4
    with pytest.raises(lamella.InvalidArgumentError, match="face 4 does not have 3 corners"):
        lamella.slice(types.SimpleNamespace(points=vertices, faces=led.ravel()))
    with pytest.raises(lamella.InvalidArgumentError, match="face 11 does not have 3 corners"):
        lamella.slice(types.SimpleNamespace(points=vertices, faces=np.insert(faces, 0, 3, axis=1).ravel()[:-1]))


def test_files_are_meshes(cube, tmp_path):
    path = tmp_path / "cube.off"
    write_off(path, *cube)
    assert hash_of(pathlib.Path(path)) == hash_of(str(path)) == hash_of(lamella.read(path)) == hash_of(*cube)


def test_units_scale_coordinates(cube):
    vertices, faces = cube
    centimetres = lamella.slice(vertices / 10, faces, unit="cm", layer_height=1)
    assert centimetres.areas == pytest.approx([100] * 10)
    assert lamella.slice(vertices, faces, unit=0.5, layer_height=1).areas == pytest.approx([25] * 5)
    welded = lamella.weld(vertices / 10, faces, unit="cm")
    assert lamella.slice(welded, heights=[5]).areas == pytest.approx([100])
    assert lamella.slice(welded, heights=[0.5], unit="mm").areas == pytest.approx([1])
    assert lamella.prepare(vertices, faces, unit="cm").slice([50]).areas == pytest.approx([10000])


SHAPES = [
    (lambda v, f: (v,), r"vertices of shape \(8, 3\) need faces"),
    (lambda v, f: (v[:, :2], f), r"vertices must have shape \(n, 3\), and have \(8, 2\)"),
    (lambda v, f: (v, f[:, :2]), r"faces must have shape \(n, 3\), and have \(12, 2\)"),
    (lambda v, f: (v, f.ravel()), r"faces must have shape \(n, 3\), and have \(36,\)"),
    (lambda v, f: (v[f][:, :, :2],), r"triangles must have shape"),
    (lambda v, f: (v, f.astype(float)), "faces must be integers, and are of dtype float64"),
    (lambda v, f: (v.astype(complex), f), "vertices must be numbers, and are of dtype complex128"),
    (lambda v, f: (v > 1, f), "vertices must be numbers, and are of dtype bool"),
    (lambda v, f: (np.array([["a", "b", "c"]]), f), "vertices must be numbers"),
    (lambda v, f: ([[0, 0, 0], [1, 1], [2, 2, 2]], f), r"vertices\[1\] has 2 numbers, the rows before it 3"),
    (lambda v, f: ("cube.stl", f), "faces are for arrays"),
]


@pytest.mark.parametrize("change, message", SHAPES)
def test_wrong_shapes_and_types_are_named(cube, change, message):
    with pytest.raises(ValueError, match=message) as raised:
        lamella.slice(*change(*cube))
    assert isinstance(raised.value, lamella.InvalidArgumentError)


def test_what_is_no_mesh_is_a_type_error():
    with pytest.raises(TypeError, match="int is no mesh") as raised:
        lamella.slice(3)
    assert isinstance(raised.value, lamella.MeshTypeError)


TYPES = (
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)


def test_a_file_that_states_its_unit_keeps_it(tmp_path, cube):
    rows = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in cube[0].tolist())
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in cube[1].tolist())
    model = (
        '<model unit="centimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>'
        f'<object id="1"><mesh><vertices>{rows}</vertices><triangles>{faces}</triangles></mesh></object></resources>'
        '<build><item objectid="1"/></build></model>'
    )
    relation = 'Id="r" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"'
    space = "http://schemas.openxmlformats.org/package/2006/relationships"
    with zipfile.ZipFile(tmp_path / "cube.3mf", "w") as package:
        package.writestr("[Content_Types].xml", TYPES)
        package.writestr("_rels/.rels", f'<Relationships xmlns="{space}"><Relationship {relation}/></Relationships>')
        package.writestr("3D/3dmodel.model", model)
    assert lamella.read(tmp_path / "cube.3mf").info["parts"] == [{"name": "object 1", "role": "solid", "first_triangle": 0, "triangles": 12}]
    for mesh in (tmp_path / "cube.3mf", lamella.read(tmp_path / "cube.3mf")):
        assert lamella.slice(mesh, unit="in", heights=[50]).areas == pytest.approx([10000])


@pytest.mark.parametrize("wrong", [8, -1, 2**31 - 1])
@pytest.mark.parametrize("dtype", ["i4", "i8"])
def test_an_index_out_of_range_is_named_by_row(cube, wrong, dtype):
    vertices, faces = cube
    faces = faces.astype(dtype)
    faces[7, 2] = wrong
    with pytest.raises(lamella.InvalidArgumentError) as raised:
        lamella.slice(vertices, faces)
    assert raised.value.triangle == 7
    assert str(raised.value) == f"faces[7] = {faces[7].tolist()}: there are 8 vertices"


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 2e9])
def test_a_bad_coordinate_is_named_by_row(cube, wrong):
    vertices, faces = cube
    vertices[5, 1] = wrong
    first = int(np.flatnonzero((faces == 5).any(axis=1))[0])
    with pytest.raises(lamella.CoordinateError, match=r"vertices\[5\] = \[10.0, ") as raised:
        lamella.slice(vertices, faces)
    assert (raised.value.triangle, raised.value.vertex) == (first, 5)
    with pytest.raises(lamella.CoordinateError, match=f"triangle {first}") as raised:
        lamella.slice(vertices[faces])
    assert raised.value.triangle == first


def test_a_bad_coordinate_beside_a_bad_index_is_named(cube):
    vertices, faces = cube
    vertices[1, 0] = np.nan
    faces[0] = 0, 1, 99
    for call in (lamella.slice, lamella.weld, lamella.check):
        with pytest.raises(ValueError, match=r"faces\[0\]|vertices\[1\]") as raised:
            call(vertices, faces)
        assert raised.value.triangle == 0


@pytest.mark.parametrize("dtype", ["i4", "i8", "f4", "f8"])
def test_no_call_reads_beyond_the_vertices(cube, dtype):
    vertices, faces = cube[0].astype(dtype), cube[1].astype("u4")
    faces[3, 2] = 2**32 - 1
    for call in (lamella.slice, lamella.weld, lamella.check, lamella.prepare):
        with pytest.raises(lamella.InvalidArgumentError, match=r"faces\[3\]"):
            call(vertices, faces)


def test_a_mesh_without_triangles_is_an_error_unless_allowed(cube):
    none = cube[0], np.empty((0, 3), dtype=int)
    with pytest.raises(lamella.EmptyMeshError):
        lamella.slice(*none)
    assert len(lamella.slice(*none, heights=[1, 2], allow_empty=True)) == 2
