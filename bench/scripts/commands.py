#!/usr/bin/env python3
"""Times whole commands of the tool on warm files, without -o, and compares them with the slice.

    bench/scripts/commands.py LAMELLA NAME=MESH... [--readme bench/README.md] [--threads N]

Prints a table; with --readme it also replaces the one between the markers there. Each command runs six times, of which the
first only warms the file, and the median of the others counts; the three commands take turns, so that a change of the
machine's load falls on all. The exit status is 1 if a bar is not met.
"""

import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

from readme_table import add_meshes, mark, show, table_parser

LAYER_MM = "0.032"
REPORT_BAR = 2.5
CHECK_BAR = 5.0
ROUNDS = 5


def milliseconds(command):
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return 1000 * (time.perf_counter() - start)


def measure(tool, mesh, threads, folder):
    end = ["--threads", str(threads)] if threads else []
    slicing = [tool, "slice", mesh, "--layer-height", LAYER_MM, *end]
    commands = {
        "slice": slicing,
        "report": [*slicing, "--report", str(folder / "report.json")],
        "check": [tool, "check", mesh, *end],
    }
    times = {name: [] for name in commands}
    for _ in range(ROUNDS + 1):
        for name, command in commands.items():
            times[name].append(milliseconds(command))
    return {name: statistics.median(each[1:]) for name, each in times.items()}


def main():
    parser = table_parser(__doc__, "tool")
    add_meshes(parser)
    parser.add_argument("--threads", type=int, default=0)
    arguments = parser.parse_args()
    lines = [
        "| mesh | slice | slice with `--report` | over the slice (at most 2.5) | `check` | over the slice (at most 5) |",
        "|---|---|---|---|---|---|",
    ]
    met = True
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh in arguments.meshes:
            ms = measure(arguments.tool, mesh, arguments.threads, pathlib.Path(folder))
            report, check = ms["report"] / ms["slice"], ms["check"] / ms["slice"]
            report_text, report_met = mark(f"{report:.2f}", report, REPORT_BAR)
            check_text, check_met = mark(f"{check:.2f}", check, CHECK_BAR)
            met = met and report_met and check_met
            lines.append(
                f"| {name} | {ms['slice']:.0f} ms | {ms['report']:.0f} ms | {report_text} "
                f"| {ms['check']:.0f} ms | {check_text} |"
            )
    show(arguments.readme, "commands", lines)
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
