"""What is refused, by which error and in which words."""

import pickle
import types

import numpy as np
import pytest
from support import led

import lamella
from lamella import InvalidArgumentError

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
