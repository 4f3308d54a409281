"""Forked and spawned processes slice, and never hang. Threads slice at once."""

import concurrent.futures
import multiprocessing
import threading

import numpy as np
import pytest
from support import answer, hash_of

import lamella


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
    threads = [threading.Thread(target=slice_on) for _ in range(3)]
    for thread in threads:
        thread.start()
    try:
        assert {hash_in_fork(torus) for _ in range(40)} == {expected}
    finally:
        stop.set()
        for thread in threads:
            thread.join()


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
