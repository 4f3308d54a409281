"""All calls, and the options of slice(): what they do is the engine's tests' to show; that each arrives is shown here."""

import gc
import gzip
import inspect
import os
import pickle
import re
import subprocess

import numpy as np
import pytest
from support import TOOL, needs_tool, write_off, write_stl

import lamella
from lamella._options import OPTIONS


def test_a_prepared_mesh_gives_the_slices_of_the_mesh(torus):
    prepared = lamella.prepare(*torus)
    for options in ({"heights": [0, 2, -3]}, {"layer_height": 0.5}, {"layer_height": 1, "fill_rule": "non-zero", "offset": -1}):
        assert prepared.slice(**options).hash == lamella.slice(*torus, **options).hash
    assert prepared.slice([1.0]).certificate.holds
    assert 12 * len(torus[1]) <= prepared.nbytes <= 14 * len(torus[1])
    assert prepared.grid == 2.0**-20
    vertices, faces = (np.array(array) for array in torus)
    kept = lamella.prepare(vertices, faces)
    vertices[:], faces[:] = 0, 0  # what was given may change
    assert kept.slice([1.0]).hash == prepared.slice([1.0]).hash
    assert "4,608 triangles" in repr(prepared)
    frame = {"normal": [1, 0, 0], "unit": "cm"}
    placed, same = lamella.prepare(*torus, **frame).slice([50]), lamella.slice(*torus, **frame, heights=[50])
    assert placed.hash == same.hash
    assert placed.frame == pytest.approx(same.frame)


def test_parts_keep_their_numbers_and_have_no_ledger(cube, tmp_path):
    move = np.eye(4)
    move[:3, 3] = 5, 5, 0
    separate = lamella.slice_parts([cube, cube], transforms=[None, move], heights=[5])
    assert separate.contours["part"].tolist() == [0, 1]
    assert separate.areas == pytest.approx([200])
    united = lamella.slice_parts([cube, cube], transforms=[None, move], heights=[5], unite_parts=True, fill_rule="non-zero")
    assert united.areas == pytest.approx([175])
    assert united.contours["part"].tolist() == [lamella.SEVERAL_PARTS]
    assert lamella.slice_parts([cube], heights=[5]).hash == lamella.slice(*cube, heights=[5]).hash
    prepared = lamella.prepare(*cube, grid=separate.grid)
    led = lamella.slice_parts([prepared, cube], transforms=[None, move], heights=[5])
    assert led.hash == separate.hash
    separate.save(tmp_path / "parts.json")
    assert "ledger" not in (tmp_path / "parts.json").read_text()


@pytest.mark.parametrize("chunk", [1, 7, 64, 1000])
@pytest.mark.parametrize("options", [{}, {"origins": True, "layers": (3, 40)}, {"grid": "finest", "offset": 0.5}])
def test_chunks_of_a_stream_are_the_layers_of_the_slice(torus, chunk, options):
    whole = lamella.slice(*torus, layer_height=0.1, **options)
    assert whole.first_layer == options.get("layers", (0, 0))[0]
    first = 0
    for layers in lamella.stream(*torus, chunk=chunk, layer_height=0.1, **options):
        assert layers.first_layer == whole.first_layer + first
        assert layers.grid == whole.grid
        assert len(layers) == min(chunk, len(whole) - first)
        for name in ("z", "bottom", "top", "contour_count", "segments", "z_grid"):
            assert np.array_equal(layers.layers[name], whole.layers[name][first : first + len(layers)])
        contours = slice(whole.layers["first_contour"][first], whole.layers["first_contour"][first] + len(layers.contours))
        for name in ("role", "orientation", "flags", "point_count", "twice_area_low"):
            assert np.array_equal(layers.contours[name], whole.contours[name][contours])
        parents = whole.contours["parent"][contours]
        assert np.array_equal(layers.contours["parent"], np.where(parents < 0, -1, parents - contours.start))
        points = slice(whole.contours["first_point"][contours.start], None)
        assert np.array_equal(layers.points_grid, whole.points_grid[points][: len(layers.points_grid)])
        assert np.array_equal(layers.origins, whole.origins[points][: len(layers.origins)])
        assert layers.areas == pytest.approx(whole.areas[first : first + len(layers)])
        first += len(layers)
    assert first == len(whole)
    assert len(whole.origins) == (len(whole.points) if "origins" in options else 0)


def test_parts_have_roles(cube):
    half = np.diag([0.5, 0.5, 2, 1])
    both = [cube, cube]
    whole = lamella.slice(*cube, heights=[5]).areas[0]
    cut = lamella.slice_parts(both, transforms=[None, half], roles=["solid", "negative"], heights=[5])
    assert cut.areas[0] == whole * 3 / 4
    named = lamella.slice_parts(both, transforms=[None, half], roles=["solid", "modifier"], heights=[5])
    assert named.areas[0] == whole
    assert sorted(named.contours["part"]) == [0, 1]
    apart = lamella.slice_parts(both, transforms=[None, half], roles=["solid", "negative"], objects=["a", "b"], heights=[5])
    assert apart.areas[0] == whole


def test_copies_are_the_parts_that_they_stand_for(cube):
    places = [(0, 0, 0), (20, 0, 0), (0, 30, 2)]
    moves = [np.eye(4) for _ in places]
    for move, place in zip(moves, places):
        move[:3, 3] = place
    alone = lamella.slice_parts([cube] * 4, transforms=[None, *moves], heights=[1, 5])
    copied = lamella.slice_parts([cube, cube], at=[None, places], heights=[1, 5])
    assert copied.hash == alone.hash
    assert len(copied.copies) == 0
    shared = lamella.slice_parts([cube, cube], at=[None, places], heights=[1, 5], share_copies=True)
    assert shared.contours["part"].tolist() == [0, 1, 0, 1, 3]
    for result in (shared, pickle.loads(pickle.dumps(shared))):
        assert result.copies[["part", "first"]].tolist() == [(2, 1)]
        assert (result.copies["move_grid"] * result.grid).tolist() == [[20, 0]]


def test_sections_lie_in_their_planes(torus, cube):
    origin, normal = np.array([3.0, 1, -2]), np.array([1.0, 2, 3])
    cut = lamella.section(torus, origin=origin, normal=normal)
    flat = np.column_stack((cut.points, np.zeros(len(cut.points)), np.ones(len(cut.points))))
    space = (cut.to_3d @ flat.T).T[:, :3]
    assert np.abs((space - origin) @ normal / np.linalg.norm(normal)).max() < 1e-5
    ring = np.hypot(space[:, 0], space[:, 2]) - 20
    assert np.abs(np.hypot(ring, space[:, 1]) - 7).max() < 0.1
    cuts = lamella.section_multiplane(cube, [5, 5, 5], [0, 0, -2], [4, -4, 9])
    assert cuts.layers["z"].tolist() == [-4, 4, 9]
    assert cuts.layer_of.tolist() == [1, 0, 2]
    assert cuts.areas == pytest.approx([100, 100, 0])
    assert cuts[1].to_3d[:3, 3] == pytest.approx([5, 5, 1])


def test_check_finds_faults_with_places(cube):
    vertices, faces = cube
    clean = lamella.check(vertices, faces)
    assert (clean.clean, clean.verdict) == (True, "closed and clean")
    assert clean.info["volume"] == pytest.approx(1000)
    assert clean.shells["volume"] == pytest.approx([1000])
    assert all(finding.count == 0 for finding in clean.findings.values())
    broken = lamella.check(vertices, faces[1:])
    edges = broken["boundary_edges"]
    assert not broken.clean
    assert edges.count == len(edges.points) == 3
    assert edges.points.shape == (3, 3, 3)
    assert np.isnan(edges.points[:, 2]).all()
    assert {tuple(point) for edge in edges.points for point in edge[:2]} == {tuple(vertices[i]) for i in faces[0]}
    assert broken["boundary_loops"].closed.tolist() == [True]
    assert broken["boundary_loops"].measure == pytest.approx([20 + np.sqrt(200)])
    assert lamella.check(vertices, faces[1:], most_places=1)["boundary_edges"].points.shape == (1, 3, 3)


def test_welding_closes_cracks(cube):
    triangles = cube[0][cube[1]]
    triangles[::2] += 0.001
    assert not lamella.check(triangles).info["closed"]
    welded = lamella.weld(triangles, tolerance=0.01)
    assert lamella.check(welded).clean
    assert welded.info["joined"] > 0
    assert 0 < welded.info["largest_move"] <= 0.01
    assert (len(welded), welded.vertices.shape) == (12, (8, 3))
    assert lamella.slice(welded, heights=[5]).certificate.holds
    assert lamella.check(lamella.weld(triangles / 10, tolerance=0.01, unit="cm")).clean


def test_files_are_read_with_views_of_their_bytes(torus, tmp_path):
    path = tmp_path / "torus.stl"
    triangles = torus[0][torus[1]]
    write_stl(path, triangles)
    mesh = lamella.read(path)
    assert (len(mesh), mesh.info["format"], mesh.path) == (len(triangles), "STL", str(path))
    assert (mesh.triangles == triangles.astype("f4")).all()
    assert mesh.triangles.strides[0] == 50
    assert not mesh.triangles.flags.owndata
    assert (mesh.vertices[mesh.faces] == mesh.triangles).all()
    (tmp_path / "torus.stl.gz").write_bytes(gzip.compress(path.read_bytes()))
    assert lamella.slice(tmp_path / "torus.stl.gz").hash == lamella.slice(mesh).hash == lamella.slice(mesh.triangles).hash
    triangles = mesh.triangles
    copy = triangles.copy()
    del mesh
    gc.collect()
    assert (triangles == copy).all()


def test_any_file_name_will_do(cube, tmp_path):
    name = os.fsencode(tmp_path) + b"/gr\xfc\xdfe.stl"
    write_stl(name, cube[0][cube[1]])
    assert lamella.slice(name).hash == lamella.slice(os.fsdecode(name)).hash == lamella.slice(*cube).hash
    lamella.slice(name).save(name + b".svg")
    assert os.path.getsize(name + b".svg") > 1000


def test_what_the_reader_notices_is_a_warning(cube, tmp_path):
    write_stl(tmp_path / "cube.obj", cube[0][cube[1]])
    with pytest.warns(lamella.MeshWarning, match="cube.obj") as caught:
        lamella.slice(tmp_path / "cube.obj")
    assert caught[0].filename == __file__


def test_segments_become_contours():
    outer = np.array([[0, 0], [9, 0], [9, 9], [0, 9]], dtype=float)
    hole = np.array([[3, 3], [3, 6], [6, 6], [6, 3]], dtype=float)
    rings = [np.stack((ring, np.roll(ring, -1, axis=0)), axis=1) for ring in (outer, hole)]
    segments = np.random.default_rng(1).permutation(np.concatenate(rings))
    layer = lamella.assemble(segments)
    assert (layer.area, layer.perimeter) == (pytest.approx(81 - 9), pytest.approx(36 + 12))
    assert [len(polygon.holes) for polygon in layer.polygons()] == [1]
    assert lamella.assemble(segments.reshape(-1, 4).tolist()).area == pytest.approx(72)
    # Keys decide which ends meet.
    keys = np.column_stack((np.arange(4), (np.arange(4) + 1) % 4))
    assert lamella.assemble(rings[0], keys).area == 81
    keys[3, 1] = 99
    cut = lamella.assemble(rings[0], keys)
    assert (str(cut.area), len(cut.polylines())) == ("nan", 1)


def test_contours_of_others_become_regions():
    low = np.array([[0, 0], [4, 0], [4, 4], [0, 4]])
    assert lamella.region_of([low, low[::-1] / 2 + 1], fill_rule="even-odd").area == 12
    assert lamella.region_of([low], offset=1, grid=0.001).area == pytest.approx(36)
    assert lamella.region_of([]).area == 0


def test_given_heights_come_in_any_order_and_shape(cube):
    s = lamella.slice(*cube, heights=[7, 2, 7, 5])
    assert s.layers["z"].tolist() == [2, 5, 7]
    assert s.layer_of.tolist() == [2, 0, 2, 1]
    assert lamella.slice(*cube, heights=5).layers["z"].tolist() == [5]
    assert lamella.slice(*cube, heights=np.arange(10)[::-2]).layers["z"].tolist() == [1, 3, 5, 7, 9]
    assert len(lamella.slice(*cube, heights=[])) == 0


# Values of what is neither a number, a word nor a flag, and what the engine's members hold then.
STRUCTURED = {
    "heights": ([7, 2], [[7, 2]]),
    "slabs": ([[6, 8], [1, 3]], [[[6, 8], [1, 3]]]),
    "layers": ((1, 3), [1, 3]),
    "transform": (np.diag([2, 2, 2, 1]), [np.diag([2, 2, 2, 1])[:3].tolist()]),
    "grid": (2.0**-19, [2.0**-19]),
    "fill_from": ([(2, "even-odd")], [[(2, 1)]]),
}


def another_value(name, option):
    """Not the default, and what the engine's members hold then."""
    if name in STRUCTURED:
        return STRUCTURED[name]
    if option.kind == "flag":
        return True, [True]
    if option.kind == "choice":
        return option.words[-1], [len(option.words) - 1]
    return (option.least or 0) + 0.25, [(option.least or 0) + 0.25]


def options_of(result):
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in result._native.options.items()}


@pytest.mark.parametrize("name", sorted(OPTIONS.keys() - {"content"}))  # which the next test shows
def test_each_option_arrives(cube, name):
    value, members = another_value(name, OPTIONS[name])
    expected = dict(zip(OPTIONS[name].fields, members))
    defaults, given = (options_of(lamella.slice(*cube, **{"stitch": 0, **options})) for options in ({}, {name: value}))
    assert len(members) == len(OPTIONS[name].fields)
    if name == "slabs":
        expected["heights_mm"] = [7, 2]  # their middles
    assert given == {**defaults, **expected}
    assert all(defaults[field] != member for field, member in expected.items())


def test_adaptive_layers_follow_the_surface(cube):
    vertices, faces = np.array([[0, 0, 0], [5, 0, 0], [0, 5, 0], [0, 0, 5]], dtype=float), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    flattest = np.sqrt(1 / 3)  # the cosine of its slope
    slabs = lamella.adaptive_layers(vertices, faces, cusp=0.1)
    assert slabs[:, 1] - slabs[:, 0] == pytest.approx(np.floor(0.1 / flattest / 0.005) * 0.005)
    assert (slabs[1:, 0] == slabs[:-1, 1]).all()
    layers = lamella.slice(vertices, faces, slabs=slabs).layers
    assert (layers["bottom"] == slabs[:, 0]).all() and (layers["top"] == slabs[:, 1]).all()
    ranged = lamella.adaptive_layers(*cube, least=0.1, most=0.25, step=0.05, ranges=[(0, 0.2, 0.2)], most_change=0.05, threads=2)
    assert (ranged[:, 1] - ranged[:, 0])[:3] == pytest.approx([0.2, 0.25, 0.25])
    assert lamella.adaptive_layers(*cube, normal=[1, 0, 0]) == pytest.approx(lamella.adaptive_layers(*cube))
    with pytest.raises(lamella.InvalidArgumentError, match="least_mm must be at least step_mm"):
        lamella.adaptive_layers(*cube, least=0.001)
    with pytest.raises(lamella.InvalidArgumentError, match=r"ranges must have shape \(n, 3\), and have \(2,\)"):
        lamella.adaptive_layers(*cube, ranges=[0, 1])


@pytest.mark.parametrize("content, areas", [("upward-faces", [0, 100, 0]), ("downward-faces", [100, 0, 0])])
def test_faces_are_projected_onto_layers(cube, content, areas):
    assert lamella.slice(*cube, heights=[3, 5, 12], content=content).areas == pytest.approx(areas)


def test_options_are_shown_by_help():
    shown = inspect.signature(lamella.slice).parameters
    assert {*OPTIONS, "mesh", "faces", "unit", "normal", "orient_shells", "memory_limit", "threads", "progress"} == set(shown)
    assert (shown["fill_rule"].default, shown["stitch"].default, shown["heights"].default) == ("non-zero", "auto", None)
    assert all(f"\n    {name} : " in lamella.slice.__doc__ for name in shown)
    assert 'stitch : float or \'auto\'\n        Join ends of open polylines' in lamella.slice.__doc__


def test_threads_are_those_asked_for(torus):
    one, two = (lamella.slice(*torus, threads=threads) for threads in (1, 2))
    assert (one.info["threads"], one.hash) == (1, two.hash)


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


CASES = [
    (["--layer-height", "0.5", "--layers", "2:6"], {"layer_height": 0.5, "layers": (2, 6)}),
    (["--stitch-direction", "any", "--grid", "finest"], {"stitch_direction": "any", "grid": "finest"}),
    (["--planes", "1,-2,3.5"], {"heights": [1, -2, 3.5]}),
    (["--normal", "1,2,3"], {"normal": [1, 2, 3]}),
    (["--unit", "in", "--side", "above", "--datum", "zero"], {"unit": "in", "side": "above", "datum": "zero"}),
    (["--grid", "0.001", "--first-height", "0.5"], {"grid": 0.001, "first_height": 0.5}),
    (["--fill-rule", "non-zero", "--closing", "0.3", "--offset", "-0.2"], {"fill_rule": "non-zero", "closing": 0.3, "offset": -0.2}),
    (["--simplify", "0.05", "--flag-closing", "0.4"], {"simplify": 0.05, "flag_closing": 0.4}),
]


@pytest.mark.filterwarnings("ignore::lamella.MeshWarning")
@needs_tool
@pytest.mark.parametrize("arguments, options", CASES)
def test_slices_are_those_of_the_command_line_tool(torus, tmp_path, arguments, options):
    path = tmp_path / "torus.off"
    write_off(path, torus[0].astype("f4"), torus[1])
    printed = subprocess.run([TOOL, "slice", path, "--hash", *arguments], check=True, capture_output=True, text=True).stdout
    expected = re.search(r"^hash +(\w+)$", printed, re.MULTILINE)[1]
    assert lamella.slice(path, **options).hash == expected
    mesh = lamella.read(path)
    assert lamella.slice(mesh.vertices.copy(), mesh.faces.astype("i8"), **options).hash == expected
