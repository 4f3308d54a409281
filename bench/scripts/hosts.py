#!/usr/bin/env python3
"""Times the calls that hosts make beside whole slices: single planes of a prepared mesh, small meshes, first slices.

    bench/scripts/hosts.py BUILD NAME=MESH... [--readme bench/README.md] [--threads 2] [--rounds 15]

Meshes are binary STL. Runs BUILD/bench/lamella_hosts and prints tables; with --readme it also replaces those between the
markers there. A first slice is the median of as many processes as there are rounds. The exit status is 1 if a bar is not met.
"""

import statistics
import sys

from readme_table import add_meshes, mark, output_of, show, table_parser

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


def first_table(firsts):
    lines = ["| mesh | warm slice | first slice of a process | over the warm one (at most 1.3) |", "|---|---|---|---|"]
    met = True
    for name, ms in firsts.items():
        ratio = ms["first"] / ms["warm"]
        text, good = mark(f"{ratio:.2f}", ratio, FIRST_BARS.get(name))
        met = met and good
        lines.append(f"| {name} | {ms['warm']:.1f} ms | {ms['first']:.1f} ms | {text} |")
    return lines, met


def prepared_table(program, meshes, firsts, threads, rounds):
    lines = ["| mesh | `prepare()` | memory | one plane of the mesh | prepared (femur at most 0.1, brain 0.3 ms) | all planes of the "
             "mesh | prepared | over a first slice (liver at most 0.9) | over a warm one |", "|" + "---|" * 9]
    met = True
    for name, mesh in meshes.items():
        report = output_of(program, "prepared", mesh, LAYER_MM, threads, str(rounds))
        plane, every = report["plane"], report["all"]
        plane_text, plane_met = mark(f"{plane['prepared']:.3f} ms", plane["prepared"], PLANE_BARS.get(name))
        ratio = every["prepared"] / firsts[name]["first"]
        all_text, all_met = mark(f"{ratio:.2f}", ratio, ALL_BARS.get(name))
        met = met and plane_met and all_met
        lines.append(
            f"| {name} | {report['prepare']:.1f} ms | {report['bytes'] / 1e6:.1f} MB | {plane['mesh']:.3f} ms | {plane_text} "
            f"| {every['mesh']:.1f} ms | {every['prepared']:.1f} ms | {all_text} | {every['prepared'] / every['mesh']:.2f} |")
    return lines, met


def small_table(program, threads):
    lines = ["| 12 triangles, one plane | kept workspace (at most 2 us) | blocks taken (at most 0) | without one |",
             "|---|---|---|---|"]
    met = True
    for count in sorted({1, int(threads)}):
        report = output_of(program, "small", str(count))
        time_text, fast = mark(f"{report['kept_us']:.2f} us", report["kept_us"], SMALL_US_BAR)
        taken_text, lean = mark(str(report["allocations"]), report["allocations"], 0)
        met = met and fast and lean
        lines.append(f"| {count} thread{'s' * (count > 1)} | {time_text} | {taken_text} | {report['fresh_us']:.1f} us |")
    return lines, met


def main():
    parser = table_parser(__doc__, "build")
    add_meshes(parser)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    program, threads = arguments.build / "bench" / "lamella_hosts", str(arguments.threads)
    meshes = dict(arguments.meshes)
    firsts = first_slices(program, meshes, threads, arguments.rounds)
    tables = [prepared_table(program, meshes, firsts, threads, arguments.rounds), small_table(program, threads),
              first_table(firsts)]
    show(arguments.readme, "hosts", ["\n\n".join("\n".join(lines) for lines, _ in tables)])
    return 0 if all(met for _, met in tables) else 1


if __name__ == "__main__":
    sys.exit(main())
