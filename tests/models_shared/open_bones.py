#!/usr/bin/env python3
"""Masks of open bones beside generalized winding numbers: open_bones.py LAMELLA MODELS. Ends with 77 where there are no models.

The generalized winding number of a point is the solid angle that all triangles cover seen from there, over 4 pi: 1 inside of a
closed mesh and 0 outside; near a small hole it is between, and inside is where it exceeds a half (Jacobson and others, 2013).
It is compared at 20,000 voxel centres, half of them within two voxels of the surface.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import zlib

import numpy as np

LEAST_DICE = 0.99
POINTS = 20_000
BLOCK = 8  # triangles that are not halved further
FAR = 3  # times the radius of a block


def read_stl(path):
    data = path.read_bytes()
    rows = np.frombuffer(data, np.dtype([("floats", "<f4", 12), ("end", "<u2")]), offset=84)
    return rows["floats"][:, 3:].reshape(-1, 3, 3).astype(float)


def read_mask(path):
    """Voxels [k, j, i], origin and spacing, which is the same along all axes."""
    head, body = path.read_bytes().split(b"\n\n", 1)
    numbers = lambda key: [float(x) for x in re.findall(r"[-+.\de]+", re.search(rf"^{key}: (.*)$", head.decode(), re.M)[1])]  # noqa: E731
    voxels = np.frombuffer(zlib.decompress(body, 31), np.uint8).reshape([int(n) for n in numbers("sizes")][::-1])
    directions = np.array(numbers("space directions")).reshape(3, 3)
    assert np.count_nonzero(directions) == 3 and (np.diag(directions) == directions[0, 0]).all(), "no cubes along the axes"
    return voxels, np.array(numbers("space origin")), directions[0, 0]


def solid_angles(triangles, points):
    """Over 4 pi, of each triangle from each point (Van Oosterom and Strackee, 1983)."""
    a, b, c = (triangles[None, :, i] - points[:, None] for i in range(3))
    la, lb, lc = (np.sqrt(np.einsum("ptx,ptx->pt", v, v)) for v in (a, b, c))
    dot = lambda u, v: np.einsum("ptx,ptx->pt", u, v)  # noqa: E731
    return np.arctan2(dot(a, np.cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb) / (2 * np.pi)


def winding_numbers(triangles, points):
    sums = np.zeros(len(points))

    def add(block, which):
        """Adds the block to these points; halves along its longest side to those that are near."""
        normals = np.cross(block[:, 1] - block[:, 0], block[:, 2] - block[:, 0]) / 2
        weights = np.linalg.norm(normals, axis=1)
        centre = np.average(block.mean(axis=1), axis=0, weights=weights)
        away = centre - points[which]
        distance = np.linalg.norm(away, axis=1)
        far = distance > FAR * np.linalg.norm(block - centre, axis=2).max()
        sums[which[far]] += away[far] @ normals.sum(axis=0) / (4 * np.pi * distance[far] ** 3)
        near = which[~far]
        if len(block) <= BLOCK:
            sums[near] += solid_angles(block, points[near]).sum(axis=1)
        elif len(near):
            centres = block.mean(axis=1)
            order = np.argsort(centres[:, np.argmax(np.ptp(centres, axis=0))], kind="stable")
            add(block[order[: len(order) // 2]], near)
            add(block[order[len(order) // 2 :]], near)

    add(triangles, np.arange(len(points)))
    return sums


def near_surface(triangles, shape, origin, spacing):
    """Voxels within two of one that holds a point of the surface: an array as the mask's."""
    hit = np.zeros(shape, bool)
    steps = int(np.ceil(np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max() / spacing)) + 1
    for i, j in ((i, j) for i in range(steps + 1) for j in range(steps + 1 - i)):
        points = np.einsum("c,tcx->tx", np.array([i, j, steps - i - j]) / steps, triangles)
        hit[tuple(np.rint((points - origin) / spacing).astype(int).clip(0, np.array(shape[::-1]) - 1).T[::-1])] = True
    for axis in range(3):
        hit = np.logical_or.reduce([np.roll(hit, by, axis) for by in range(-2, 3)])
    return hit


def dice(a, b):
    return 2 * np.count_nonzero(a & b) / (np.count_nonzero(a) + np.count_nonzero(b))


def compare(lamella, folder, bone, spacing):
    mask = folder / "mask.nrrd"
    words = [lamella, "slice", bone, "--spacing", f"{spacing},{spacing},{spacing}", "--frame", "lps", "-o", mask]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    triangles = read_stl(bone)
    voxels, origin, step = read_mask(mask)
    assert step == spacing
    random = np.random.default_rng(1)
    near = near_surface(triangles, voxels.shape, origin, spacing).ravel()
    places = np.concatenate([random.choice(np.flatnonzero(some), POINTS // 2, replace=False) for some in (near, ~near)])
    centres = origin + spacing * np.column_stack(np.unravel_index(places, voxels.shape)[::-1])
    numbers = winding_numbers(triangles, centres)
    few = random.choice(len(centres), 100, replace=False)
    assert np.abs(numbers[few] - solid_angles(triangles, centres[few]).sum(axis=1)).max() < 0.05, "blocks are too coarse"
    inside = numbers > 0.5
    found = dice(voxels.ravel()[places] != 0, inside)
    print(f"{bone.stem} at {spacing} mm: Dice {found:.4f}")
    return found


def main():
    lamella, models = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    bones = sorted((models / "bones").glob("*.stl"))
    if not bones:
        print(f"skipped: no bones in {models}")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as name:
        worst = min(compare(lamella, pathlib.Path(name), bone, spacing) for bone in bones for spacing in (0.5, 0.8))
    assert worst >= LEAST_DICE, f"Dice {worst}"


main()
