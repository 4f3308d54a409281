#!/usr/bin/env python3
"""Times whole commands of the tool on warm files, without -o, and compares them with the slice.

    bench/scripts/commands.py LAMELLA NAME=MESH... [--readme bench/README.md] [--threads N]

Prints a table; with --readme it also replaces the one between the markers there. Each command runs six times, of which the
first only warms the file, and the median of the others counts; the three commands take turns, so that a change of the
machine's load falls on all. The exit status is 1 if a bar is not met.
"""

import pathlib
import sys
import tempfile

from readme_table import compare, markdown_table, medians_of, ms_of, run

LAYER_MM = "0.032"
REPORT_BAR = 2.5
CHECK_BAR = 5.0
ROUNDS = 5


def measure(tool, mesh, threads, folder):
    end = ["--threads", str(threads)] if threads else []
    slicing = [tool, "slice", mesh, "--layer-height", LAYER_MM, *end]
    commands = {
        "slice": slicing,
        "report": [*slicing, "--report", str(folder / "report.json")],
        "check": [tool, "check", mesh, *end],
    }
    return medians_of(commands, ROUNDS, lambda command: ms_of(lambda: run(*command)))


def table(arguments, bars):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh in arguments.meshes:
            ms = measure(arguments.tool, mesh, arguments.threads, pathlib.Path(folder))
            report, check = ms["report"] / ms["slice"], ms["check"] / ms["slice"]
            rows.append([name, f"{ms['slice']:.0f} ms", f"{ms['report']:.0f} ms", bars.most(f"{report:.2f}", report, REPORT_BAR),
                         f"{ms['check']:.0f} ms", bars.most(f"{check:.2f}", check, CHECK_BAR)])
    heads = ["mesh", "slice", "slice with `--report`", "over the slice (at most 2.5)", "`check`", "over the slice (at most 5)"]
    return [markdown_table(heads, rows)]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "commands", table, "tool", "meshes", threads=0))
