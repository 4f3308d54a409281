"""Options: what they do is the engine's tests' to show; that each arrives, as in the command line tool, is shown here."""

import inspect
import os
import pickle
import re
import subprocess

import numpy as np
import pytest
from support import write_off

import lamella
from lamella._options import OPTIONS

TOOL = os.environ.get("LAMELLA_TOOL")


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
    assert given == {**defaults, **expected}
    assert all(defaults[field] != member for field, member in expected.items())


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
@pytest.mark.skipif(TOOL is None, reason="LAMELLA_TOOL does not name the command line tool")
@pytest.mark.parametrize("arguments, options", CASES)
def test_slices_are_those_of_the_command_line_tool(torus, tmp_path, arguments, options):
    path = tmp_path / "torus.off"
    write_off(path, torus[0].astype("f4"), torus[1])
    printed = subprocess.run([TOOL, "slice", path, "--hash", *arguments], check=True, capture_output=True, text=True).stdout
    expected = re.search(r"^hash +(\w+)$", printed, re.MULTILINE)[1]
    assert lamella.slice(path, **options).hash == expected
    mesh = lamella.read(path)
    assert lamella.slice(mesh.vertices.copy(), mesh.faces.astype("i8"), **options).hash == expected
