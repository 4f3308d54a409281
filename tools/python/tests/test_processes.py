"""Forked and spawned processes slice, and never hang. Threads slice at once."""

import concurrent.futures
import multiprocessing
import os
import threading

import numpy as np
import pytest
from support import answer, hash_of

import lamella

METHODS = multiprocessing.get_all_start_methods()


@pytest.mark.parametrize("method", METHODS)
def test_a_child_slices_after_its_parent_has(method, torus):
    expected = hash_of(torus)  # the parent's worker threads are there now; a forked child has none of them
    context = multiprocessing.get_context(method)
    answers = context.Queue()
    child = context.Process(target=answer, args=(torus, answers))
    child.start()
    try:
        assert answers.get(timeout=60) == expected
    finally:
        child.join(30)
        if child.is_alive():
            child.kill()


@pytest.mark.parametrize("method", METHODS)
def test_a_pool_slices_many_meshes(method, torus):
    vertices, faces = torus
    meshes = [(vertices * [1, 1, 1 + 0.1 * i], faces) for i in range(6)]
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(hash_of, meshes).get(timeout=120) == [hash_of(mesh) for mesh in meshes]


def test_a_fork_while_other_threads_slice_does_not_hang(torus):
    stop = threading.Event()

    def slice_on():
        while not stop.is_set():
            hash_of(torus)

    expected = hash_of(torus)
    threads = [threading.Thread(target=slice_on) for _ in range(3)]
    for thread in threads:
        thread.start()
    try:
        context = multiprocessing.get_context("fork")
        for _ in range(10):
            answers = context.Queue()
            child = context.Process(target=answer, args=(torus, answers))
            child.start()
            try:
                assert answers.get(timeout=60) == expected
            finally:
                child.join(30)
                if child.is_alive():
                    child.kill()
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def test_a_stream_does_not_go_on_in_a_forked_child(torus):
    chunks = lamella.stream(*torus, layer_height=0.01, chunk=4)
    next(chunks)
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            next(chunks)
            os.write(writing, b"went on")
        except lamella.Error as error:
            os.write(writing, str(error).encode())
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as told:
        assert "begin it there" in told.read()
    os.waitpid(child, 0)
    assert len(next(chunks)) == 4


def test_eight_threads_share_meshes_and_results(torus):
    prepared = lamella.prepare(*torus)
    shared = lamella.slice(*torus, layer_height=0.05)

    def work(_):
        assert shared.areas.sum() > 0
        return lamella.slice(*torus, layer_height=0.05).hash, prepared.slice(layer_height=0.05).hash, shared[7].area

    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(work, range(64)))
    assert set(answers) == {(shared.hash, shared.hash, shared[7].area)}


def test_arrays_of_several_threads_are_their_own(torus):
    vertices, faces = torus
    heights = np.linspace(-6, 6, 50)

    def areas(scale):
        return lamella.slice(vertices * scale, faces, heights=heights * scale).areas / scale**2

    expected = areas(1.0)
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for answer in pool.map(areas, [1.0, 2.0, 4.0, 8.0] * 8):
            assert np.allclose(answer, expected, rtol=1e-3, atol=1e-3)
