#!/usr/bin/env python3
"""Times whole commands of the tool on warm files, without -o, and compares them with the slice.

    bench/scripts/commands.py LAMELLA NAME=MESH... [--readme bench/README.md] [--threads N]

Prints a table; with --readme it also replaces the one between the markers there. The median of five rounds counts, after one that only
warms the file. The exit status is 1 if a bar is not met.
"""

import sys

from readme_table import compare, markdown_table, medians_of, ms_of, run

LAYER_MM, REPORT_BAR, CHECK_BAR, ROUNDS = "0.032", 2.5, 5.0, 5


def table(arguments, bars):
    rows = []
    for name, mesh in arguments.meshes:
        end = [mesh, *(["--threads", str(arguments.threads)] if arguments.threads else [])]
        slicing = [arguments.tool, "slice", "--layer-height", LAYER_MM, *end]
        commands = {"slice": slicing, "report": [*slicing, "--report", "/dev/null"], "check": [arguments.tool, "check", *end]}
        ms = medians_of({what: lambda command=command: ms_of(lambda: run(*command)) for what, command in commands.items()}, ROUNDS)
        report, check = ms["report"] / ms["slice"], ms["check"] / ms["slice"]
        rows.append([name, f"{ms['slice']:.0f} ms", f"{ms['report']:.0f} ms", bars.most(f"{report:.2f}", report, REPORT_BAR),
                     f"{ms['check']:.0f} ms", bars.most(f"{check:.2f}", check, CHECK_BAR)])
    heads = ["mesh", "slice", "slice with `--report`", "over the slice (at most 2.5)", "`check`", "over the slice (at most 5)"]
    return [markdown_table(heads, rows)]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "commands", table, "tool", "meshes", threads=0))
