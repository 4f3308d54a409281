#!/usr/bin/python3
"""Compares the layers of other ways to cut a mesh from Python, which bench/scripts/python.py times, with lamella's.

    tests/python_peers/agree.py LAMELLA numpy|vtk|package

Makes small meshes with the tool, slices them with it, and cuts them at the heights that its SVG states. Every layer must have
as many contours and the same area and perimeter. Exit status 77 if the peer is not installed.
"""

import importlib
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

try:
    import numpy as np
except ImportError:
    print(f"skipped: {sys.executable} has no numpy (python3-numpy)")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench" / "python"))
import meshes  # noqa: E402
import plane_by_plane  # noqa: E402

# Shape, triangles, layer height in mm. The gyroid has layers of many contours, the prism few triangles.
MODELS = [("sphere", 500, 4), ("torus", 3000, 1.5), ("gyroid", 20000, 5), ("bone", 5000, 3), ("prism", 200, 10)]
GROUP = "{http://www.w3.org/2000/svg}g"
CUT_Z = "{urn:lamella}cut-z"
# By which points may lie elsewhere, mm: the SVG has 6 decimals, VTK computes in float32.
APART = {"numpy": 1e-6, "vtk": 2e-5, "package": 1e-6}
FEWEST_LAYERS = 10


def run(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True).stdout


def layers_of(svg):
    """The height of each plane as it was cut, and its contours."""
    for group in ElementTree.fromstring(svg).iter(GROUP):
        yield float(group.get(CUT_Z)), [
            np.array([point.split(",") for point in polygon.get("points").split()], dtype=float) for polygon in group
        ]


def measured(contours):
    """Number of contours, area, perimeter."""
    return len(contours), sum(map(meshes.signed_area, contours)), sum(map(meshes.length, contours))


def by_numpy(mesh, heights, _):
    cut = plane_by_plane.Mesh(*mesh)
    for height in heights:
        yield "numpy", measured(cut.contours(height))


def by_vtk(mesh, heights, _):
    import vtk_cutters

    data = vtk_cutters.poly_data(*mesh)
    cutter = vtk_cutters.Cutter(data)
    of_all = vtk_cutters.polylines(vtk_cutters.Cutter(data).cut(heights))
    nearest = [int(np.argmin(np.abs(np.array(heights) - line[0, 2]))) for line in of_all]
    for i, height in enumerate(heights):
        yield "vtkCutter", measured_polylines(vtk_cutters.polylines(cutter.cut([height])))
        yield "vtkCutter, all planes", measured_polylines([line for line, at in zip(of_all, nearest) if at == i])


def measured_polylines(lines):
    """VTK orients nothing, so areas are those within an odd number of contours."""
    if not all(np.array_equal(line[0], line[-1]) for line in lines):
        return "open polylines", 0, 0
    contours = [line[:-1, :2].astype(float) for line in lines]
    return len(contours), meshes.area_by_nesting(contours), sum(map(meshes.length, contours))


def by_package(mesh, heights, layer_mm):
    import lamella

    result = lamella.slice(*mesh, layer_height=layer_mm)
    for i in range(len(heights)):
        yield "lamella.slice", (len(result[i].contours), result.areas[i], result.perimeters[i])


PEERS = {"numpy": (by_numpy, "numpy"), "vtk": (by_vtk, "vtkmodules.vtkFiltersCore"), "package": (by_package, "lamella")}


def differences(answers, layers, apart):
    """Lines that say where a peer's answers, some for each layer, differ."""
    if len(layers) < FEWEST_LAYERS or not answers or len(answers) % len(layers) != 0:
        yield f"{len(answers)} answers for {len(layers)} layers"
        return
    for i, (name, (count, area, perimeter)) in enumerate(answers):
        height, contours = layers[i * len(layers) // len(answers)]
        own_count, own_area, own_perimeter = measured(contours)
        within = apart * (own_perimeter + sum(map(len, contours)))
        if count != own_count or abs(area - own_area) > within or abs(perimeter - own_perimeter) > within:
            yield (f"z {height}: {name} has {count} contours, {area} mm2, {perimeter} mm around; "
                   f"lamella {own_count}, {own_area}, {own_perimeter}")  # fmt: skip


def check_open_mesh(path):
    """Without one of the triangles that it cuts, the numpy method says so."""
    vertices, faces = meshes.read_stl(path)
    height = float(vertices[:, 2].mean()) + 1e-5
    cut = plane_by_plane.Mesh(vertices, faces).crossing(height)[0]
    try:
        plane_by_plane.Mesh(vertices, np.delete(faces, cut, axis=0)).contours(height)
    except plane_by_plane.OpenLayer:
        return []
    return ["the numpy method finds closed contours in an open layer"]


def check_shared_edge():
    """Four triangles meet at an edge: the areas of both prisms count, however contours join there."""
    prism = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 9], [3, 0, 9], [0, 3, 9]], dtype=float)
    faces = np.array([[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
    vertices = np.concatenate([prism, prism * [-1, -1, 1]])  # turned by half a circle about the edge from 0 to 3
    both = np.concatenate([faces, faces + 6])
    both[both == 6], both[both == 9] = 0, 3
    area = sum(map(meshes.signed_area, plane_by_plane.Mesh(vertices, both).contours(4.5)))
    return [] if abs(area - 9) < 1e-9 else [f"two prisms at one edge: {area} mm2 instead of 9"]


def main():
    if len(sys.argv) != 3 or sys.argv[2] not in PEERS:
        sys.exit(__doc__)
    tool, peer = sys.argv[1:]
    try:
        importlib.import_module(PEERS[peer][1])
    except ModuleNotFoundError as error:
        if error.name.split(".")[0] != PEERS[peer][1].split(".")[0]:
            raise
        print(f"skipped: {peer}: {error}")
        return 77
    found = check_shared_edge() if peer == "numpy" else []
    with tempfile.TemporaryDirectory() as folder:
        for shape, triangles, layer_mm in MODELS:
            path = pathlib.Path(folder) / f"{shape}.stl"
            run(tool, "make", shape, "--triangles", triangles, "-o", path)
            layers = list(layers_of(run(tool, "slice", path, "--layer-height", layer_mm, "-o", "-")))
            answers = list(PEERS[peer][0](meshes.read_stl(path), [height for height, _ in layers], layer_mm))
            print(f"{shape}: {len(answers)} answers compared")
            found += [f"{shape}, {line}" for line in differences(answers, layers, APART[peer])]
            found += check_open_mesh(path) if peer == "numpy" else []
    print(*found, sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
