#!/usr/bin/python3
"""Times the Python package beside the same call in C++, beside the usual method in numpy, and beside VTK's filters.

    bench/scripts/python.py BUILD NAME=MESH... [--page bench/results/python.md] [--threads 2] [--rounds 9] [--quick]

NAME is liver or femur; meshes are binary STL. Needs numpy, python3-vtk9, and of BUILD the targets lamella_cli,
lamella_slice_arrays and lamella_python_package. Prints the page of tables; with --page it also writes it. --quick takes few
planes and rounds, and judges no bar. The exit status is 1 if a bar is not met, 2 if an answer is wrong, 77 if the package or VTK
is missing.
"""

import argparse
import contextlib
import json
import pathlib
import platform
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

from readme_table import Bars, field, machine_table, markdown_table, medians_of, ms_of

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
import meshes  # noqa: E402
import plane_by_plane  # noqa: E402

OVER_SHARE, OVER_MS = 0.05, 0.2
TIMES_NUMPY, TIMES_VTK = 20, 20
MOST_BLOCKS = 1000
LEAST_LAYERS_PER_S = 1e6
CALLS_A_TURN = 3
TURN_MS = 200
SMALL_TRIANGLES, SMALL_PLANES, SMALL_MM = 500, 100_000, 150
HEAD = """# lamella in Python

`bench/scripts/python.py` made this page. What is timed is described in [bench/README.md](../README.md#python).
"""
TEXTS = ("""## The same slice in C++

Vertices are float32, indices int32, in memory. Each side is a process of its own, and they take turns. Freeing results is not
timed. The bar is met by at most 1.05 times the time in C++ plus 200 us.
""", """## Many layers of a small mesh
""", """## Other ways to cut the femur, layers of 0.32 mm

Times are from mesh to contours. numpy starts at arrays, VTK at a mesh of its own; `prepared` is `lamella.prepare(mesh)`. An answer
of VTK counts as another one if a polyline is open, or if the number of contours or the area is not lamella's.
""")
APART_MM = {"numpy": 1e-6, "vtk": 2e-5}  # VTK computes in float32


class WrongAnswer(Exception):
    pass


def require(true, text):
    if not true:
        raise WrongAnswer(text)


def turn_of(work):
    """Milliseconds a call, of at least TURN_MS of them: what follows another's turn finds caches and threads cold."""
    times = [ms_of(work)]
    while sum(times) < TURN_MS:
        times.append(ms_of(work))
    return statistics.fmean(times)


class InCpp:
    """The program that slices the same arrays in C++. Waits while Python slices."""

    def __init__(self, build, folder, mesh, threads):
        paths = [folder / "vertices", folder / "faces"]
        for array, path in zip(mesh, paths):
            array.tofile(path)
        command = [build / "bench" / "lamella_slice_arrays", *paths, str(threads)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def slice(self, layer_mm, how):
        self._process.stdin.write(f"{layer_mm!r} {CALLS_A_TURN} {how}\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        require(line, "lamella_slice_arrays ended")
        return json.loads(line)

    def close(self):
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()


class InPython:
    """The package. What it gives is freed before the next call, which is not timed."""

    def __init__(self, lamella, mesh, threads):
        self._lamella, self._mesh, self._threads = lamella, mesh, threads
        self.result = None

    def slice(self, layer_mm):
        self.result = self._lamella.slice(*self._mesh, layer_height=layer_mm, threads=self._threads)
        return self.result

    def turn(self, layer_mm, use):
        times = []
        for _ in range(CALLS_A_TURN + 1):
            self.result = None
            times.append(ms_of(lambda: use(self.slice(layer_mm))))
        return times[1:]


def beside_cpp(in_cpp, in_python, layer_mm, rounds):
    """Medians in ms, after both gave the same result."""
    result = in_python.slice(layer_mm)
    require(int(result.hash, 16) == in_cpp.slice(layer_mm, "kept")["hash"], "Python's result is not that of C++")
    works = {
        "kept": lambda: in_cpp.slice(layer_mm, "kept")["ms"],
        "fresh": lambda: in_cpp.slice(layer_mm, "fresh")["ms"],
        "python": lambda: in_python.turn(layer_mm, lambda result: None),
        "points": lambda: in_python.turn(layer_mm, lambda result: result.points),
    }
    times = {name: [] for name in works}
    for _ in range(rounds):
        for name, work in works.items():
            times[name] += work()
    return {name: statistics.median(own) for name, own in times.items()}, len(result)


def over(python, cpp):
    return f"{100 * (python / cpp - 1):+.1f} %, {1000 * (python - cpp):+.0f} us"


def cpp_row(name, layer_mm, layers, ms, bars):
    most = (1 + OVER_SHARE) * ms["kept"] + OVER_MS
    text = bars.most(over(ms["python"], ms["kept"]), ms["python"], most if name == "liver" else None)
    times = {way: f"{each:.2f} ms" for way, each in ms.items()}
    return [name, f"{layer_mm:.3g} mm", f"{layers:,}", times["kept"], times["fresh"], times["python"], text,
            over(ms["python"], ms["fresh"]), times["points"]]


def blocks_of(in_python, layer_mm):
    """Blocks that Python's own allocator holds more, once all arrays of a result have been asked for."""
    in_python.result = None
    before = sys.getallocatedblocks()
    result = in_python.slice(layer_mm)
    arrays = [result.layers, result.contours, result.points_grid, result.points, result.areas, result.perimeters]
    require(all(len(array) > 0 for array in arrays), "an array is empty")
    return sys.getallocatedblocks() - before


def walk(result):
    for _ in result:
        pass


def layer_table(in_python, layer_mm, rounds, bars):
    """Layers of the small mesh: objects, and areas as an array and by a loop."""
    blocks = blocks_of(in_python, layer_mm)
    result = in_python.result
    require([layer.area for layer in result] == list(result.areas), "areas of layers are not those of the array")
    times = {"array": [], "loop": [], "walk": []}
    for _ in range(rounds):
        result = in_python.slice(layer_mm)  # a fresh one, as a result keeps its areas
        times["array"].append(ms_of(lambda: result.areas))
        walk(result)
        times["walk"].append(ms_of(lambda: walk(result)))
        times["loop"].append(ms_of(lambda: [layer.area for layer in result]))
    ms = {name: statistics.median(own) for name, own in times.items()}
    rate = 1000 * len(result) / ms["walk"]
    rows = [["blocks of Python's allocator that the result and all its arrays take (at most 1,000)",
             bars.most(f"{blocks:,}", blocks, MOST_BLOCKS)],
            ["`for layer in s` (at least 1 M layers/s)", bars.least(f"{rate / 1e6:.2f} M/s", rate, LEAST_LAYERS_PER_S)],
            ["areas of all layers, `s.areas` of a new result", f"{ms['array']:.2f} ms"],
            ["`[layer.area for layer in s]`", f"{ms['loop']:.1f} ms"]]
    return markdown_table([f"{len(result):,} layers", ""], rows)


def check_numpy(mesh, result, heights):
    """Contours and areas of every layer. The heights are those that were cut."""
    perimeters = result.perimeters
    for i, height in enumerate(heights):
        contours = mesh.contours(height)
        apart = abs(sum(map(meshes.signed_area, contours)) - result.areas[i])
        require(len(contours) == result.layers["contour_count"][i] and apart <= APART_MM["numpy"] * (1 + perimeters[i]),
                f"numpy: layer {i} differs")


def other_planes(cutter, vtk_cutters, result, heights):
    """The number of planes in which VTK has other contours than the engine."""
    count = 0
    for i, height in enumerate(heights):
        lines = vtk_cutters.polylines(cutter.cut([height]))
        closed = all(np.array_equal(line[0], line[-1]) for line in lines)
        area = meshes.area_by_nesting([line[:-1, :2].astype(float) for line in lines])
        within = APART_MM["vtk"] * (1 + result.perimeters[i])
        same = closed and len(lines) == result.layers["contour_count"][i] and abs(area - result.areas[i]) <= within
        count += not same
    return count


def each_of(heights, cut):
    def cut_each():
        for height in heights:
            cut(height)

    return cut_each


def ways_to_cut(lamella, mesh, result, layer_mm, heights, threads):
    """By name: what is timed, the least times that the package must be as fast, and what is said of the answer."""
    import vtk_cutters

    vtk_cutters.use_threads(threads)
    prepared = lamella.prepare(*mesh, threads=threads)
    require(prepared.slice(layer_height=layer_mm).hash == result.hash, "the prepared mesh gives another result")
    ways = {"`prepared.slice(layer_height=...)`": (lambda: prepared.slice(layer_height=layer_mm, threads=threads), None, ""),
            "`prepared.slice([z])`, a plane a call": (each_of(heights, lambda z: prepared.slice([z], threads=threads)), None, "")}
    numpy_mesh = plane_by_plane.Mesh(*mesh)
    check_numpy(numpy_mesh, result, heights)
    ways["numpy"] = (lambda: each_of(heights, plane_by_plane.Mesh(*mesh).contours)(), TIMES_NUMPY, "the same")
    data = vtk_cutters.poly_data(*mesh)
    cutter = vtk_cutters.Cutter(data)
    said = f"other in {other_planes(cutter, vtk_cutters, result, heights)} planes"
    ways["vtkCutter, vtkStripper, a plane a pass"] = (each_of(heights, lambda z: cutter.cut([z])), TIMES_VTK, said)
    all_values = vtk_cutters.Cutter(data)
    said = f"{all_values.cut(heights).GetNumberOfLines() - len(result.contours):+d} contours"
    ways["vtkCutter, vtkStripper, all planes in one pass"] = (lambda: all_values.cut(heights), TIMES_VTK, said)
    return ways


def ways_table(lamella, in_python, mesh, layer_mm, threads, rounds, bars):
    result = in_python.slice(layer_mm)
    heights = [int(z) * result.grid for z in result.layers["z_grid"]]
    ways = ways_to_cut(lamella, mesh, result, layer_mm, heights, threads)
    works = {"`lamella.slice`": lambda: in_python.slice(layer_mm), **{name: way[0] for name, way in ways.items()}}
    ms = medians_of(works, rounds, turn_of)
    own, rows = ms["`lamella.slice`"], []
    for name in works:
        _, bar, said = ways.get(name, (None, None, ""))
        rows.append([name, f"{ms[name]:.1f} ms", f"{1000 * ms[name] / len(heights):.1f} us",
                     bars.least(f"{ms[name] / own:.0f}", ms[name] / own, bar), said])
    head = [f"{len(heights)} planes", "all", "a plane", "times as long (numpy and vtkCutter at least 20)", "answer"]
    return markdown_table(head, rows)


@contextlib.contextmanager
def both(build, lamella, mesh, threads):
    with tempfile.TemporaryDirectory() as folder:
        in_cpp = InCpp(build, pathlib.Path(folder), mesh, threads)
        try:
            yield in_cpp, InPython(lamella, mesh, threads)
        finally:
            in_cpp.close()


def small_mesh(build):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "small.stl"
        shape = ["torus", "--triangles", str(SMALL_TRIANGLES), "--height", str(SMALL_MM)]
        subprocess.run([build / "tools" / "lamella", "make", *shape, "-o", path], check=True, capture_output=True)
        return meshes.read_stl(path)


def small_layer_mm(vertices, planes):
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    return (high - low) / planes


def measure(lamella, arguments):
    """Tables in order, and whether all bars are met."""
    build, threads, rounds = arguments.build, arguments.threads, arguments.rounds
    named = {name: meshes.read_stl(path) for name, path in (pair.split("=", 1) for pair in arguments.meshes)}
    cpp_rows, others, bars = [], [], Bars()
    for name, mesh in named.items():
        with both(build, lamella, mesh, threads) as (in_cpp, in_python):
            layer_mm = 3.2 if arguments.quick else 0.032
            ms, layers = beside_cpp(in_cpp, in_python, layer_mm, rounds)
            cpp_rows.append(cpp_row(name, layer_mm, layers, ms, bars))
            if name == "femur":
                others = [ways_table(lamella, in_python, mesh, 3.2 if arguments.quick else 0.32, threads, min(rounds, 5), bars)]
    mesh, planes = small_mesh(build), SMALL_PLANES // 100 if arguments.quick else SMALL_PLANES
    layer_mm = small_layer_mm(mesh[0], planes)
    with both(build, lamella, mesh, threads) as (in_cpp, in_python):
        ms, layers = beside_cpp(in_cpp, in_python, layer_mm, rounds)
        require(layers == planes, f"{layers} layers for {planes}")
        cpp_rows.append(cpp_row(f"torus of {len(mesh[1])} triangles", layer_mm, layers, ms, bars))
        of_layers = layer_table(in_python, layer_mm, rounds, bars)
    head = ["mesh", "layers of", "layers", "C++, memory kept", "C++, fresh memory", "`lamella.slice`",
            "over C++ with memory kept (liver at most 5 % and 200 us)", "over C++ with fresh memory", "with points in mm"]
    return [markdown_table(head, cpp_rows), of_layers, *others], bars.met


def page(build, versions, command, tables):
    compiler = field(build / "CMakeCache.txt", r"CMAKE_CXX_COMPILER:\w*")
    parts = [HEAD, machine_table(compiler, {**versions, "command": f"`{command}`"}) + "\n"]
    for text, table in zip(TEXTS, tables):
        parts += [text, table + "\n"]
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("meshes", nargs="+", metavar="NAME=MESH")
    parser.add_argument("--page", type=pathlib.Path)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    sys.path.insert(0, str(arguments.build / "python"))
    try:
        import lamella
        import vtk_cutters
    except ModuleNotFoundError as error:
        print(f"skipped: {error}; build lamella_python_package, and install python3-vtk9")
        return 77
    try:
        tables, met = measure(lamella, arguments)
    except (WrongAnswer, plane_by_plane.OpenLayer) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    versions = {"Python": platform.python_version(), "numpy": np.__version__, "VTK": vtk_cutters.VERSION,
                "lamella": lamella.__version__, "threads": arguments.threads}
    text = page(arguments.build, versions, shlex.join(sys.argv), tables)
    if arguments.quick:
        text = re.sub(r" \((not )?met\)", "", text)  # bars hold for full sizes only
    print(text, end="")
    if arguments.page:
        arguments.page.write_text(text)
    return 0 if met or arguments.quick else 1


if __name__ == "__main__":
    sys.exit(main())
