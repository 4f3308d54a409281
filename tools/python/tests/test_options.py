"""Options: what they do is the engine's tests' to show; that each arrives, and what is refused, is shown here."""

import inspect
import pickle

import numpy as np
import pytest

import lamella
from lamella._option_table import OPTIONS


def test_given_heights_come_in_any_order_and_shape(cube):
    s = lamella.slice(*cube, heights=[7, 2, 7, 5])
    assert s.layers["z"].tolist() == [2, 5, 7]
    assert s.layer_of.tolist() == [2, 0, 2, 1]
    assert lamella.slice(*cube, heights=5).layers["z"].tolist() == [5]
    assert lamella.slice(*cube, heights=np.arange(10)[::-2]).layers["z"].tolist() == [1, 3, 5, 7, 9]
    assert len(lamella.slice(*cube, heights=[])) == 0


# For each keyword a value, and what the engine's members hold then.
ARRIVING = {
    "layer_height": (2, {"layer_height_mm": 2}),
    "heights": ([7, 2], {"heights_mm": [7, 2]}),
    "stitch": (0.5, {"stitch_mm": 0.5}),
    "stitch_direction": ("any", {"stitch_direction": 1}),
    "origins": (True, {"origins": True}),
    "unite_parts": (True, {"unite_parts": True}),
    "allow_empty": (True, {"allow_empty": True}),
    "first_height": (0.5, {"first_height_mm": 0.5}),
    "datum": ("zero", {"datum": 1}),
    "side": ("above", {"side": 1}),
    "layers": ((1, 3), {"first_layer": 1, "end_layer": 3}),
    "transform": (np.diag([2, 2, 2, 1]), {"transform": np.diag([2, 2, 2, 1])[:3].tolist()}),
    "grid": (2.0**-19, {"grid_mm": 2.0**-19}),
    "coarser_if_needed": (True, {"coarser_if_needed": True}),
    "fill_rule": ("positive", {"fill_rule": 3}),
    "closing": (0.25, {"closing_mm": 0.25}),
    "offset": (-0.25, {"offset_mm": -0.25}),
    "miter_limit": (2, {"miter_limit": 2}),
    "simplify": (0.125, {"simplify_mm": 0.125}),
    "flag_closing": (0.125, {"flag_closing_mm": 0.125}),
    "drop_collinear": (True, {"drop_collinear": True}),
    "largest_only": (True, {"largest_only": True}),
    "fill_from": ([(2, "even-odd")], {"fill_from": [(2, 1)]}),
}


def options_of(result):
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in result._native.options.items()}


@pytest.mark.parametrize("name", sorted(OPTIONS.keys() - {"content"}))  # which the next test shows
def test_each_option_arrives(cube, name):
    value, expected = ARRIVING[name]
    defaults, given = (options_of(lamella.slice(*cube, **{"stitch": 0, **options})) for options in ({}, {name: value}))
    assert set(expected) == set(OPTIONS[name].fields)
    assert given == {**defaults, **expected}
    assert all(defaults[field] != value for field, value in expected.items())


@pytest.mark.parametrize("content", ["upward-faces", "downward-faces"])
def test_faces_are_projected_onto_layers(cube, content):
    assert lamella.slice(*cube, heights=[3, 5, 12], content=content).areas == pytest.approx(
        [0, 100, 0] if content == "upward-faces" else [100, 0, 0]
    )


def test_options_are_shown_by_help():
    shown = inspect.signature(lamella.slice).parameters
    assert {*OPTIONS, "mesh", "faces", "unit", "normal", "orient_shells", "memory_limit", "threads", "progress"} == set(shown)
    assert (shown["fill_rule"].default, shown["stitch"].default, shown["heights"].default) == ("non-zero", "auto", None)
    assert all(f"\n    {name} : " in lamella.slice.__doc__ for name in shown)
    assert 'stitch : float or \'auto\'\n        Join ends of open polylines' in lamella.slice.__doc__


def test_contours_of_others_become_regions():
    low = np.array([[0, 0], [4, 0], [4, 4], [0, 4]])
    assert lamella.region_of([low, low + 2]).area == 28
    assert lamella.region_of([low, low[::-1] / 2 + 1], fill_rule="even-odd").area == 12
    assert lamella.region_of([low], offset=1, grid=0.001).area == pytest.approx(36)
    assert lamella.region_of([]).area == 0


def test_normal_and_transform_move_the_mesh(cube):
    turned = lamella.slice(*cube, normal=[1, 1, 0], heights=[np.sqrt(50)])
    assert turned.areas == pytest.approx([10 * np.sqrt(200)], rel=1e-6)
    double = np.diag([2, 2, 2, 1])
    for matrix in (double, double[:3], double.tolist()):
        s = lamella.slice(*cube, transform=matrix, heights=[15])
        assert s.areas == pytest.approx([400])
        assert s.frame.tolist() == double.tolist()


def test_ends_are_stitched_as_asked(cube):
    s = lamella.slice(cube[0], np.delete(cube[1], 4, axis=0), heights=[2, 8], stitch=30)
    assert s.stitches["layer"].tolist() == [0, 1]
    assert (s.contours["flags"] & lamella.ContourFlag.STITCHED).all()


def test_origins_name_the_triangles(cube):
    s = lamella.slice(*cube, heights=[5], origins=True)
    assert len(s.origins) == len(s.points)
    assert len(np.unique(s.origins["triangle"])) == 8
    assert len(lamella.slice(*cube, heights=[5]).origins) == 0


def test_the_finest_grid_has_room_for_the_offset(cube):
    assert lamella.slice(*cube, grid="finest").grid < 2.0**-20
    full = 0.9995 * cube[0] / np.max(cube[0]), cube[1]  # room for the offset takes the next power of two
    grids = [lamella.slice(*full, grid="finest", fill_rule="non-zero", offset=offset).grid for offset in (0, 0.002)]
    assert grids == [2.0**-30, 2.0**-29]


def test_threads_do_not_change_the_result(torus):
    assert lamella.slice(*torus, threads=1).hash == lamella.slice(*torus, threads=2).hash == lamella.slice(*torus).hash
    assert lamella.slice(*torus, threads=1).info["threads"] == 1


def test_shells_turned_inwards_are_warned_of_and_turned(cube):
    corners, faces = cube
    pair = np.concatenate([corners[faces], (corners + (5, 5, 0))[faces[:, ::-1]]])
    with pytest.warns(lamella.MeshWarning, match="in 1 layer shells turned inwards overlap others"):
        crossed = lamella.slice(pair, heights=[5])
    assert crossed.areas[0] == pytest.approx(150)
    assert crossed.info["cancelled_layers"] == 1
    assert crossed.certificate.verdict == "solid is not what the mesh encloses"
    assert (crossed.certificate.differing_layers, crossed.certificate.differing_solid) == (1, pytest.approx(150))
    turned = lamella.Mesh(pair.reshape(-1, 9), None, 1, None, {}).orient_shells()
    assert turned.info == {"shells": 2, "turned": 1, "complete": True}
    united = lamella.slice(pair, heights=[5], orient_shells=True)
    assert united.areas[0] == pytest.approx(175)
    assert united.hash == lamella.slice(turned, heights=[5]).hash == pickle.loads(pickle.dumps(united)).hash
