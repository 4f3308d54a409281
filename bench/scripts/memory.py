#!/usr/bin/env python3
"""Measures slicing within a budget of memory: time, processor time and peak memory over the budget.

    bench/scripts/memory.py LAMELLA NAME=MESH... [--giant NAME=MESH] [--readme bench/README.md] [--layer-height 0.1] [--rounds 3]

Each MESH, a binary STL file, is sliced in memory, and within a half, a tenth and a fiftieth of what that takes. `--giant` is sliced
within 900 MB only, beside two plain reads of the file by one thread, 8 MB at a time. All take turns, once more than --rounds as the
first round only warms the file, and of each the least counts. Peak memory is the resident memory of the process; files are read
into buffers of its own, not mapped, so that no page of the page cache counts. All outputs must have the same hash. Prints
a table; with --readme it also replaces the one between the markers there. The exit status is 1 if a bar is not met.
"""

import os
import subprocess
import sys
import time

from readme_table import compare, markdown_table, name_and_mesh

HALF_BAR = 1.2  # over the time in memory
READS_BAR = 3.0  # over the time of two reads
GIANT_BYTES = 900_000_000
GIANT_BAR_MB = 1000
PARTS = (2, 10, 50)


class Run:
    """A command's least times so far, and its peak."""

    def __init__(self, command):
        self.command = command
        self.wall = self.processor = float("inf")
        self.peak_mb = 0
        self.lines = {}

    def again(self):
        start = time.perf_counter()
        with subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True) as process:
            text = process.stdout.read()
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            raise subprocess.CalledProcessError(process.returncode, self.command)
        self.wall = min(self.wall, time.perf_counter() - start)
        self.processor = min(self.processor, used.ru_utime + used.ru_stime)
        self.peak_mb = used.ru_maxrss * 1024 / 1e6
        self.lines = dict(line.split(maxsplit=1) for line in text.splitlines())


class Reads:
    """Two plain reads of a file."""

    def __init__(self, path):
        self.path = path
        self.wall = float("inf")

    def again(self):
        start = time.perf_counter()
        buffer = bytearray(8 << 20)
        for _ in range(2):
            with open(self.path, "rb", buffering=0) as file:
                while file.readinto(buffer):
                    pass
        self.wall = min(self.wall, time.perf_counter() - start)


def slicing(tool, mesh, layer_mm, budget, *more):
    command = [tool, "slice", mesh, "--layer-height", layer_mm, "--progress=never", *more]
    return Run(command if budget is None else [*command, "--memory", str(budget)])


def ranges_of(run):
    words = run.lines.get("ranges", "1 range").split()
    return words[0] + (" by a temporary file" if "temporary" in words else "")


def row(name, budget, run, ratio):
    return [name, budget, f"{run.wall:.2f} s", ratio, f"{run.processor:.2f} s", f"{run.peak_mb:.0f} MB", ranges_of(run)]


def measure(tool, name, mesh, arguments, bars):
    whole = slicing(tool, mesh, arguments.layer_height, None, "--hash")
    whole.again()
    budgets = [int(whole.peak_mb * 1e6 / part) for part in PARTS]
    within = [slicing(tool, mesh, arguments.layer_height, budget, "--hash") for budget in budgets]
    for _ in range(arguments.rounds + 1):
        for run in (whole, *within):
            run.again()
    bars.met = bars.met and all(run.lines["hash"] == whole.lines["hash"] for run in within)
    rows = [row(name, "in memory", whole, "1")]
    for part, budget, run in zip(PARTS, budgets, within):
        ratio = run.wall / whole.wall
        text = bars.most(f"{ratio:.2f}", ratio, HALF_BAR if part == 2 else None)
        rows.append(row("", f"1/{part}: {budget / 1e6:.0f} MB", run, text))
    return rows


def measure_giant(tool, name, mesh, arguments, bars):
    reads = Reads(mesh)
    within = slicing(tool, mesh, arguments.layer_height, GIANT_BYTES)
    for _ in range(arguments.rounds + 1):
        reads.again()
        within.again()
    ratio = within.wall / reads.wall
    text = bars.most(f"{ratio:.2f}", ratio, READS_BAR)
    bars.met = bars.met and within.peak_mb <= GIANT_BAR_MB
    return [row(name, f"{GIANT_BYTES / 1e6:.0f} MB", within, f"{text} of two reads, {reads.wall:.2f} s")]


def table(arguments, bars):
    rows = []
    for name, mesh in arguments.meshes:
        rows += measure(arguments.tool, name, mesh, arguments, bars)
    if arguments.giant:
        rows += measure_giant(arguments.tool, *name_and_mesh(arguments.giant), arguments, bars)
    heads = ["mesh", "budget", "time", "over that in memory (a half: at most 1.2; two reads: at most 3)", "processor time", "peak",
             "ranges"]
    return [markdown_table(heads, rows)]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "memory", table, "tool", "meshes", giant="", layer_height="0.1", rounds=3))
