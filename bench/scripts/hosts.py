#!/usr/bin/env python3
"""Times the calls that hosts make beside whole slices: single planes of a prepared mesh, small meshes, first slices.

    bench/scripts/hosts.py BUILD NAME=MESH... [--readme bench/README.md] [--threads 2] [--rounds 15]

Runs BUILD/bench/lamella_hosts and prints tables; with --readme it also replaces those between the
markers there. A first slice is the median of as many processes as there are rounds. The exit status is 1 if a bar is not met.
"""

import statistics
import sys

from readme_table import compare, markdown_table, output_of

LAYER_MM = "0.032"
PLANE_BARS = {"femur": 0.1, "brain": 0.3}  # ms
ALL_BARS = {"liver": 0.9}
FIRST_BARS = {"liver": 1.3, "femur": 1.3, "scan": 1.3}
SMALL_US_BAR = 2.0


def first_slices(program, meshes, threads, rounds):
    """For each mesh the medians over processes, which take turns."""
    times = {name: [] for name in meshes}
    for _ in range(rounds):
        for name, mesh in meshes.items():
            times[name].append(output_of(program, "first", mesh, LAYER_MM, threads))
    return {name: {key: statistics.median(each[key] for each in own) for key in ("first", "warm")}
            for name, own in times.items()}


def first_table(firsts, bars):
    rows = []
    for name, ms in firsts.items():
        ratio = ms["first"] / ms["warm"]
        rows.append([name, f"{ms['warm']:.1f} ms", f"{ms['first']:.1f} ms",
                     bars.most(f"{ratio:.2f}", ratio, FIRST_BARS.get(name))])
    return markdown_table(["mesh", "warm slice", "first slice of a process", "over the warm one (at most 1.3)"], rows)


def prepared_table(program, meshes, firsts, threads, rounds, bars):
    rows = []
    for name, mesh in meshes.items():
        report = output_of(program, "prepared", mesh, LAYER_MM, threads, str(rounds))
        plane, every = report["plane"], report["all"]
        ratio = every["prepared"] / firsts[name]["first"]
        rows.append([name, f"{report['prepare']:.1f} ms", f"{report['bytes'] / 1e6:.1f} MB", f"{plane['mesh']:.3f} ms",
                     bars.most(f"{plane['prepared']:.3f} ms", plane["prepared"], PLANE_BARS.get(name)),
                     f"{every['mesh']:.1f} ms", f"{every['prepared']:.1f} ms",
                     bars.most(f"{ratio:.2f}", ratio, ALL_BARS.get(name)), f"{every['prepared'] / every['mesh']:.2f}"])
    return markdown_table(["mesh", "`prepare()`", "memory", "one plane of the mesh", "prepared (femur at most 0.1, brain 0.3 ms)",
                           "all planes of the mesh", "prepared", "over a first slice (liver at most 0.9)", "over a warm one"], rows)


def small_table(program, threads, bars):
    rows = []
    for count in sorted({1, int(threads)}):
        report = output_of(program, "small", str(count))
        rows.append([f"{count} thread{'s' * (count > 1)}",
                     bars.most(f"{report['kept_us']:.2f} us", report["kept_us"], SMALL_US_BAR),
                     bars.most(str(report["allocations"]), report["allocations"], 0), f"{report['fresh_us']:.1f} us"])
    return markdown_table(["12 triangles, one plane", "kept `Slicer` (at most 2 us)", "blocks taken (at most 0)", "without one"], rows)


def tables(arguments, bars):
    program, threads = arguments.build / "bench" / "lamella_hosts", str(arguments.threads)
    meshes = dict(arguments.meshes)
    firsts = first_slices(program, meshes, threads, arguments.rounds)
    return [prepared_table(program, meshes, firsts, threads, arguments.rounds, bars), small_table(program, threads, bars),
            first_table(firsts, bars)]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "hosts", tables, "build", "meshes", threads=2, rounds=15))
