#!/usr/bin/env python3
"""Times regions: in slices of real meshes, beside the clipping library's, and on layers of thousands of contours.

    bench/scripts/regions.py BUILD NAME=MESH... [--readme bench/README.md] [--threads 2] [--rounds 9]

Runs BUILD/bench/lamella_regions and the benchmarks `region/` of BUILD/bench/lamella_bench, and prints tables; with --readme
it also replaces those between the markers there. The exit status is 1 if a bar is not met.
"""

import re
import sys

from readme_table import compare, markdown_table, output_of

LAYER_MM = "0.2"
SLICE_BARS = {"non_zero": 1.25, "closing": 2.5, "offset": 6.0}
# In seconds and bytes.
CASE_BARS = {"comb_16000": (0.2, None), "bars_500x500": (3.0, 1e9)}
CASE = re.compile(r"region/([^/]+)/([^/]+)/threads:1/")


def slices_table(reports, bars):
    rows = []
    for name, report in reports.items():
        ms = report["slices"]
        rows.append([name, f"{ms['plain']:.1f} ms"])
        for variant, bar in SLICE_BARS.items():
            ratio = ms[variant] / ms["plain"]
            rows[-1] += [f"{ms[variant]:.1f} ms", bars.most(f"{ratio:.2f}", ratio, bar)]
    return markdown_table(["mesh", "slice", "non-zero", "over the slice (at most 1.25)", "non-zero and closing 0.049 mm",
                           "over the slice (at most 2.5)", "non-zero and offset 0.2 mm", "over the slice (at most 6)"], rows)


def library_table(reports):
    rows = []
    for name, report in reports.items():
        ms = report["layers"]
        rows.append([name])
        for what in ("union", "closing"):
            theirs = ms["library_" + what]
            rows[-1] += [f"{ms[what]:.1f} ms", f"{theirs:.0f} ms", f"{theirs / ms[what]:.1f}"]
    return markdown_table(["mesh, all layers", "union", "by the library", "times as fast", "closing 0.049 mm", "by the library",
                           "times as fast"], rows)


def cases_table(benchmarks, bars):
    rows = []
    for each in benchmarks:
        found = CASE.match(each["name"])
        if each.get("aggregate_name") != "median" or not found:
            continue
        if each.get("error_occurred"):
            sys.exit(f"{each['name']}: {each['error_message']}")
        name, rule = found.groups()
        seconds, peak = each["real_time"] / 1000, each["peak_bytes"]
        time_bar, memory_bar = CASE_BARS.get(name, (None, None))
        rows.append([name, rule, bars.most(f"{1000 * seconds:.0f} ms", seconds, time_bar),
                     bars.most(f"{peak / 1e6:.0f} MB", peak, memory_bar)])
    if not rows:
        sys.exit("lamella_bench measured no layer")
    return markdown_table(["layer", "rule", "time", "peak memory"], rows)


def tables(arguments, bars):
    programs = arguments.build / "bench"
    more = [LAYER_MM, str(arguments.threads), str(arguments.rounds)]
    reports = {name: output_of(programs / "lamella_regions", mesh, *more) for name, mesh in arguments.meshes}
    cases = output_of(programs / "lamella_bench", "--benchmark_filter=^region/", "--benchmark_format=json")
    return [slices_table(reports, bars), library_table(reports), cases_table(cases["benchmarks"], bars)]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "regions", tables, "build", "meshes", threads=2, rounds=9))
