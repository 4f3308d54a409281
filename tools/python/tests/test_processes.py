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


def test_eight_threads_share_meshes_and_results_and_have_their_own_arrays(torus):
    vertices, faces = torus
    prepared = lamella.prepare(*torus)
    shared = lamella.slice(*torus, heights=np.linspace(-6, 6, 50))

    def work(scale):
        own = lamella.slice(vertices * scale, faces, heights=shared.layers["z"] * scale)
        assert prepared.slice(shared.layers["z"]).hash == shared.hash
        return own.areas / scale**2

    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for areas in pool.map(work, [1.0, 2.0, 4.0, 8.0] * 16):
            assert np.allclose(areas, shared.areas, rtol=1e-3, atol=1e-3)
