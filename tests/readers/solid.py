#!/usr/bin/env python3
"""One meaning of solid: solid.py LAMELLA [ROUNDS]. Ends with 77 where nibabel, numpy or Pillow is missing.

Random unions of boxes, spheres and pockets that touch, cross and repeat. Mask, coverage, table, certificate, picture and
structure set are compared with winding numbers, counted along vertical rays through the triangles.
"""

import csv
import struct
import sys

import support

nibabel, numpy, Image = support.need("nibabel", "numpy", "PIL.Image")

SIDE, HIGH, PICTURE_LAYER, FINE = 26, 16, 7, 4  # voxels of 1 mm, slices, the layer drawn, samples along a voxel
ORIGIN = (-0.75, -0.75, 0.5)  # quarters: FINE samples a voxel lie between the planes of boxes
MARKER = ((20, 0, -1), (24, 4, HIGH + 1))  # alone: what a pixel of the picture measures
COLOUR, HEADING = numpy.array((0x1F, 0x6F, 0xB4)), 40


def box(low, high):
    return numpy.array(support.box(low, high), dtype=float)


def sphere(centre, radius):
    faces = [((x, 0, 0), (0, y, 0), (0, 0, z)) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    faces = numpy.array([f if numpy.linalg.det(f) > 0 else f[::-1] for f in faces], dtype=float)
    for _ in range(2):
        a, b, c = faces[:, 0], faces[:, 1], faces[:, 2]
        ab, bc, ca = a + b, b + c, c + a
        faces = numpy.concatenate([numpy.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        faces /= numpy.linalg.norm(faces, axis=2, keepdims=True)
    return (faces * radius + centre).astype(numpy.float32).astype(float)


def random_mesh(random, with_spheres):
    """Shells, some repeated, some turned inwards: as pockets within a box, or anywhere."""
    def within(low, high):
        a = random.integers(low, high, 3)
        return a, a + 1 + random.integers(0, numpy.maximum(1, high - a))

    boxes, shells = [], [box(*MARKER)]
    for _ in range(random.integers(2, 6)):
        kind = random.integers(0, 6 if with_spheres else 5)
        turned = random.integers(0, 5) == 0
        if kind == 5:
            shell = sphere(random.integers(4, 12, 3), random.integers(4, 9) / 2 + 0.137)
        elif kind == 4 and boxes:
            shell = box(*boxes[random.integers(len(boxes))])
        elif kind == 3 and boxes:
            shell, turned = box(*within(*boxes[random.integers(len(boxes))])), True
        else:
            boxes.append(within(numpy.zeros(3, int), numpy.full(3, 15)))
            shell = box(*boxes[-1])
        shells.append(shell[:, ::-1] if turned else shell)
    return numpy.concatenate(shells)


def winding(triangles, xs, ys, zs):
    """[z, y, x]. The samples are moved by less than what matters, off the edges of the triangles."""
    numbers = numpy.zeros((len(zs), len(ys), len(xs)), int)
    px, py = xs[None, :] + 1.1e-7, ys[:, None] + 2.7e-7
    for a, b, c in triangles:
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0:
            continue
        wb = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area
        wc = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area
        height = numpy.where((wb >= 0) & (wc >= 0) & (wb + wc <= 1), a[2] + wb * (b[2] - a[2]) + wc * (c[2] - a[2]), -1e9)
        numbers += (zs[:, None, None] < height) * int(numpy.sign(area))
    return numbers


def picture_area(path):
    """In mm2, of all but the marker, which lies at the left: x runs to the patient's right."""
    shares = ((255.0 - numpy.asarray(Image.open(path))[HEADING:]) / (255 - COLOUR)).clip(0, 1)
    shares = numpy.where(numpy.ptp(shares, axis=2) < 0.05, shares.mean(axis=2), 0)  # mixed of white and the colour only
    columns = shares.sum(axis=0)
    first = numpy.flatnonzero(columns > 0)[0]
    end = first + numpy.flatnonzero(columns[first:] == 0)[0]
    return columns[end:].sum() / columns[first:end].sum() * 16


def structure_voxels(path, xs, ys, zs):
    """Whether an odd number of times a ray from a voxel's centre crosses the contours of its slice."""
    data, at = path.read_bytes(), 0
    inside = numpy.zeros((HIGH, SIDE, SIDE), bool)
    while (at := data.find(b"\x06\x30\x50\x00", at)) >= 0:  # ContourData, implicit VR
        (length,) = struct.unpack_from("<I", data, at + 4)
        points = numpy.array(data[at + 8 : at + 8 + length].decode().split("\\"), dtype=float).reshape(-1, 3) * (-1, -1, 1)
        slice_ = int(numpy.argmin(abs(zs - points[0, 2])))
        for (ax, ay, _), (bx, by, _) in zip(points, numpy.roll(points, -1, axis=0)):
            rows = (ay <= ys) != (by <= ys)
            if rows.any():
                cross = ax + (ys[rows] - ay) * (bx - ax) / (by - ay)
                inside[slice_, rows] ^= cross[:, None] > xs[None, :]
        at += length
    return inside


def check(name, triangles, exact, out, cov):
    voxels = lambda folder: numpy.frombuffer((folder / f"{name}.nii").read_bytes()[352:], numpy.uint8).reshape(HIGH, SIDE, SIDE)
    grids = [ORIGIN[axis] + numpy.arange((SIDE, SIDE, HIGH)[axis], dtype=float) for axis in range(3)]
    solid = winding(triangles, *grids) != 0
    assert numpy.array_equal(voxels(out) != 0, solid), "mask"
    assert numpy.array_equal(structure_voxels(out / f"{name}.dcm", *grids), solid), "structure set"
    part = (numpy.arange(FINE) + 0.5) / FINE - 0.5
    xs, ys = ((grid[:, None] + part).ravel() for grid in grids[:2])
    fine = winding(triangles, xs, ys, grids[2])
    shares = (fine != 0).reshape(HIGH, SIDE, FINE, SIDE, FINE).mean(axis=(2, 4))
    assert abs(voxels(cov) / 255 - shares).max() <= (0.5 / 255 + 1e-9 if exact else 0.25), "coverage"
    areas = shares.sum(axis=(1, 2))
    with open(out / f"{name}.csv", newline="") as table:
        found = numpy.array([float(row["area_mm2"]) for row in csv.DictReader(table)])
    assert abs(found - areas).max() <= (1e-4 if exact else 1.5), "areas"
    assert abs(found.sum() - areas.sum()) <= (1e-3 if exact else 0.01 * areas.sum()), "volume"
    assert abs(picture_area(out / f"{name}.png") - (areas[PICTURE_LAYER] - 16)) <= (1 if exact else 2.5), "picture"
    with open(out / f"{name}.meshes.csv", newline="") as table:
        facts = next(csv.DictReader(table))
    signed = fine.sum(axis=(1, 2)) / FINE**2 * (1 if float(facts["volume_mm3"]) >= 0 else -1)
    certified = facts["certificate"] == "certified"
    assert not exact or certified == bool((abs(signed - areas) < 1e-9).all()), facts["certificate"]
    return (fine < 0).any(), (fine > 1).any()


def test(run):
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 40
    meshes = {f"m{i}": random_mesh(numpy.random.default_rng(i), i % 2 == 1) for i in range(rounds)}
    (run.folder / "in").mkdir()
    for stem, triangles in meshes.items():
        (run.folder / "in" / f"{stem}.stl").write_bytes(support.stl(triangles))
    affine = numpy.eye(4)
    affine[:3, 3] = ORIGIN
    nibabel.save(nibabel.Nifti1Image(numpy.zeros((SIDE, SIDE, HIGH), numpy.uint8), affine), run.folder / "like.nii")
    common = ["batch", "in", "--like", "like.nii", "--frame", "ras", "-o"]
    run(*common, "out/{stem}", "--to", "nii,csv,png,rtstruct", "--without-ct", "--picture-layer", str(PICTURE_LAYER))
    run(*common, "cov/{stem}.nii", "--coverage")
    found = []
    for i, (stem, triangles) in enumerate(meshes.items()):
        print("round", i)
        found.append(check(stem, triangles, i % 2 == 0, run.folder / "out", run.folder / "cov"))
    below, above = numpy.sum(found, axis=0)
    assert below > rounds // 10 and above > rounds // 4, (below, above)
    return f"{rounds} meshes, {above} with winding numbers above 1, {below} below 0"


support.main(test)
