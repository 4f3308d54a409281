"""combine(): sets of every form, rules of every form, and what is refused."""

import pickle
import threading

import numpy as np
import pytest

import lamella

SQUARE = np.array([[0, 0], [4, 0], [4, 4], [0, 4]])


@pytest.fixture
def pair(cube):
    """A cube, and one moved by 5 mm along x and y, at the same planes."""
    vertices, faces = cube
    return lamella.slice(vertices, faces, layer_height=2), lamella.slice(vertices + (5, 5, 0), faces, layer_height=2)


@pytest.mark.parametrize("rule, area, parts", [("unite", 175, 1), ("subtract", 75, 1), ("intersect", 25, 1), ("exclusive", 150, 1), ("last", 175, 2)])
def test_rules_by_name(pair, rule, area, parts):
    combined = lamella.combine(pair, rule)
    assert combined.areas == pytest.approx([area] * 5)
    assert combined.info["part_count"] == parts
    assert combined.layers["z"].tolist() == pair[0].layers["z"].tolist()
    if rule not in ("subtract", "last"):
        assert lamella.combine(pair[::-1], rule).hash == combined.hash


def test_tables_and_functions_label(pair):
    areas = lambda result: [result.contour_areas[result.contours["part"] == part][0] for part in range(3)]  # noqa: E731
    by_table = lamella.combine(pair, [0, 1, 2, 3])
    assert areas(by_table) == pytest.approx([75, 75, 25])
    asked = []

    def label(first, second):
        asked.append((first, second))
        return first + 2 * second

    assert lamella.combine(pair, label).hash == by_table.hash
    assert asked == [(False, False), (True, False), (False, True), (True, True)]
    assert lamella.combine(pair, np.array([0, 1, 2, 3], dtype="u1")).hash == by_table.hash
    assert lamella.combine(pair, lambda a, b: np.bool_(a and not b)).hash == lamella.combine(pair, "subtract").hash
    sixteen = lamella.combine([pair[0]] * 16, lambda *inside: all(inside))
    assert sixteen.areas == pytest.approx([100] * 5)


def test_sets_are_grown_shifted_and_parts(cube):
    vertices, faces = cube
    step = np.concatenate((vertices[faces], (vertices * (0.5, 1, 1) + (0, 0, 10))[faces]))
    s = lamella.slice(step, layer_height=5)
    assert s.areas == pytest.approx([100, 100, 50, 50])
    assert lamella.combine([s, s.shifted(1)], "subtract").areas == pytest.approx([0, 50, 0, 50])
    assert lamella.combine([s.shifted(-1, 1)]).areas == pytest.approx([100, 100, 100, 50])
    assert lamella.combine([s.grown(1)]).areas == pytest.approx([144, 144, 84, 84])
    assert lamella.combine([s[0].grown(-1).shifted(7)]).areas == pytest.approx([64])
    assert lamella.combine([s, s[2]], "intersect").areas == pytest.approx([50] * 4)
    both = lamella.slice_parts([cube, (vertices + (5, 0, 0), faces)], layer_height=5)
    assert lamella.combine([both.of_part(0), both.of_part(1)], "intersect").areas == pytest.approx([50, 50])
    assert lamella.combine([both, s[0]], offset=-1).areas == pytest.approx([104, 104])


def test_contours_stand_at_every_height(pair):
    for square in (SQUARE, [SQUARE], [SQUARE.tolist()], lamella.region_of([SQUARE])):
        assert lamella.combine([pair[0], square], "subtract").areas == pytest.approx([84] * 5)
    ring = [SQUARE, SQUARE[::-1] / 2 + 1]
    assert lamella.combine([ring]).areas == pytest.approx([12])
    assert lamella.combine([lamella.LayerSet([SQUARE, SQUARE / 2 + 1], fill_rule="even-odd")]).areas == pytest.approx([12])
    assert lamella.combine([SQUARE], grid=0.5).grid == 0.5
    assert len(lamella.combine([[]]).contours) == 0


def test_answers_are_results(pair, tmp_path):
    combined = lamella.combine(pair, "last", threads=1)
    assert combined.hash == lamella.combine(pair, "last").hash == pickle.loads(pickle.dumps(combined)).hash
    assert combined.volume == pytest.approx(1750)
    assert lamella.combine([combined]).areas == pytest.approx([175] * 5)
    combined.save(tmp_path / "combined.svg")
    with pytest.raises(lamella.InvalidArgumentError, match="the certificate needs the whole mesh"):
        assert combined.certificate


def test_calls_run_side_by_side_and_can_be_stopped(torus):
    s = lamella.slice(*torus, layer_height=0.02)
    expected = lamella.combine([s, s.shifted(1).grown(0.1)], "subtract").hash
    found = []
    threads = [threading.Thread(target=lambda: found.append(lamella.combine([s, s.shifted(1).grown(0.1)], "subtract").hash)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected, expected]
    fractions = []
    lamella.combine([s, s.shifted(1)], progress=fractions.append)
    assert fractions[-1] == 1

    def stop(fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lamella.combine([s, s.shifted(1)], progress=stop)


def raising(*inside):
    raise LookupError("of the rule")


WRONG = [
    ([], {}, "from 1 to 63 sets of layers can be combined, not 0"),
    ([SQUARE], {"rule": "minus"}, "rule must be one of 'unite', 'subtract'"),
    ([SQUARE], {"rule": [0, 1, 1]}, "rule must have 2\\*\\*1 labels for 1 sets in one dimension, and has shape \\(3,\\)"),
    ([SQUARE], {"rule": np.array([], dtype=int)}, "and has shape \\(0,\\)"),
    ([SQUARE], {"rule": [0, -1]}, "labels of rule must be from 0 to 65535, and reach from -1 to 0"),
    ([SQUARE], {"rule": [0, 65536]}, "and reach from 0 to 65536"),
    ([SQUARE], {"rule": [0.0, 1.0]}, "rule must be integers"),
    ([SQUARE], {"rule": [[0, 1]]}, "and has shape \\(1, 2\\)"),
    ([SQUARE], {"rule": lambda inside: "a"}, "rule must give a label or True or False, and gives 'a' for False"),
    ([SQUARE], {"rule": lambda inside: True}, "what lies in no set has the label 1"),
    ([SQUARE] * 17, {"rule": max}, "a function as rule takes at most 16 sets, and there are 17"),
    ([SQUARE], {"fill_rule": "even-odd"}, "fill_rule is not for combine"),
    ([SQUARE], {"fill_from": [(2, "even-odd")]}, "fill_from is not for combine"),
    ([SQUARE], {"layer_height": 1}, "layer_height is an option of slice"),
    ([SQUARE], {"grid": 0}, "grid must be finite and more than 0 mm"),
    (["body.h5"], {}, "sets\\[0\\] must be a Result, a Layer, a LayerSet or contours, not 'body.h5'"),
    ([7], {}, "sets\\[0\\] must be a Result"),
    ([[SQUARE[0]]], {}, "sets\\[0\\]\\[0\\] must have shape \\(n, 2\\)"),
    ([lamella.LayerSet([SQUARE], grow="far")], {}, "grow of sets\\[0\\] must be a number"),
    ([lamella.LayerSet([SQUARE], first=0.5)], {}, "first of sets\\[0\\] must be a whole number"),
    ([lamella.LayerSet([SQUARE], last=2**31)], {}, "last of sets\\[0\\] must be within 2\\*\\*31 layers"),
    ([lamella.LayerSet([SQUARE], part=-1)], {}, "part of sets\\[0\\] must not be negative"),
    ([lamella.LayerSet([SQUARE], part=2**32)], {}, "part of sets\\[0\\] must be below 2\\*\\*32"),
    ([lamella.LayerSet([SQUARE], fill_rule="odd")], {}, "fill_rule of sets\\[0\\] must be one of"),
]


@pytest.mark.parametrize("sets, options, message", WRONG)
def test_what_is_wrong_is_refused(sets, options, message):
    with pytest.raises(lamella.InvalidArgumentError, match=message):
        lamella.combine(sets, **options)


def test_what_fails_later_is_refused_by_its_kind(pair):
    with pytest.raises(lamella.CoordinateError, match=r"sets\[0\]\[0\]\[0\] has a coordinate that is not finite"):
        lamella.combine([np.array([[np.nan, 0], [1, 1], [0, 1]])])
    with pytest.raises(LookupError, match="of the rule"):
        lamella.combine(pair, raising)
    with pytest.raises(lamella.ResultTooLargeError, match="more than the memory limit of 100 bytes"):
        lamella.combine(pair, memory_limit=100)


def test_offsets_move_edges_step_by_step(pair):
    walls = lamella.offset(pair[0], [-0.5, -1.0, -1.0])
    assert walls.info["part_count"] == 3
    for part, area in enumerate([81, 49, 25]):
        assert lamella.combine([walls.of_part(part)]).areas == pytest.approx([area] * 5)
    assert lamella.offset(pair[0], -0.5).areas == pytest.approx([81] * 5)
    assert lamella.offset(pair[0], [-2, 2], keep="last").hash == lamella.offset(pair[0], [-2, 2], keep=[False, True]).hash
    assert lamella.offset(pair[0].grown(-1), [1]).areas == pytest.approx([100] * 5)
    round_one = lamella.offset([SQUARE], 1, join="round", arc_tolerance=0.001)
    assert round_one.areas == pytest.approx([16 + 16 + np.pi], abs=0.01)


def test_lines_get_a_width():
    line = np.array([[0, 0], [10, 0]])
    for end, area in {"butt": 20, "square": 24, "round": 20 + np.pi}.items():
        assert lamella.offset([line], 1, end=end, arc_tolerance=1e-4).areas == pytest.approx([area], abs=1e-3)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"steps": []}, "an offset has from 1 to 65535 steps, not 0"),
        ({"steps": 0}, "step 0: the offset of 0 mm moves nothing"),
        ({"steps": "far"}, "steps must be a number"),
        ({"steps": 1, "join": "bevel"}, "join must be one of 'miter', 'round', 'square', not 'bevel'"),
        ({"steps": 1, "end": 1}, "end must be one of"),
        ({"steps": [1, 2], "keep": [True]}, "keep has 1 flags for 2 steps"),
        ({"steps": 1, "fill_rule": "positive"}, "fill_rule is not for offset"),
    ],
)
def test_offsets_are_refused_by_name(pair, arguments, message):
    with pytest.raises(lamella.InvalidArgumentError, match=message):
        lamella.offset(pair[0], **arguments)


HATCH = [[[-1, y], [5, y]] for y in range(-1, 6)]


def test_lines_are_clipped(pair):
    inside = lamella.clip(HATCH, SQUARE)
    assert inside[0].contours["part"].tolist() == [1, 2, 3, 4, 5]
    assert inside.points.reshape(5, 2, 2).tolist() == [[[0, y], [4, y]] for y in range(5)]
    assert len(lamella.clip(HATCH, SQUARE, boundary_inside=False).contours) == 3
    assert len(lamella.clip(HATCH, SQUARE, inside=False, threads=1).contours) == 12
    assert lamella.clip(np.array(HATCH[2]), [SQUARE]).hash == lamella.clip([HATCH[2]], SQUARE).hash
    stack = lamella.clip(pair[0], pair[1].shifted(-1).grown(1))
    assert len(stack) == 5 and len(stack[0].contours) == 0 and stack.info["open_contours"] == 4
    assert lamella.clip(pair[0][2], pair[1].grown(1))[2].contours["part"].tolist() == [0]
    with pytest.raises(lamella.InvalidArgumentError, match="offset is an option of slice"):
        lamella.clip(HATCH, SQUARE, offset=1)
    with pytest.raises(lamella.InvalidArgumentError, match="lines must be a Result, a Layer or polylines"):
        lamella.clip(pair[0].grown(1), SQUARE)
    with pytest.raises(lamella.ResultTooLargeError, match="more than the memory limit of 100 bytes"):
        lamella.clip(HATCH, SQUARE, memory_limit=100)
