"""Meshes in every form; what is refused, by which error and in which words."""

import pickle
import types

import numpy as np
import pytest
from support import led

import lamella
from lamella import InvalidArgumentError
from lamella._mesh import as_view


def hash_of(*mesh, **options):
    return lamella.slice(*mesh, layer_height=0.7, **options).hash


@pytest.mark.parametrize("coordinates", ["f4", "f8", "i4", "i8", "f2", "i2", "u2", "u4", "u8", ">f4", ">i8"])
@pytest.mark.parametrize("indices", ["i4", "u4", "i8", "u8", "i2", "u1", ">i4"])
def test_all_number_types_give_the_same_slice(cube, coordinates, indices):
    vertices, faces = cube
    assert hash_of(vertices.astype(coordinates), faces.astype(indices)) == hash_of(vertices, faces)


def padded(array, front, back):
    """The same numbers within wider rows."""
    wide = np.full((len(array), front + array.shape[1] + back, *array.shape[2:]), 77, dtype=array.dtype)
    wide[:, front : front + array.shape[1]] = array
    return wide[:, front : front + array.shape[1]]


def unaligned(array):
    raw = np.zeros(array.nbytes + 1, dtype="u1")
    raw[1:] = np.frombuffer(array.tobytes(), dtype="u1")
    assert not raw[1:].view(array.dtype).flags.aligned
    return raw[1:].view(array.dtype).reshape(array.shape)


def read_only(array):
    array.setflags(write=False)
    return array


def with_cells(vertices, *blocks):
    """As meshio has them."""
    return types.SimpleNamespace(points=vertices, cells=[types.SimpleNamespace(type=kind, data=data) for kind, data in blocks])


FORMS = {
    "pair": lambda v, f: ((v, f),),
    "read_only": lambda v, f: (read_only(v), read_only(f)),
    "unaligned": lambda v, f: (unaligned(v), f),
    "wide_rows": lambda v, f: (padded(v, 2, 1), padded(f, 1, 3)),
    "rows_apart": lambda v, f: (np.repeat(v, 2, axis=0)[::2], np.repeat(f, 3, axis=0)[::3]),
    "columns": lambda v, f: (np.asfortranarray(v), np.asfortranarray(f)),
    "backwards": lambda v, f: (v[::-1], len(v) - 1 - f),
    "triangles": lambda v, f: (v[f],),
    "triangles_of_9": lambda v, f: (v[f].reshape(-1, 9),),
    "triangles_in_wide_rows": lambda v, f: (padded(v[f], 1, 0),),
    "triangles_by_columns": lambda v, f: (np.asfortranarray(v[f]),),
    "triangles_apart": lambda v, f: (np.repeat(v[f], 2, axis=0)[::2],),
    "triangles_backwards": lambda v, f: (v[f][::-1],),
    "trimesh": lambda v, f: (types.SimpleNamespace(vertices=v, faces=f),),
    "meshio": lambda v, f: (with_cells(v, ("line", f[:, :2]), ("triangle", f)),),
    "meshio_in_blocks": lambda v, f: (with_cells(v, ("triangle", f[:5]), ("triangle", f[5:])),),
    "meshio_dict": lambda v, f: (types.SimpleNamespace(points=v, cells={"triangle": f}),),
    "meshio_itself": lambda v, f: (pytest.importorskip("meshio").Mesh(v, [("triangle", f)]),),
    "pyvista": lambda v, f: (types.SimpleNamespace(points=v, faces=led(f).ravel()),),
    "pyvista_rows": lambda v, f: (types.SimpleNamespace(points=v, faces=led(f)),),
    "pyvista_cells": lambda v, f: (types.SimpleNamespace(points=v, cells=led(f).ravel()),),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("dtype", ["f4", "f8", "i4", "i8"])
def test_every_form_is_read(torus, form, dtype):
    vertices, faces = (8 * torus[0]).astype(dtype), torus[1]
    expected = hash_of(vertices.copy(), faces.copy())
    assert hash_of(*FORMS[form](vertices, faces)) == expected


def test_lists_are_meshes(cube):
    vertices, faces = cube
    assert hash_of(vertices.tolist(), faces.tolist()) == hash_of(vertices[faces].tolist()) == hash_of(*cube)


@pytest.mark.parametrize("coordinates", ["f4", "f8", "i4", "i8"])
@pytest.mark.parametrize("indices", ["i4", "u4", "i8", "u8"])
def test_what_the_engine_can_read_is_not_copied(cube, coordinates, indices):
    vertices, faces = padded(cube[0].astype(coordinates), 1, 1), padded(cube[1].astype(indices), 0, 2)
    triangles = np.repeat(cube[0][cube[1]].astype(coordinates), 2, axis=0)[::2]
    flat = led(cube[1].astype(indices)).ravel()

    def read(*mesh):
        return as_view(*mesh, unit=None)._meshes[0]

    assert np.shares_memory(read(vertices, faces)._vertices, vertices)
    assert np.shares_memory(read(vertices, faces)._faces, faces)
    assert np.shares_memory(read(triangles, None)._vertices, triangles)
    assert np.shares_memory(read(types.SimpleNamespace(points=vertices, faces=flat), None)._faces, flat)


def test_units_scale_coordinates(cube):
    vertices, faces = cube
    centimetres = lamella.slice(vertices / 10, faces, unit="cm", layer_height=1)
    assert centimetres.areas == pytest.approx([100] * 10)
    assert lamella.slice(vertices, faces, unit=0.5, layer_height=1).areas == pytest.approx([25] * 5)
    welded = lamella.weld(vertices / 10, faces, unit="cm")
    assert lamella.slice(welded, heights=[5]).areas == pytest.approx([100])
    assert lamella.slice(welded, heights=[0.5], unit="mm").areas == pytest.approx([1])
    assert lamella.prepare(vertices, faces, unit="cm").slice([50]).areas == pytest.approx([10000])


def test_parts_of_a_file_are_listed(tmp_path, cube):
    rows = [f"v {x} {y} {z}" for x, y, z in cube[0].tolist()] + ["o left"] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in cube[1].tolist()]
    (tmp_path / "cube.obj").write_text("\n".join([*rows[:14], "o right", *rows[14:]]) + "\n")
    assert lamella.read(tmp_path / "cube.obj").info["parts"] == [
        {"name": "left", "role": "solid", "first_triangle": 0, "triangles": 5},
        {"name": "right", "role": "solid", "first_triangle": 5, "triangles": 7},
    ]


def test_a_mesh_that_states_its_unit_keeps_it(cube):
    for states_unit, area in ((True, 10000), (False, 254**2)):
        mesh = lamella.Mesh(*cube, 10, None, {"states_unit": states_unit})
        assert lamella.slice(mesh, unit="in", heights=[50]).areas == pytest.approx([area])


LOW = np.array([[0, 0], [4, 0], [4, 4], [0, 4]])
SEGMENTS = np.stack((LOW, np.roll(LOW, -1, axis=0)), axis=1).astype(float)
BROKEN = np.concatenate((SEGMENTS[:2], [[[np.nan, 0], [0, 0]]]))


def points_with(points, **cells):
    return types.SimpleNamespace(points=points, **cells)


# Options of slice().
OPTIONS = [
    ({"fill_rule": "nonzero"}, "fill_rule must be one of 'contours', 'even-odd', 'non-zero', 'positive', 'outermost'"),
    ({"side": 1}, "side must be one of 'below', 'above', not 1"),
    ({"unit": "km"}, "unit must be a number of mm or one of 'mm', 'um'"),
    ({"unit": 0}, "unit must be finite and more than 0 mm"),
    ({"grid": "fine"}, "grid must be a number or 'finest', not 'fine'"),
    ({"stitch": -1}, "stitch must be at least 0, and is -1"),
    ({"layer_height": 0}, "layer_height must be more than 0, and is 0"),
    ({"layer_height": 10**400}, "layer_height must be a number that 64 bits hold"),
    ({"layer_height": "0.2"}, "layer_height must be a number, not '0.2'"),
    ({"layer_height": 0.2, "heights": [1]}, "heights and layer_height exclude each other"),
    ({"layer_height": 0.2, "slabs": [[0, 1]]}, "slabs and layer_height exclude each other"),
    ({"slabs": [0, 1]}, r"slabs must have shape \(n, 2\), and have \(2,\)"),
    ({"heights": [[1]]}, r"heights must have one dimension, and have shape \(1, 1\)"),
    ({"heights": ["a"]}, "heights must be numbers"),
    ({"layers": 3}, "layers must be the first one and one past the last"),
    ({"normal": [0, 0, 0]}, "normal must be three finite numbers, not all 0"),
    ({"normal": [0, 0, 1], "transform": np.eye(4)}, "normal and transform exclude each other"),
    ({"transform": np.eye(3)}, r"transform must have shape \(4, 4\) or \(3, 4\), and has \(3, 3\)"),
    ({"transform": np.full((4, 4), np.nan)}, r"transform\[0, 0\] is nan"),
    ({"transform": np.diag([1, 1, 0, 1])}, "the transform is singular: its determinant is 0"),
    ({"transform": np.ones((4, 4))}, "the last row of transform must be 0 0 0 1"),
    ({"fill_from": [3]}, "fill_from must be pairs"),
    ({"fill_from": [(3, "odd")]}, "a rule of fill_from must be one of"),
    ({"threads": -1}, "threads must not be negative"),
    ({"threads": 1.5}, "threads must be a whole number"),
    ({"origins": 1}, "origins must be True or False"),
    ({"closing": 1, "fill_rule": "contours"}, "closing needs a region"),
    ({"offset": np.nan, "fill_rule": "non-zero"}, "offset"),
    ({"progress": 7}, "progress must be True or a callable that takes a fraction, not 7"),
    ({"layer_heigth": 1}, "no option 'layer_heigth'; is it 'layer_height'"),
]

# Meshes, by vertices and faces of a cube.
MESHES = [
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
    (lambda v, f: (points_with(v, cells={"triangle": f, "quad": f}),), "must be triangles, and are quad"),
    (lambda v, f: (points_with(v, faces=led(f, 4, 4).ravel()),), "face 4 does not have 3 corners"),
    (lambda v, f: (points_with(v, faces=led(f).ravel()[:-1]),), "face 11 does not have 3 corners"),
]

# Other calls, of a cube.
CALLS = [
    (lambda cube: lamella.slice_parts([cube, cube], transforms=[None]), InvalidArgumentError, "2 meshes and 1 transforms"),
    (lambda cube: lamella.slice_parts([cube], roles=["hole"]), InvalidArgumentError, "must be one of solid, negative"),
    (lambda cube: lamella.slice_parts([cube], objects=[1, 2]), InvalidArgumentError, "1 meshes and 2 objects"),
    (lambda cube: lamella.slice_parts(5), InvalidArgumentError, "meshes must be a sequence of them, not 5"),
    (lambda cube: lamella.slice_parts([]), InvalidArgumentError, ""),
    (lambda cube: lamella.slice_parts([cube, cube]).certificate, InvalidArgumentError, "one mesh, and there are 2"),
    (lambda cube: lamella.stream(*cube, chunk=0), InvalidArgumentError, "at least one layer"),
    (lambda cube: lamella.section(cube, [0] * 3, [0, 0, 1], transform=1), InvalidArgumentError, "transform is given by"),
    (lambda cube: lamella.section(cube, [0, 0], [0, 0, 1]), InvalidArgumentError, "origin must be three"),
    (lambda cube: lamella.prepare(*cube).slice(layer_heigth=1), InvalidArgumentError, "'layer_heigth'; is it 'layer_height'"),
    (lambda cube: lamella.prepare(*cube).slice(grid=1), InvalidArgumentError, "grid is for prepare"),
    (lambda cube: lamella.prepare(*cube, closing=1), InvalidArgumentError, "closing is an option of slice.. that this call"),
    (lambda cube: lamella.check(*cube, layer_height=1), InvalidArgumentError, "layer_height is an option of slice.. that this"),
    (lambda cube: lamella.check(*cube, gird=1), InvalidArgumentError, "no option 'gird'; is it 'grid'"),
    (lambda cube: lamella.region_of([LOW], stitch=1), InvalidArgumentError, "stitch is an option of slice.. that this call"),
    (lambda cube: lamella.slice(*cube, layer_height=1e-9), lamella.PlanesError, "under two grid units"),
    (lambda cube: lamella.slice(*cube, layer_height=0.01, memory_limit=1000), lamella.ResultTooLargeError, ""),
    (lambda cube: lamella.slice(cube[0], np.empty((0, 3), dtype=int)), lamella.EmptyMeshError, ""),
    (lambda cube: lamella.slice(3), lamella.MeshTypeError, "int is no mesh"),
    (lambda cube: pickle.dumps(lamella.prepare(*cube)), TypeError, "pickle the mesh, and prepare it where it is sliced"),
    (lambda cube: lamella.assemble(SEGMENTS, [[0, 1]]), InvalidArgumentError, r"keys must be integers of shape \(4, 2\)"),
    (lambda cube: lamella.assemble(BROKEN), lamella.CoordinateError, r"segments\[2\]"),
    (lambda cube: lamella.region_of([LOW], closing=-1), InvalidArgumentError, "closing must be at least 0"),
    (lambda cube: lamella.region_of([LOW], grid=0), InvalidArgumentError, "grid must be finite"),
    (lambda cube: lamella.region_of([LOW, [*LOW, [1e9, 1]]]), lamella.CoordinateError, r"contours\[1\]\[4\] has a coordinate"),
    (lambda cube: lamella.region_of(LOW), InvalidArgumentError, r"contours\[0\] must have shape \(n, 2\)"),
]


REFUSED = [
    *((lambda cube, options=options: lamella.slice(*cube, **options), InvalidArgumentError, message) for options, message in OPTIONS),
    *((lambda cube, mesh=mesh: lamella.slice(*mesh(*cube)), InvalidArgumentError, message) for mesh, message in MESHES),
    *CALLS,
]


@pytest.mark.parametrize("call, error, message", REFUSED)
def test_what_is_wrong_is_refused_and_named(cube, call, error, message):
    with pytest.raises(error, match=message):
        call(cube)


def test_errors_are_of_the_kinds_of_python():
    kinds = {"InvalidArgument": ValueError, "MeshType": TypeError, "UnreadableFile": OSError, "UnwritableFile": OSError, "ResultTooLarge": MemoryError}
    assert all(issubclass(getattr(lamella, f"{name}Error"), kind) for name, kind in kinds.items())


@pytest.mark.parametrize("wrong", [8, -1, 2**31 - 1])
@pytest.mark.parametrize("dtype", ["i4", "i8"])
@pytest.mark.parametrize("call", [lamella.slice, lamella.weld, lamella.check, lamella.prepare])
def test_an_index_out_of_range_is_named_by_row(cube, wrong, dtype, call):
    vertices, faces = cube[0].astype(dtype), cube[1].astype(dtype)
    faces[7, 2] = wrong
    with pytest.raises(InvalidArgumentError) as raised:
        call(vertices, faces)
    same = pickle.loads(pickle.dumps(raised.value))
    for error in (raised.value, same):
        assert (type(error), error.triangle, error.vertex, error.code) == (InvalidArgumentError, 7, None, "invalid_argument")
        assert str(error) == f"faces[7] = {faces[7].tolist()}: there are 8 vertices"
    with pytest.raises(InvalidArgumentError, match=r"faces\[7\]"):
        call(vertices, np.where(faces == wrong, 2**32 - 1, faces).astype("u4"))


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 2e9])
def test_a_bad_coordinate_is_named_by_row(cube, wrong):
    vertices, faces = cube
    vertices[5, 1] = wrong
    first = int(np.flatnonzero((faces == 5).any(axis=1))[0])
    for call in (lamella.slice, lambda *mesh: next(lamella.stream(*mesh))):
        with pytest.raises(lamella.CoordinateError, match=r"vertices\[5\] = \[10.0, ") as raised:
            call(vertices, faces)
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


def test_a_height_that_is_no_number_is_named_by_its_index(cube):
    with pytest.raises(lamella.PlanesError) as raised:
        lamella.slice(*cube, heights=[1, 2, np.nan])
    assert raised.value.layer == 2


def test_bad_files_are_named(tmp_path):
    (tmp_path / "bad.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 3\n")
    for name, error in (("nothing.stl", lamella.UnreadableFileError), ("bad.ply", lamella.MalformedMeshError)):
        for call in (lamella.slice, lamella.read):
            with pytest.raises(error, match=name) as raised:
                call(tmp_path / name)
            assert raised.value.path == str(tmp_path / name)
