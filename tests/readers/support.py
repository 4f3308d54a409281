"""Meshes that the tests of readers share."""

import struct


def box(low, high, inward=False):
    """The triangles of a box."""
    corner = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    turn = (0, 2, 1) if inward else (0, 1, 2)
    return [[corner[t[i]] for i in turn] for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]


def stl(triangles):
    """A binary STL file."""
    data = b"".join(struct.pack("<12fH", 0, 0, 0, *[x for v in t for x in v], 0) for t in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + data


def box_stl(low, high):
    return stl(box(low, high))
