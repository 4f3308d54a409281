"""Meshes in every form."""

import types

import numpy as np
import pytest
from support import led

import lamella
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

