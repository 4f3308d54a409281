#!/usr/bin/env python3
"""Measures slicing within a budget of memory: time, processor time and peak memory over the budget.

    bench/scripts/memory.py LAMELLA NAME=MESH... [--giant NAME=MESH] [--readme bench/README.md] [--layer-height 0.1] [--rounds 3]

Each MESH, a binary STL file, is sliced in memory, and within a half, a tenth and a fiftieth of what that takes. `--giant` is sliced
within 900 MB only, beside two plain reads of the file by one thread, 8 MB at a time. All take turns, once more than --rounds as the
first round only warms the file, and of each the least counts. Peak memory is the resident memory of the process; files are read
into buffers of its own, not mapped, so that no page of the page cache counts. All outputs must have the same hash. Prints
a table; with --readme it also replaces the one between the markers there. The exit status is 1 if a bar is not met.
"""

import sys

from readme_table import compare, in_turn, markdown_table, ms_of, usage_of

HALF_BAR = 1.2  # over the time in memory
READS_BAR = 3.0  # over the time of two reads
GIANT_BYTES, GIANT_BAR_BYTES = 900_000_000, 1_000_000_000
PARTS = (2, 10, 50)


def read_twice(path):
    buffer = bytearray(8 << 20)
    for _ in range(2):
        with open(path, "rb", buffering=0) as file:
            while file.readinto(buffer):
                pass


def slicing(arguments, mesh, budget, *more):
    command = [arguments.tool, "slice", mesh, "--layer-height", arguments.layer_height, "--progress=never", *more]
    return lambda: usage_of(*command, *(["--memory", str(budget)] if budget else []))


def lines_of(usage):
    return dict(line.split(maxsplit=1) for line in usage.text.splitlines())


def row(name, budget, usages, ratio):
    """Of the least times, and the last run's memory."""
    ranges = lines_of(usages[-1]).get("ranges", "1 range").split()
    return [name, budget, f"{least_s(usages):.2f} s", ratio, f"{min(usage.processor_s for usage in usages):.2f} s",
            f"{usages[-1].peak_bytes / 1e6:.0f} MB", ranges[0] + (" by a temporary file" if "temporary" in ranges else "")]


def least_s(usages):
    return min(usage.wall_s for usage in usages)


def measure(name, mesh, arguments, bars):
    whole = slicing(arguments, mesh, None, "--hash")
    budgets = {part: whole().peak_bytes // part for part in PARTS}
    within = {part: slicing(arguments, mesh, budget, "--hash") for part, budget in budgets.items()}
    usages = in_turn({1: whole, **within}, arguments.rounds)
    bars.met = bars.met and len({lines_of(usage)["hash"] for runs in usages.values() for usage in runs}) == 1
    yield row(name, "in memory", usages[1], "1")
    for part, budget in budgets.items():
        ratio = least_s(usages[part]) / least_s(usages[1])
        text = bars.most(f"{ratio:.2f}", ratio, HALF_BAR if part == 2 else None)
        yield row("", f"1/{part}: {budget / 1e6:.0f} MB", usages[part], text)


def measure_giant(name, mesh, arguments, bars):
    reads = lambda: ms_of(lambda: read_twice(mesh))  # noqa: E731
    found = in_turn({"reads": reads, "within": slicing(arguments, mesh, GIANT_BYTES)}, arguments.rounds)
    reads_s = min(found["reads"]) / 1000
    ratio = least_s(found["within"]) / reads_s
    text = bars.most(f"{ratio:.2f}", ratio, READS_BAR)
    bars.met = bars.met and found["within"][-1].peak_bytes <= GIANT_BAR_BYTES
    yield row(name, f"{GIANT_BYTES / 1e6:.0f} MB", found["within"], f"{text} of two reads, {reads_s:.2f} s")


def table(arguments, bars):
    rows = [each for name, mesh in arguments.meshes for each in measure(name, mesh, arguments, bars)]
    if arguments.giant:
        rows += measure_giant(*arguments.giant.split("=", 1), arguments, bars)
    heads = ["mesh", "budget", "time", "over that in memory (a half: at most 1.2; two reads: at most 3)", "processor time", "peak", "ranges"]
    return [markdown_table(heads, rows)]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "memory", table, "tool", "meshes", giant="", layer_height="0.1", rounds=3))
