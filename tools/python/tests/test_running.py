"""Calls while they run: progress, signals, forks and spawned processes, and threads that slice at once."""

import importlib.util
import inspect
import multiprocessing
import pickle
import signal
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from support import answer, hash_of, write_stl

import lamella

REGION = {"fill_rule": "non-zero", "offset": 0.3}


@pytest.fixture
def large(torus):
    """Fine enough for calls of half a second."""
    vertices, faces = torus
    moved = np.vstack([vertices + [60 * i, 0, 0] for i in range(40)])
    return moved, np.vstack([faces + i * len(vertices) for i in range(40)])


class EndedError(Exception):
    """Raised by a handler or a callable."""


def end(*arguments):
    raise EndedError(*arguments)


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
    "section_multiplane": lambda mesh, progress: lamella.section_multiplane(mesh, [0, 0, 0], [0, 1, 1], [0.1, 1], progress=progress),
    "stream": lambda mesh, progress: list(lamella.stream(*mesh, layer_height=0.05, progress=progress)),
}


def test_every_call_that_takes_a_callable_is_listed():
    calls = [name for name in lamella.__all__ if inspect.isfunction(getattr(lamella, name))]
    assert {name for name in calls if "progress" in inspect.signature(getattr(lamella, name)).parameters} <= set(CALLS)


@pytest.mark.parametrize("call", CALLS)
def test_fractions_rise_to_one_on_the_calling_thread_and_an_exception_ends_the_call(call, large):
    heard, threads = [], set()
    CALLS[call](large, lambda fraction: (heard.append(fraction), threads.add(threading.get_ident())))
    assert heard == sorted(set(heard))
    assert (heard[0] > 0, heard[-1], threads) == (True, 1, {threading.get_ident()})
    with pytest.raises(EndedError):
        CALLS[call](large, end)
    assert lamella.slice(*large, heights=[0.1]).areas[0] > 0


def test_a_long_call_tells_its_progress_meanwhile_and_ends_at_once_where_that_raises(large):
    options = {"layer_height": 0.005, "fill_rule": "non-zero", "closing": 0.05, "threads": 1}
    heard = []
    lamella.slice(*large, **options, progress=heard.append)
    assert len(heard) > 3
    with pytest.raises(EndedError) as raised:
        lamella.slice(*large, **options, progress=end)
    assert raised.value.args[0] < 0.9


@pytest.mark.parametrize("progress", [True, False, None])
def test_true_shows_a_bar(cube, capsys, progress):
    lamella.slice(*cube, layer_height=1, progress=progress)
    told = capsys.readouterr().err
    assert "100%" in told if progress and importlib.util.find_spec("tqdm") else told == ""  # no terminal


def test_results_do_not_keep_the_callable(cube):
    result = lamella.slice(*cube, layer_height=1, progress=lambda fraction: None)  # which cannot be pickled
    assert pickle.loads(pickle.dumps(result)).hash == result.hash


@pytest.fixture
def alarm():
    """Sets the time until a signal whose handler raises, as that of Ctrl-C does."""
    before = signal.signal(signal.SIGALRM, end)
    yield lambda seconds: signal.setitimer(signal.ITIMER_REAL, seconds)
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


def long_slice(torus):
    """Takes seconds, and little memory until it is at its end."""
    return lamella.slice(*torus, layer_height=0.0001, **REGION)


def next_of_a_stream(torus):
    return next(lamella.stream(*torus, layer_height=0.0001, chunk=10**6, **REGION))


@pytest.mark.parametrize("call", [long_slice, next_of_a_stream])
def test_a_call_ends_when_a_handler_raises_and_those_of_other_threads_go_on(torus, alarm, call):
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(lamella.slice, *torus, layer_height=0.01, **REGION)
        alarm(0.2)
        begun = time.perf_counter()
        with pytest.raises(EndedError):
            call(torus)
        assert time.perf_counter() - begun < 1.2
    assert other.result().hash == lamella.slice(*torus, layer_height=0.01, **REGION).hash


def test_the_interpreter_is_free_during_a_call(torus):
    steps = 0
    with ThreadPoolExecutor(1) as pool:
        call = pool.submit(lamella.slice, *torus, layer_height=0.001, **REGION)
        while not call.done():
            steps += 1
            time.sleep(0.001)
    assert steps > 20


def hash_in_fork(mesh):
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    child = context.Process(target=answer, args=(mesh, answers))
    child.start()
    try:
        return answers.get(timeout=60)
    finally:
        child.join(30)
        if child.is_alive():
            child.kill()


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_children_slice_after_their_parent_has(method, torus):
    vertices, faces = torus
    meshes = [(vertices * [1, 1, 1 + 0.1 * i], faces) for i in range(6)]
    expected = [hash_of(mesh) for mesh in meshes]  # the parent's worker threads are there now; forked children have none
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(hash_of, meshes).get(timeout=120) == expected


def test_a_fork_while_other_threads_slice_does_not_hang(torus):
    stop = threading.Event()

    def slice_on():
        while not stop.is_set():
            hash_of(torus)

    expected = hash_of(torus)
    with ThreadPoolExecutor(3) as pool:
        others = [pool.submit(slice_on) for _ in range(3)]
        try:
            assert {hash_in_fork(torus) for _ in range(40)} == {expected}
        finally:
            stop.set()
    assert [other.result() for other in others] == [None] * 3


def test_eight_threads_share_meshes_and_results_and_have_their_own_arrays(torus):
    vertices, faces = torus
    prepared = lamella.prepare(*torus)
    shared = lamella.slice(*torus, heights=np.linspace(-6, 6, 50))

    def work(scale):
        own = lamella.slice(vertices * scale, faces, heights=shared.layers["z"] * scale)
        assert prepared.slice(shared.layers["z"]).hash == shared.hash
        return own.areas / scale**2

    with ThreadPoolExecutor(8) as pool:
        for areas in pool.map(work, [1.0, 2.0, 4.0, 8.0] * 16):
            assert np.allclose(areas, shared.areas, rtol=1e-3, atol=1e-3)
