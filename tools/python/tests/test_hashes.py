"""The same bytes as the C++ library, by its hash: of the command line tool, and of one form of a mesh against another."""

import os
import re
import subprocess

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support import write_off

import lamella

TOOL = os.environ.get("LAMELLA_TOOL")


def tool_hash(path, arguments):
    printed = subprocess.run([TOOL, "slice", path, "--hash", *arguments], check=True, capture_output=True, text=True).stdout
    return re.search(r"^hash +(\w+)$", printed, re.MULTILINE)[1]


CASES = [
    (["--layer-height", "0.1"], {"layer_height": 0.1}),
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
@pytest.mark.skipif(TOOL is None, reason="LAMELLA_TOOL does not name the command line tool")
@pytest.mark.parametrize("arguments, options", CASES)
def test_slices_are_those_of_the_command_line_tool(torus, tmp_path, arguments, options):
    path = tmp_path / "torus.off"
    write_off(path, torus[0].astype("f4"), torus[1])
    expected = tool_hash(path, arguments)
    assert lamella.slice(path, **options).hash == expected
    mesh = lamella.read(path)
    assert lamella.slice(mesh.vertices.copy(), mesh.faces.astype("i8"), **options).hash == expected


coordinate = st.floats(-50, 50, width=32)
mesh_of_any_kind = st.integers(4, 12).flatmap(
    lambda count: st.tuples(
        st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=count, max_size=count),
        st.lists(st.tuples(*[st.integers(0, count - 1)] * 3), min_size=1, max_size=20),
    )
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(mesh_of_any_kind, st.lists(st.floats(-60, 60), max_size=6), st.sampled_from(["contours", "non-zero", "even-odd"]))
@pytest.mark.filterwarnings("ignore::lamella.MeshWarning")
def test_every_form_of_a_mesh_gives_the_same_result(mesh, heights, rule):
    vertices, faces = np.array(mesh[0], dtype="f4"), np.array(mesh[1])
    options = {"heights": heights, "fill_rule": rule, "allow_empty": True}
    expected = lamella.slice(vertices, faces, **options)
    wide = np.zeros((len(vertices), 5), dtype="f4")
    wide[:, 1:4] = vertices
    assert lamella.slice(wide[:, 1:4], faces.astype("u4"), **options).hash == expected.hash
    assert lamella.slice(vertices[faces], **options).hash == expected.hash
    assert lamella.slice(vertices[faces].reshape(-1, 9), **options).hash == expected.hash
    assert lamella.slice_parts([(vertices, faces)], **options).hash == expected.hash
    streamed = list(lamella.stream(vertices, faces, chunk=2, **options))
    points = [chunk.points_grid for chunk in streamed]
    assert np.array_equal(np.concatenate([expected.points_grid[:0], *points]), expected.points_grid)
    total = sum(contour_area for chunk in streamed for contour_area in chunk.contour_areas)
    assert total == pytest.approx(expected.contour_areas.sum(), abs=1e-9)
