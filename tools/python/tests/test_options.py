"""Options: what they do is the engine's tests' to show; that each arrives, and what is refused, is shown here."""

import pickle

import numpy as np
import pytest

import lamella


def test_layers_are_planned_as_asked(cube):
    z = lambda **options: lamella.slice(*cube, **options).layers["z"]  # noqa: E731
    assert z() == pytest.approx(0.1 + 0.2 * np.arange(50))
    assert z(layer_height=2) == pytest.approx([1, 3, 5, 7, 9])
    assert z(layer_height=2, first_height=0.5) == pytest.approx([0.5, 2.5, 4.5, 6.5, 8.5])
    lifted = cube[0] + [0, 0, 0.5], cube[1]
    assert lamella.slice(*lifted, layer_height=4, datum="zero").layers["z"] == pytest.approx([2, 6, 10])
    assert lamella.slice(*lifted, layer_height=3).layers["z"] == pytest.approx([2, 5, 8])


def test_given_heights_come_in_any_order_and_shape(cube):
    s = lamella.slice(*cube, heights=[7, 2, 7, 5])
    assert s.layers["z"].tolist() == [2, 5, 7]
    assert s.layer_of.tolist() == [2, 0, 2, 1]
    assert lamella.slice(*cube, heights=5).layers["z"].tolist() == [5]
    assert lamella.slice(*cube, heights=np.arange(10)[::-2]).layers["z"].tolist() == [1, 3, 5, 7, 9]
    assert len(lamella.slice(*cube, heights=[])) == 0


def test_side_decides_at_a_flat_face(cube):
    assert lamella.slice(*cube, heights=[0]).areas == [0]
    assert lamella.slice(*cube, heights=[0], side="above").areas == pytest.approx([100])


def test_normal_and_transform_move_the_mesh(cube):
    turned = lamella.slice(*cube, normal=[1, 1, 0], heights=[np.sqrt(50)])
    assert turned.areas == pytest.approx([10 * np.sqrt(200)], rel=1e-6)
    double = np.diag([2, 2, 2, 1])
    for matrix in (double, double[:3], double.tolist()):
        s = lamella.slice(*cube, transform=matrix, heights=[15])
        assert s.areas == pytest.approx([400])
        assert s.frame.tolist() == double.tolist()


def test_rules_of_regions_arrive(cube, box_with_cavity):
    twice = np.vstack((cube[0], cube[0] + [5, 5, 0])), np.vstack((cube[1], cube[1] + 8))
    area = lambda mesh=twice, **options: lamella.slice(*mesh, heights=[5], **options).areas[0]  # noqa: E731
    assert area(fill_rule="contours") == pytest.approx(200)
    assert area() == pytest.approx(175)
    assert area(fill_rule="non-zero") == pytest.approx(175)
    assert area(fill_rule="even-odd") == pytest.approx(150)
    assert area(fill_rule="positive", offset=1) > 175 + 30
    assert area(fill_from=[(0, "non-zero")]) == pytest.approx(175)
    assert area(box_with_cavity, fill_rule="non-zero") == pytest.approx(84)
    assert area(box_with_cavity, fill_rule="even-odd") == pytest.approx(84)
    assert area(box_with_cavity, fill_rule="even-odd", close=2.5) == pytest.approx(100)
    assert area(box_with_cavity, fill_rule="outermost") == pytest.approx(100)
    apart = np.vstack((cube[0], 0.5 * cube[0] + [20, 0, 3])), twice[1]
    assert area(apart, fill_rule="non-zero", largest_only=True) == pytest.approx(100)


def test_points_are_dropped_as_asked(torus, cube):
    count = lambda **options: len(lamella.slice(*torus, heights=[1], **options).points)  # noqa: E731
    assert count(simplify=0.5) < count() / 2
    on_edges = lamella.slice(*cube, heights=[5])
    assert len(lamella.slice(*cube, heights=[5], fill_rule="non-zero", drop_collinear=True).points) == 4 < len(on_edges.points)


def test_marks_and_miter_limit_arrive(box_with_cavity):
    marked = lamella.slice(*box_with_cavity, heights=[5], mark_near=2)
    assert (marked.contours["flags"] & lamella.ContourFlag.NEAR).any()
    grown = {
        limit: lamella.slice(*box_with_cavity, heights=[5], fill_rule="positive", offset=1, miter_limit=limit).areas[0]
        for limit in (1, 3)
    }
    assert grown[1] < grown[3]


def test_gaps_are_closed_as_asked(cube):
    vertices, faces = cube
    open_mesh = vertices, faces[1:]
    side = lamella.slice(vertices, np.delete(faces, 4, axis=0), heights=[2, 8], close_gaps=30)
    assert len(side.closed_gaps) == 2
    assert side.closed_gaps["layer"].tolist() == [0, 1]
    assert (side.contours["flags"] & lamella.ContourFlag.GAP_CLOSED).all()
    assert lamella.slice(*open_mesh, heights=[5]).areas == pytest.approx([100])


def test_origins_name_the_triangles(cube):
    s = lamella.slice(*cube, heights=[5], origins=True)
    assert len(s.origins) == len(s.points)
    normals_up = cube[1][s.origins["triangle"]]
    assert len(np.unique(s.origins["triangle"])) == 8
    assert normals_up.shape == (len(s.points), 3)
    assert len(lamella.slice(*cube, heights=[5]).origins) == 0


def test_grid_and_memory_limit_arrive(cube):
    assert lamella.slice(*cube, grid=2.0**-19).grid == 2.0**-19
    assert lamella.slice(*cube, grid="auto").grid < 2.0**-20
    full = 0.9995 * cube[0] / np.max(cube[0]), cube[1]  # room for the offset takes the next power of two
    grids = [lamella.slice(*full, grid="auto", fill_rule="non-zero", offset=offset).grid for offset in (0, 0.002)]
    assert grids == [2.0**-30, 2.0**-29]
    with pytest.raises(lamella.ResultTooLargeError) as raised:
        lamella.slice(*cube, layer_height=0.01, memory_limit=1000)
    assert isinstance(raised.value, MemoryError)


def test_threads_do_not_change_the_result(torus):
    assert lamella.slice(*torus, threads=1).hash == lamella.slice(*torus, threads=2).hash == lamella.slice(*torus).hash
    assert lamella.slice(*torus, threads=1).summary["threads"] == 1


REFUSED = [
    ({"fill_rule": "nonzero"}, "fill_rule must be one of 'contours', 'even-odd', 'non-zero', 'positive', 'outermost'"),
    ({"side": 1}, "side must be one of 'below', 'above', not 1"),
    ({"unit": "km"}, "unit must be a number of mm or one of 'mm', 'um'"),
    ({"unit": 0}, "unit must be finite and more than 0 mm"),
    ({"grid": "fine"}, "grid must be mm or 'auto', not 'fine'"),
    ({"layer_height": "0.2"}, "layer_height must be a number, not '0.2'"),
    ({"layer_height": 0.2, "heights": [1]}, "heights and layer_height exclude each other"),
    ({"first_height": 0.2, "heights": [1]}, "heights and first_height exclude each other"),
    ({"datum": "zero", "heights": [1]}, "heights and datum exclude each other"),
    ({"heights": [[1]]}, r"heights must have one dimension, and have shape \(1, 1\)"),
    ({"heights": ["a"]}, "heights must be numbers"),
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
    ({"close": 1, "fill_rule": "contours"}, "closing needs a region"),
    ({"offset": np.nan, "fill_rule": "non-zero"}, "offset"),
]


@pytest.mark.parametrize("options, message", REFUSED)
def test_what_an_option_does_not_allow_is_refused(cube, options, message):
    with pytest.raises(lamella.InvalidArgumentError, match=message):
        lamella.slice(*cube, **options)


def test_bad_planes_are_named(cube):
    with pytest.raises(lamella.PlanesError) as raised:
        lamella.slice(*cube, heights=[1, 2, np.nan])
    assert raised.value.layer == 2
    with pytest.raises(lamella.PlanesError, match="under two grid units"):
        lamella.slice(*cube, layer_height=1e-9)


def test_unknown_options_are_answered_with_the_nearest(cube):
    with pytest.raises(TypeError, match="layer_heigth"):
        lamella.slice(*cube, layer_heigth=1)
    with pytest.raises(lamella.InvalidArgumentError, match="no option 'layer_heigth'; is it 'layer_height'"):
        lamella.prepare(*cube).slice(layer_heigth=1)
    with pytest.raises(lamella.InvalidArgumentError, match="grid is for prepare"):
        lamella.prepare(*cube).slice(grid=1)


def test_shells_turned_inwards_are_warned_of_and_turned(cube):
    corners, faces = cube
    pair = np.concatenate([corners[faces], (corners + (5, 5, 0))[faces[:, ::-1]]])
    with pytest.warns(lamella.MeshWarning, match="in 1 layer shells turned inwards overlap others"):
        crossed = lamella.slice(pair, heights=[5])
    assert crossed.areas[0] == pytest.approx(150)
    assert crossed.summary["cancelled_layers"] == 1
    assert crossed.certificate.verdict == "solid is not what the mesh encloses"
    assert (crossed.certificate.differing_layers, crossed.certificate.differing_solid) == (1, pytest.approx(150))
    turned = lamella.Mesh(pair.reshape(-1, 9), None, 1, None, {}).orient_shells()
    assert turned.info == {"shells": 2, "turned": 1, "complete": True}
    united = lamella.slice(pair, heights=[5], orient_shells=True)
    assert united.areas[0] == pytest.approx(175)
    assert united.hash == lamella.slice(turned, heights=[5]).hash == pickle.loads(pickle.dumps(united)).hash
