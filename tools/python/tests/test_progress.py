"""Progress: what is told, when, and what an exception of the callable does."""

import importlib.util
import inspect
import pickle
import tempfile
import threading

import numpy as np
import pytest
from support import write_stl

import lamella


@pytest.fixture
def large(torus):
    """Fine enough for calls of half a second."""
    vertices, faces = torus
    copies = 40
    moved = np.vstack([vertices + [60 * i, 0, 0] for i in range(copies)])
    return moved, np.vstack([faces + i * len(vertices) for i in range(copies)])


class Enough(Exception):
    """Raised by a callable."""


def enough(fraction):
    raise Enough(fraction)


def read(mesh, progress):
    with tempfile.NamedTemporaryFile(suffix=".stl") as file:
        write_stl(file.name, mesh[0][mesh[1]])
        return lamella.read(file.name, progress=progress)


CALLS = {
    "read": read,
    "slice": lambda mesh, progress: lamella.slice(*mesh, layer_height=0.01, fill_rule="non-zero", closing=0.05, progress=progress),
    "slice_parts": lambda mesh, progress: lamella.slice_parts([mesh], layer_height=0.01, progress=progress),
    "prepare": lambda mesh, progress: lamella.prepare(*mesh, progress=progress),
    "prepared": lambda mesh, progress: lamella.prepare(*mesh).slice(layer_height=0.01, progress=progress),
    "check": lambda mesh, progress: lamella.check(*mesh, progress=progress),
    "weld": lambda mesh, progress: lamella.weld(*mesh, progress=progress),
    "section": lambda mesh, progress: lamella.section(mesh, [0, 0, 0.1], [0, 1, 1], progress=progress),
    "section_multiplane": lambda mesh, progress: lamella.section_multiplane(mesh, [0, 0, 0], [0, 1, 1], [0.1, 1], progress=progress),
    "stream": lambda mesh, progress: list(lamella.stream(*mesh, layer_height=0.05, progress=progress)),
}


def test_every_call_that_takes_a_callable_is_listed():
    calls = [name for name in lamella.__all__ if inspect.isfunction(getattr(lamella, name))]
    assert {name for name in calls if "progress" in inspect.signature(getattr(lamella, name)).parameters} <= set(CALLS)


@pytest.mark.parametrize("call", CALLS)
def test_fractions_rise_to_one_and_are_told_by_the_calling_thread(call, large):
    heard = []
    threads = set()
    CALLS[call](large, lambda fraction: (heard.append(fraction), threads.add(threading.get_ident())))
    assert heard == sorted(set(heard))
    assert heard[-1] == 1
    assert 0 < heard[0]
    assert threads == {threading.get_ident()}


@pytest.mark.parametrize("call", CALLS)
def test_an_exception_of_the_callable_ends_the_call(call, large):
    with pytest.raises(Enough):
        CALLS[call](large, enough)
    assert lamella.slice(*large, heights=[0.1]).areas[0] > 0


def test_a_long_call_tells_its_progress_meanwhile_and_ends_at_once_where_that_raises(large):
    options = {"layer_height": 0.005, "fill_rule": "non-zero", "closing": 0.05, "threads": 1}
    heard = []
    lamella.slice(*large, **options, progress=heard.append)
    assert len(heard) > 3
    with pytest.raises(Enough) as raised:
        lamella.slice(*large, **options, progress=enough)
    assert raised.value.args[0] < 0.9


@pytest.mark.parametrize("progress", [True, False, None])
def test_true_shows_a_bar(cube, capsys, progress):
    lamella.slice(*cube, layer_height=1, progress=progress)
    told = capsys.readouterr().err
    if progress and importlib.util.find_spec("tqdm"):
        assert "100%" in told
    else:
        assert told == ""  # no terminal


def test_results_do_not_keep_the_callable(cube):
    result = lamella.slice(*cube, layer_height=1, progress=lambda fraction: None)  # which cannot be pickled
    assert pickle.loads(pickle.dumps(result)).hash == result.hash
