"""The usual way to cut a mesh in numpy: plane by plane, all triangles tested against each.

For each plane: the bounds of all triangles, which are computed once for all planes, interpolation on the edges of those that cross it, endpoints merged by the edge
on which they lie, and segments followed from endpoint to endpoint. Everything is vectorised but following. That is a loop over
a list, which is faster than numpy for some hundred segments in a plane.
"""

import numpy as np

# By the corners above the plane as bits: the corner that is alone on its side.
ALONE = np.array([0, 0, 1, 2, 2, 1, 0, 0])


class OpenLayer(ValueError):
    """Segments that do not join into closed contours."""


class Mesh:
    """Vertices (n, 3) and faces (m, 3), counter-clockwise as seen from outside."""

    def __init__(self, vertices, faces):
        self.vertices = np.asarray(vertices, dtype=np.float64)
        self.faces = np.asarray(faces, dtype=np.int64)
        self.z = np.ascontiguousarray(self.vertices[:, 2])
        a, b, c = self.z[self.faces.T]
        self.lowest = np.minimum(np.minimum(a, b), c)
        self.highest = np.maximum(np.maximum(a, b), c)

    def crossing(self, height):
        """The triangles that a plane crosses."""
        return np.flatnonzero((self.lowest < height) & (self.highest > height))

    def contours(self, height):
        """Closed contours of a plane that passes through no vertex: arrays (n, 2), solid on the left."""
        points, following = self._segments(height)
        return [points[contour] for contour in _cycles(following)]

    def _segments(self, height):
        """The first point of each segment, and the segment that follows it."""
        faces = self.faces[self.crossing(height)]
        above = self.z[faces] > height
        alone = ALONE[above @ np.array([1, 2, 4])]
        row = np.arange(len(faces))
        a, b, c = faces[row, alone], faces[row, (alone + 1) % 3], faces[row, (alone + 2) % 3]
        # Seen from outside, a segment leads from edge ab to edge ca where corner a is above, else back.
        upright = above[row, alone]
        first, last = np.where(upright, b, c), np.where(upright, c, b)
        return self._points(a, first, height), _following(self._edges(a, first), self._edges(a, last))

    def _edges(self, a, b):
        return np.minimum(a, b) * len(self.vertices) + np.maximum(a, b)

    def _points(self, a, b, height):
        # From the vertex of the lower index, so that both triangles of an edge give the same point.
        low, high = np.minimum(a, b), np.maximum(a, b)
        share = (height - self.z[low]) / (self.z[high] - self.z[low])
        start = self.vertices[low, :2]
        return start + share[:, None] * (self.vertices[high, :2] - start)


def _following(first, last):
    """For each segment the one that begins on the edge where it ends. At an edge of more than two triangles any of them."""
    begins, ends = np.argsort(first, kind="stable"), np.argsort(last, kind="stable")
    if not np.array_equal(first[begins], last[ends]):
        raise OpenLayer("the mesh is open, or its facets disagree, where the plane cuts it")
    following = np.empty(len(first), dtype=np.int64)
    following[ends] = begins
    return following


def _cycles(following):
    """The cycles of a permutation, as lists."""
    following = following.tolist()
    cycles = []
    for start in range(len(following)):
        cycle = []
        i = start
        while following[i] >= 0:
            cycle.append(i)
            following[i], i = -1, following[i]
        if cycle:
            cycles.append(cycle)
    return cycles
