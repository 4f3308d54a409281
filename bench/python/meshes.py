"""Meshes as arrays, and what is compared of layers."""

import numpy as np

STL_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
STL_HEAD = 84


def read_stl(path):
    """Vertices (n, 3) float32 without duplicates, and faces (m, 3) int32, of a binary STL file."""
    corners = np.fromfile(path, dtype=STL_FACET, offset=STL_HEAD)["corners"].reshape(-1, 3) + np.float32(0)  # -0 is 0
    rows = np.ascontiguousarray(corners).view([("x", "<f4"), ("y", "<f4"), ("z", "<f4")]).reshape(-1)
    unique, index = np.unique(rows, return_inverse=True)
    return unique.view("<f4").reshape(-1, 3), index.reshape(-1, 3).astype(np.int32)


def signed_area(contour):
    x, y = (contour - contour[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def encloses(contour, point):
    """Whether a closed contour encloses a point that does not lie on it."""
    x, y = (contour - point).T
    next_x, next_y = np.roll(x, -1), np.roll(y, -1)
    spans = (y > 0) != (next_y > 0)
    at = x[spans] - y[spans] * (next_x[spans] - x[spans]) / (next_y[spans] - y[spans])
    return bool(np.count_nonzero(at > 0) % 2)


def area_by_nesting(contours):
    """The area that an odd number of contours enclose, whatever their orientation. They must not cross."""
    def depth(i):
        return sum(encloses(other, contours[i][0]) for j, other in enumerate(contours) if j != i)

    return sum((-1) ** depth(i) * abs(signed_area(contours[i])) for i in range(len(contours)))
