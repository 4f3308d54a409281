"""Meshes that the tests share."""

import sys
from pathlib import Path

import numpy as np
import pytest

import lamella

sys.path.append(str(Path(__file__).parent))  # for support.py

CORNERS = np.array([[x, y, z] for z in (0, 10) for y in (0, 10) for x in (0, 10)], dtype=float)
FACES = np.array(
    [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
)


@pytest.fixture
def cube():
    """Vertices and faces of a cube from 0 to 10 mm."""
    return CORNERS.copy(), FACES.copy()


@pytest.fixture
def box_with_cavity():
    """A cube of 10 mm around an empty one of 4 mm."""
    inner = 3 + 0.4 * CORNERS
    return np.vstack((CORNERS, inner)), np.vstack((FACES, FACES[:, ::-1] + len(CORNERS)))


@pytest.fixture
def torus():
    """A closed mesh of many triangles: vertices and faces."""
    count = 48
    u, v = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    a, b = 2 * np.pi * u / count, 2 * np.pi * v / count
    ring = 20 + 7 * np.cos(b)
    vertices = np.column_stack((ring.ravel() * np.cos(a).ravel(), 7 * np.sin(b).ravel(), ring.ravel() * np.sin(a).ravel()))
    at = lambda i, j: (i % count) * count + j % count  # noqa: E731
    first = np.stack((at(u, v), at(u + 1, v + 1), at(u + 1, v)), axis=-1).reshape(-1, 3)
    second = np.stack((at(u, v), at(u, v + 1), at(u + 1, v + 1)), axis=-1).reshape(-1, 3)
    return vertices, np.vstack((first, second))


@pytest.fixture
def matplotlib():
    """It draws into memory."""
    module = pytest.importorskip("matplotlib")
    module.use("Agg")
    return module


@pytest.fixture(autouse=True)
def examples(doctest_namespace):
    """Names that the examples in docstrings take for granted."""
    doctest_namespace.update(
        lamella=lamella,
        np=np,
        corners=np.array([[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 40]], dtype=float),
        faces=np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
    )
