#!/usr/bin/env python3
"""Times regions: in slices of real meshes, beside the clipping library's, and on layers of thousands of contours.

    bench/scripts/regions.py BUILD NAME=MESH... [--readme bench/README.md] [--threads 2] [--rounds 9]

Runs BUILD/bench/lamella_regions and the benchmarks `region/` of BUILD/bench/lamella_bench, and prints tables; with --readme
it also replaces those between the markers there. The exit status is 1 if a bar is not met.
"""

import re
import sys

from readme_table import add_meshes, mark, output_of, show, table_parser

LAYER_MM = "0.2"
SLICE_BARS = {"non_zero": 1.25, "closing": 2.5, "offset": 6.0}
# In seconds and bytes.
CASE_BARS = {"comb_16000": (0.2, None), "bars_500x500": (3.0, 1e9)}
CASE = re.compile(r"region/([^/]+)/([^/]+)/threads:1/")


def slices_table(reports):
    lines = [
        "| mesh | slice | non-zero | over the slice (at most 1.25) | non-zero and closing 0.049 mm | over the slice (at most 2.5) "
        "| non-zero and offset 0.2 mm | over the slice (at most 6) |",
        "|" + "---|" * 8,
    ]
    met = True
    for name, report in reports.items():
        ms = report["slices"]
        cells = [name, f"{ms['plain']:.1f} ms"]
        for variant, bar in SLICE_BARS.items():
            ratio = ms[variant] / ms["plain"]
            text, good = mark(f"{ratio:.2f}", ratio, bar)
            met = met and good
            cells += [f"{ms[variant]:.1f} ms", text]
        lines.append("| " + " | ".join(cells) + " |")
    return lines, met


def library_table(reports):
    lines = [
        "| mesh, all layers | union | by the library | times as fast | closing 0.049 mm | by the library | times as fast |",
        "|" + "---|" * 7,
    ]
    for name, report in reports.items():
        ms = report["layers"]
        cells = [name]
        for what in ("union", "closing"):
            theirs = ms["library_" + what]
            cells += [f"{ms[what]:.1f} ms", f"{theirs:.0f} ms", f"{theirs / ms[what]:.1f}"]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def cases_table(benchmarks):
    lines = ["| layer | rule | time | peak memory |", "|---|---|---|---|"]
    met = True
    for each in benchmarks:
        found = CASE.match(each["name"])
        if each.get("aggregate_name") != "median" or not found:
            continue
        if each.get("error_occurred"):
            sys.exit(f"{each['name']}: {each['error_message']}")
        name, rule = found.groups()
        seconds, peak = each["real_time"] / 1000, each["peak_bytes"]
        time_bar, memory_bar = CASE_BARS.get(name, (None, None))
        time_text, fast = mark(f"{1000 * seconds:.0f} ms", seconds, time_bar)
        memory_text, small = mark(f"{peak / 1e6:.0f} MB", peak, memory_bar)
        met = met and fast and small
        lines.append(f"| {name} | {rule} | {time_text} | {memory_text} |")
    if len(lines) == 2:
        sys.exit("lamella_bench measured no layer")
    return lines, met


def main():
    parser = table_parser(__doc__, "build")
    add_meshes(parser)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    programs = arguments.build / "bench"
    more = [LAYER_MM, str(arguments.threads), str(arguments.rounds)]
    reports = {name: output_of(programs / "lamella_regions", mesh, *more) for name, mesh in arguments.meshes}
    cases = output_of(programs / "lamella_bench", "--benchmark_filter=^region/", "--benchmark_format=json")
    slices, slices_met = slices_table(reports)
    layers, layers_met = cases_table(cases["benchmarks"])
    show(arguments.readme, "regions", [*slices, "", *library_table(reports), "", *layers])
    return 0 if slices_met and layers_met else 1


if __name__ == "__main__":
    sys.exit(main())
