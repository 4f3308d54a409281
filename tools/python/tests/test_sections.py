"""Sections along axes and curves: of tubes, whose sections are known."""

import numpy as np
import pytest

import lamella


def tube(centres, frames, radius, sides=96, closed=False):
    """Around a curve: rings of vertices, and caps where it is open."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = radius * (np.cos(angle)[:, None, None] * frames[0] + np.sin(angle)[:, None, None] * frames[1])
    vertices = (centres + ring).transpose(1, 0, 2).reshape(-1, 3)
    count = len(centres)
    i, j = np.meshgrid(np.arange(count if closed else count - 1), np.arange(sides), indexing="ij")
    at = lambda i, j: (i % count) * sides + j % sides  # noqa: E731
    quads = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]
    faces = [np.stack((quads[0], quads[1], quads[2]), -1).reshape(-1, 3), np.stack((quads[0], quads[2], quads[3]), -1).reshape(-1, 3)]
    if not closed:
        first, last = len(vertices), len(vertices) + 1
        vertices = np.vstack((vertices, centres[:1], centres[-1:]))
        k = np.arange(sides)
        faces += [np.stack((np.full(sides, first), (k + 1) % sides, k), -1)]
        faces += [np.stack((np.full(sides, last), at(count - 1, k), at(count - 1, k + 1)), -1)]
    return vertices, np.vstack(faces)


def helix(u):
    """Points, normals and binormals of Frenet's frame; the tangent is (-3 sin, 3 cos, 4) / 5."""
    points = np.column_stack((3 * np.cos(u), 3 * np.sin(u), 4 * u))
    normals = np.column_stack((-np.cos(u), -np.sin(u), 0 * u))
    tangents = np.column_stack((-3 * np.sin(u), 3 * np.cos(u), 4 + 0 * u)) / 5
    return points, normals, np.cross(tangents, normals), tangents


def polygon_area(radius, sides=96):
    return sides / 2 * radius**2 * np.sin(2 * np.pi / sides)


def test_a_bar_has_its_axis_and_sections_at_fractions(cube):
    vertices, faces = cube
    bar = (vertices * [0.1, 0.1, 0.3], faces)
    axis = lamella.length_axis(bar)
    assert np.allclose(axis.direction, [0, 0, 1]) and np.allclose(axis.origin, [0.5, 0.5, 0])
    assert np.isclose(axis.length, 3) and np.isclose(axis.ratio, 9)
    cuts = lamella.sections_along(bar, axis=axis, at=[0.2, 0.35, 0.5, 0.65, 0.8])
    assert np.allclose(cuts.frames[:, 2, 3], [0.6, 1.05, 1.5, 1.95, 2.4]) and np.allclose(cuts.areas, 1, atol=1e-5)
    assert np.allclose(cuts.measures["imax"], 1 / 12, atol=1e-5) and (cuts.overlap == 0).all()
    assert lamella.length_axis(bar, towards=[0, 0, -1]).direction[2] == pytest.approx(-1)
    unit = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    with pytest.warns(lamella.MeshWarning, match="matter of chance"):
        lamella.length_axis(vertices, faces)
    assert lamella.length_axis(unit * [1, 1, 5], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).ratio > 5
    with pytest.raises(lamella.InvalidArgumentError, match="open"):
        lamella.length_axis(vertices, faces[:-1])


def test_frames_along_a_helix_do_not_twist():
    for steps, error in ((40, 2e-2), (160, 1.5e-3)):
        points, normals, _, _ = helix(np.linspace(0, 2 * np.pi, steps + 1))
        cuts = lamella.sections_along(tube(*_tube_frames(points, normals)), points, up=normals[0])
        first, last = cuts.frames[0], cuts.frames[-1]
        assert np.allclose(np.linalg.det(cuts.frames[:, :3, :3]), 1)
        # After a round the x axis has turned by -8 pi / 5 against Frenet's normal.
        end_normal = normals[-1] - (normals[-1] @ last[:3, 2]) * last[:3, 2]
        turn = np.arctan2(np.cross(end_normal, last[:3, 0]) @ last[:3, 2], end_normal @ last[:3, 0])
        begin = np.arctan2(np.cross(normals[0], first[:3, 0]) @ first[:3, 2], normals[0] @ first[:3, 0])
        assert abs((turn - begin + 8 * np.pi / 5 + np.pi) % (2 * np.pi) - np.pi) < error


def _tube_frames(points, normals):
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    across = normals - np.einsum("ni,ni->n", normals, tangents)[:, None] * tangents
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return points, (across, np.cross(tangents, across)), 0.5


def test_a_helix_tube_has_its_area_in_every_section():
    points, normals, binormals, _ = helix(np.linspace(0, 4 * np.pi, 400))
    mesh = tube(points, (normals, binormals), 0.5)
    inner = np.linspace(2, 60, 200)
    cuts = lamella.sections_along(mesh, points, mm=inner, keep="nearest")
    assert np.abs(cuts.areas / polygon_area(0.5) - 1).max() < 1e-3
    assert (cuts.overlap == 0).all() and np.allclose(cuts.along, inner) and cuts.fraction[-1] < 1
    prepared = lamella.prepare(*mesh)
    assert lamella.sections_along(prepared, points, mm=inner, keep="nearest").hash == cuts.hash
    on_tube = cuts.points_in_mesh()
    nearest = np.array([np.linalg.norm(points - point, axis=1).min() for point in on_tube[::50]])
    assert np.abs(nearest - 0.5).max() < 0.02
    assert list(cuts.layers_frame().columns[:3]) == ["layer", "along", "fraction"]


def test_a_closed_curve_comes_back_to_its_first_frame(torus):
    u = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    ring = np.column_stack((20 * np.cos(u), 0 * u, 20 * np.sin(u)))
    cuts = lamella.sections_along(torus, ring, closed=True, keep="nearest")
    again = lamella.sections_along(torus, np.vstack((ring, ring[:1])), closed=True, mm=[0, cuts.along[-1]], keep="nearest")
    assert len(cuts) == 60 and np.allclose(cuts.areas, cuts.areas[0], rtol=0.01)
    assert np.allclose(again.frames[0], cuts.frames[0]) and np.allclose(again.frames[1], cuts.frames[-1])
    assert cuts.frames[-1][:3, 0] @ cuts.frames[0][:3, 0] > 0.99


def test_planes_that_cross_within_the_body_are_told():
    u = np.linspace(0, np.pi, 40)
    bend = np.column_stack((0.6 * np.cos(u), 0.6 * np.sin(u), 0 * u))
    legs = np.linspace(-8, -1, 15)
    points = np.vstack((np.column_stack((0.6 + 0 * legs, legs, 0 * legs)), bend, np.column_stack((-0.6 + 0 * legs, legs[::-1], 0 * legs))))
    tangents = np.gradient(points, axis=0)
    normals = np.tile([0, 0, 1.0], (len(points), 1))
    side = np.cross(tangents / np.linalg.norm(tangents, axis=1, keepdims=True), normals)
    mesh = tube(points, (normals, -side), 0.5)
    cuts = lamella.sections_along(mesh, points[5:-5], up=[0, 0, 1], keep="nearest")
    assert (cuts.overlap[:5] == 0).all()  # along a straight leg
    inner = lamella.sections_along(mesh, points[5:-5] * [0.5, 0.9, 1], up=[0, 0, 1], keep="nearest")
    assert inner.overlap.max() > 0  # a bend tighter than the tube
    assert (inner.overlap[:5] == 0).all()


def test_two_limbs_and_one_curve(cube):
    vertices, faces = cube
    limbs = (np.vstack((vertices * [0.1, 0.1, 1], vertices * [0.1, 0.1, 1] + [5, 0, 0])), np.vstack((faces, faces + 8)))
    curve = [[0.5, 0.5, 1], [0.5, 0.5, 9]]
    both = lamella.sections_along(limbs, curve, at=[0.5])
    one = lamella.sections_along(limbs, curve, at=[0.5], keep="nearest")
    assert both.measures["islands"].tolist() == [2] and one.measures["islands"].tolist() == [1]
    assert np.isclose(one.areas[0], 1, atol=1e-4) and np.allclose(one.measures["centroid_x"], 0, atol=1e-4)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({}, "one of curve and axis"),
        ({"curve": [[0, 0, 0]]}, "at least 2 different"),
        ({"curve": [[0, 0, 0], [0, 0, 0]]}, "at least 2 different"),
        ({"curve": [[0, 0, 0], [0, 0, 5], [0, 0, 2]]}, "turns back at point 1"),
        ({"curve": [[0, 0, 0], [0, 0, np.nan]]}, r"curve\[1\] is not finite"),
        ({"curve": [[0, 0, 0], [0, 0, 5]], "at": [1.5]}, "between 0 and its length of 5 mm"),
        ({"curve": [[0, 0, 0], [0, 0, 5]], "at": [0.5], "mm": [1]}, "exclude"),
        ({"curve": [[0, 0, 0], [0, 0, 5]], "up": [0, 0, 1]}, "up runs along"),
        ({"curve": [[0, 0, 0], [0, 0, 5]], "keep": "first"}, "keep must be one of"),
        ({"curve": [[0, 0, 0], [0, 0, 5]], "layer_height": 1}, "given by the planes"),
    ],
)
def test_what_is_no_curve_is_refused(cube, options, why):
    with pytest.raises(lamella.InvalidArgumentError, match=why):
        lamella.sections_along(cube, **options)


def test_points_that_repeat_are_dropped_and_open_sections_told(cube):
    curve = [[5, 5, 1], [5, 5, 1], [5, 5, 9], [5, 5, 9]]
    assert len(lamella.sections_along(cube, curve)) == 2
    with pytest.warns(lamella.MeshWarning, match="2 of 2 sections have open contours"):
        unknown = lamella.sections_along((cube[0], cube[1][2:-2]), [[5, 5, 1], [5, 5, 9]], stitch=0)
    assert np.isnan(unknown.areas).all()


def test_sections_are_those_of_single_planes(torus):
    origins = [[20, 0, 0], [0, 3, 20], [0, 1, 0]]
    normals = [[0, 0, 1], [1, 0.2, 0], [0, 1, 0]]
    cuts = lamella.sections(torus, origins, normals, threads=2)
    for i, (origin, normal) in enumerate(zip(origins, normals)):
        alone = lamella.section(torus, origin, normal)
        assert np.isclose(cuts.areas[i], alone.area, rtol=1e-6) and np.isclose(cuts.perimeters[i], alone.perimeter, rtol=1e-6)


def test_two_results_are_compared_layer_by_layer(cube):
    vertices, faces = cube
    z = [1, 5, 9, 12]
    own = lamella.slice(vertices, faces, heights=z)
    found = lamella.compare(own, lamella.slice(vertices + [2, 0, 0], faces, heights=z))
    assert np.allclose(found.layers["dice"][:3], 0.8, atol=1e-6) and np.isnan(found.layers["dice"][3])
    assert np.allclose(found.layers["hausdorff"][:3], 2, atol=1e-5) and abs(found.dice - 0.8) < 1e-6
    assert found.hausdorff == found.layers["hausdorff"][:3].max()
    assert lamella.compare(own, own).dice == 1
    assert np.isnan(lamella.compare(own, own, distances=False).hausdorff)
    mirror = np.diag([-1, 1, 1, 1]) + 10 * np.eye(4, k=3)
    assert lamella.compare(own, lamella.slice(vertices, faces, heights=z, transform=mirror)).hausdorff < 1e-5
    with pytest.raises(lamella.InvalidArgumentError, match="layer 0 of the two") as caught:
        lamella.compare(own, lamella.slice(vertices, faces, heights=[2, 5, 9, 12]))
    assert caught.value.layer == 0
