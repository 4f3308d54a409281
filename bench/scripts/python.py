#!/usr/bin/python3
"""Times the Python package beside the same call in C++, beside the usual method in numpy, and beside VTK's filters.

    bench/scripts/python.py BUILD NAME=MESH... [--page bench/results/python.md] [--threads 2] [--rounds 9] [--quick]

NAME is liver or femur; meshes are binary STL. Needs numpy, python3-vtk9, and of BUILD the targets lamella_cli, lamella_first
and lamella_python_package. Prints the page of tables; with --page it also writes it. --quick takes few
planes and rounds, and judges no bar. The exit status is 1 if a bar is not met, 2 if an answer is wrong, 77 if the package or VTK
is missing.
"""

import argparse
import collections
import json
import pathlib
import platform
import re
import shlex
import statistics
import subprocess
import sys
import tempfile

import numpy as np

from readme_table import Bars, in_turn, machine_table, markdown_table, medians_of, ms_of, run

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
import mesh_formats  # noqa: E402
import meshes  # noqa: E402
import plane_by_plane  # noqa: E402

CALLS_A_TURN, TURN_MS = 3, 200
SMALL_TRIANGLES, SMALL_PLANES = 500, 100_000
APART_MM = {"numpy": 1e-6, "vtk": 2e-5}  # VTK computes in float32
PAGE = """# lamella in Python

`bench/scripts/python.py` made this page. What is timed is described in [bench/README.md](../README.md#python).

{machine}

## The same slice in C++

Vertices are float32, indices int32, in memory. Each side is a process of its own, and they take turns. Freeing results is not
timed. The bar is met by at most 1.05 times the time in C++ plus 200 us.

{cpp}

## Many layers of a small mesh

{layers}

## Other ways to cut the femur, layers of 0.32 mm

Times are from mesh to contours. numpy starts at arrays, VTK at a mesh of its own; `prepared` is `lamella.prepare(mesh)`. An answer
of VTK counts as another one if a polyline is open, or if the number of contours or the area is not lamella's.

{ways}
"""


def require(true, text):
    if not true:
        print(f"error: {text}", file=sys.stderr)
        sys.exit(2)


def turn_of(work):
    """Milliseconds a call, of at least TURN_MS of them: what follows another's turn finds caches and threads cold."""
    times = [ms_of(work)]
    while sum(times) < TURN_MS:
        times.append(ms_of(work))
    return statistics.fmean(times)


def turn_in_python(slice_here, use):
    """The median of some calls after one that is not counted. What one gives is freed before the next, which is not timed."""
    times, result = [], []
    for _ in range(CALLS_A_TURN + 1):
        result.clear()
        times.append(ms_of(lambda: result.append(use(slice_here()))))
    return statistics.median(times[1:])


def cpp_row(name, build, slice_mm, mesh, layer_mm, arguments, bars):
    """The result, and a row of medians, after both gave the same."""
    arrays = mesh.vertices, mesh.faces
    result = slice_mm(arrays, layer_mm)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "mesh.ply")
        mesh_formats.write(mesh_formats.FORMATS["ply_little_endian.ply"](mesh), path)
        command = [build / "bench" / "lamella_first", "python", path, repr(layer_mm), str(arguments.threads), "0", "united"]
        found = in_turn({
            "cpp": lambda: json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout),
            "python": lambda: turn_in_python(lambda: slice_mm(arrays, layer_mm), lambda result: result),
            "points": lambda: turn_in_python(lambda: slice_mm(arrays, layer_mm), lambda result: (result, result.points)),
        }, arguments.rounds)
    require({int(result.hash, 16)} == {there["hash"] for there in found["cpp"]}, "Python's result is not that of C++")
    ms = {way: statistics.median(there[f"{way}_ms"] for there in found["cpp"]) for way in ("warm", "fresh")}
    ms |= {way: statistics.median(found[way]) for way in ("python", "points")}

    def over(cpp):
        return f"{100 * (ms['python'] / cpp - 1):+.1f} %, {1000 * (ms['python'] - cpp):+.0f} us"

    judged = bars.most(over(ms["warm"]), ms["python"], 1.05 * ms["warm"] + 0.2 if name == "liver" else None)
    cells = {way: f"{each:.2f} ms" for way, each in ms.items()}
    return result, [name, f"{layer_mm:.3g} mm", f"{len(result):,}", cells["warm"], cells["fresh"], cells["python"], judged,
                    over(ms["fresh"]), cells["points"]]


def blocks_of(slice_here):
    """Blocks that Python's own allocator holds more, once all arrays of a result have been asked for."""
    before = sys.getallocatedblocks()
    result = slice_here()
    arrays = [result.layers, result.contours, result.points_grid, result.points, result.areas, result.perimeters]
    require(all(len(array) > 0 for array in arrays), "an array is empty")
    return sys.getallocatedblocks() - before


def layer_table(slice_here, rounds, bars):
    """Layers of the small mesh: objects, and areas as an array and by a loop."""
    blocks, result = blocks_of(slice_here), slice_here()
    require([layer.area for layer in result] == list(result.areas), "areas of layers are not those of the array")
    results = [slice_here() for _ in range(rounds + 1)]  # fresh ones, as a result keeps its areas
    ms = medians_of({"array": lambda: ms_of(lambda: results.pop().areas),
                     "walk": lambda: ms_of(lambda: collections.deque(result, maxlen=0)),
                     "loop": lambda: ms_of(lambda: [layer.area for layer in result])}, rounds)
    rate = len(result) / ms["walk"] / 1000
    return markdown_table([f"{len(result):,} layers", ""], [
        ["blocks of Python's allocator that the result and all its arrays take (at most 1,000)", bars.most(f"{blocks:,}", blocks, 1000)],
        ["`for layer in s` (at least 1 M layers/s)", bars.least(f"{rate:.2f} M/s", rate, 1)],
        ["areas of all layers, `s.areas` of a new result", f"{ms['array']:.2f} ms"],
        ["`[layer.area for layer in s]`", f"{ms['loop']:.1f} ms"]])


def other_layers(result, heights, contours_at, area_of, apart_mm):
    """The number of layers in which another way has other contours than the engine. It gives None for a layer with an open one."""
    def is_same(i):
        contours = contours_at(heights[i])
        within = apart_mm * (1 + result.perimeters[i])
        return (contours is not None and len(contours) == result.layers["contour_count"][i]
                and abs(area_of(contours) - result.areas[i]) <= within)

    return sum(not is_same(i) for i in range(len(heights)))


def ways_table(lamella, vtk_cutters, slice_here, mesh, layer_mm, arguments, bars):
    result, threads = slice_here(), arguments.threads
    heights = [int(z) * result.grid for z in result.layers["z_grid"]]
    prepared = lamella.prepare(*mesh, threads=threads)
    require(prepared.slice(layer_height=layer_mm).hash == result.hash, "the prepared mesh gives another result")
    in_numpy = plane_by_plane.Mesh(*mesh)
    differ = other_layers(result, heights, in_numpy.contours, lambda contours: sum(map(meshes.signed_area, contours)), APART_MM["numpy"])
    require(differ == 0, f"numpy: {differ} layers differ")
    vtk_cutters.use_threads(threads)
    data = vtk_cutters.poly_data(*mesh)
    one, every = vtk_cutters.Cutter(data), vtk_cutters.Cutter(data)

    def vtk_contours(height):
        lines = vtk_cutters.polylines(one.cut([height]))
        return [line[:-1, :2].astype(float) for line in lines] if all(np.array_equal(line[0], line[-1]) for line in lines) else None

    def each(cut):
        return lambda: [cut(height) for height in heights]

    differ = other_layers(result, heights, vtk_contours, meshes.area_by_nesting, APART_MM["vtk"])
    more = every.cut(heights).GetNumberOfLines() - len(result.contours)
    ways = {  # what is timed, the least times that the package must be as fast, and how the answer compares
        "`lamella.slice`": (slice_here, None, ""),
        "`prepared.slice(layer_height=...)`": (lambda: prepared.slice(layer_height=layer_mm, threads=threads), None, ""),
        "`prepared.slice([z])`, a plane a call": (each(lambda z: prepared.slice([z], threads=threads)), None, ""),
        "numpy": (lambda: each(plane_by_plane.Mesh(*mesh).contours)(), 20, "the same"),
        "vtkCutter, vtkStripper, a plane a pass": (each(lambda z: one.cut([z])), 20, f"other in {differ} planes"),
        "vtkCutter, vtkStripper, all planes in one pass": (lambda: every.cut(heights), 20, f"{more:+d} contours"),
    }
    ms = medians_of({name: lambda work=work: turn_of(work) for name, (work, _, _) in ways.items()}, min(arguments.rounds, 5))
    own = ms["`lamella.slice`"]
    rows = [[name, f"{ms[name]:.1f} ms", f"{1000 * ms[name] / len(heights):.1f} us", bars.least(f"{ms[name] / own:.0f}", ms[name] / own, bar),
             said] for name, (_, bar, said) in ways.items()]
    return markdown_table([f"{len(heights)} planes", "all", "a plane", "times as long (numpy and vtkCutter at least 20)", "answer"], rows)


def measure(lamella, vtk_cutters, arguments, bars):
    """The tables by name."""
    def slice_mm(mesh, layer_mm):
        return lamella.slice(*mesh, layer_height=layer_mm, threads=arguments.threads)

    rows, ways, build = [], "", arguments.build
    for name, path in arguments.meshes:
        mesh = mesh_formats.Mesh(path)
        rows.append(cpp_row(name, build, slice_mm, mesh, 3.2 if arguments.quick else 0.032, arguments, bars)[1])
        if name == "femur":
            mesh, layer_mm = (mesh.vertices, mesh.faces), 3.2 if arguments.quick else 0.32
            ways = ways_table(lamella, vtk_cutters, lambda: slice_mm(mesh, layer_mm), mesh, layer_mm, arguments, bars)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "small.stl")
        run(build / "tools" / "lamella", "make", "torus", "--triangles", str(SMALL_TRIANGLES), "--height", "150", "-o", path)
        mesh = mesh_formats.Mesh(path)
    planes = SMALL_PLANES // 100 if arguments.quick else SMALL_PLANES
    layer_mm = float(np.ptp(mesh.vertices[:, 2])) / planes
    result, row = cpp_row(f"torus of {len(mesh.faces)} triangles", build, slice_mm, mesh, layer_mm, arguments, bars)
    require(len(result) == planes, f"{len(result)} layers for {planes}")
    heads = ["mesh", "layers of", "layers", "C++, memory kept", "C++, fresh memory", "`lamella.slice`",
             "over C++ with memory kept (liver at most 5 % and 200 us)", "over C++ with fresh memory", "with points in mm"]
    layers = layer_table(lambda: slice_mm((mesh.vertices, mesh.faces), layer_mm), arguments.rounds, bars)
    return {"cpp": markdown_table(heads, [*rows, row]), "layers": layers, "ways": ways}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("meshes", nargs="*", metavar="NAME=MESH", type=lambda word: tuple(word.split("=", 1)))
    parser.add_argument("--page", type=pathlib.Path)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--quick", action="store_true")
    arguments, bars = parser.parse_args(), Bars()
    sys.path.insert(0, str(arguments.build / "python"))
    try:
        import lamella
        import vtk_cutters
    except ModuleNotFoundError as error:
        print(f"skipped: {error}; build lamella_python_package, and install python3-vtk9")
        return 77
    tables = measure(lamella, vtk_cutters, arguments, bars)
    machine = machine_table(arguments.build, Python=platform.python_version(), numpy=np.__version__, VTK=vtk_cutters.VERSION,
                            lamella=lamella.__version__, threads=arguments.threads, command=f"`{shlex.join(sys.argv)}`")
    text = PAGE.format(machine=machine, **tables)
    if arguments.quick:
        text = re.sub(r" \((not )?met\)", "", text)  # bars hold for full sizes only
    print(text, end="")
    if arguments.page:
        arguments.page.write_text(text)
    return 0 if bars.met or arguments.quick else 1


if __name__ == "__main__":
    sys.exit(main())
