#!/usr/bin/env python3
"""Draws scaling.svg from a folder's summary.json, into the same folder; with README, writes the tables between its two marks.

Usage: figures.py FOLDER [README]"""
import os
import pathlib
import sys

from bars import REAL, bars_table, number
from chart import Axis, Panel, save
from readme_table import markdown_table, replace_table
from results import Results, ratio


def machine(results):
    context = results.context
    names = {"processor": "processor", "memory": "memory", "compiler": "compiler", "flags": "flags",
             "allocator": "allocator", "pinning": "pinning", "transparent_huge_pages": "transparent huge pages"}
    rows = [[name, context.get(key, "unknown")] for key, name in names.items()]
    rows.insert(1, ["cores", context["num_cpus"]])
    rows.append(["measured", ", ".join(context["dates"])])
    for threads in results.thread_counts():
        speed = results.counter("bytes/s", "memory", threads, "warm", "copy")
        rows.append([f"copy bandwidth, threads: {threads}", f"{speed / 1e9:.1f} GB/s, read and written" if speed else "-"])
    return markdown_table(["machine", ""], rows)


def times(results):
    """Time by thread count, then speed-up, segments/s and floor at the most threads."""
    counts = results.thread_counts()
    most = counts[-1]
    rows = []
    for case, variant in results.case_variants("end_to_end"):
        ms = [results.ms(case, threads, variant) for threads in counts]
        rate = results.counter("segments/s", case, most, variant)
        figures = [*ms, ratio(ms[0], ms[-1]), ratio(rate, 1e6), results.counter("floor", case, most, variant)]
        rows.append([case, variant] + [number(value) for value in figures])
    heads = (["case", "variant"] + [f"ms, {threads} thr." for threads in counts] +
             [f"speed-up, {most}", "M segments/s", "floor"])
    return markdown_table(heads, rows)


def reading(results):
    counts = results.thread_counts()
    rows = []
    for case, variant in results.case_variants("read"):
        def rates(counter):
            return [number(ratio(results.counter(counter, case, threads, variant, "read"), 1e6)) for threads in counts]
        share = results.counter("share_of_pread", case, counts[-1], variant, "read")
        rows.append([case, variant] + rates("bytes/s") + rates("unpacked_bytes/s") + [number(share)])
    heads = ["format", "as"] + [f"{what}, {threads} thr." for what in ("MB/s", "unpacked") for threads in counts]
    return markdown_table(heads + ["share of pread"], rows)


def nesting(results):
    rows = []
    for case in results.cases("nesting"):
        rate = results.counter("contours/s", case, 1, "series", "nesting")
        rows.append([case, number(results.ms(case, 1, "series", "nesting")), number(1e9 / rate) if rate else "-"])
    return markdown_table(["layer", "ms", "ns a contour"], rows)


def allowed(results):
    counts = [2 ** i for i in range(8)]
    rows = []
    for name, case in results.partition.items():
        speedups = dict(case["speedups"])
        rows.append([name] + [f"{speedups[threads]:.1f}" for threads in counts] + [f"{case['accounted_for']:.2f}"])
    return markdown_table(["case"] + [str(count) for count in counts] + ["accounted for"], rows)


def text(results):
    parts = [
        machine(results),
        "### Bars", bars_table(results),
        "### End to end, in memory and from a file", times(results),
        "### Reading, by format", reading(results),
        "### Nesting on lattices of rings; 1 thread", nesting(results),
        "### Speed-up allowed by the partition: computed, not measured", allowed(results),
    ]
    if "quick" in results.context["sizes"]:
        parts.insert(0, "Quick sizes: these figures mean nothing.")
    return "\n\n".join(parts)


def strong(results):
    counts = results.thread_counts()
    panel = Panel("strong scaling, measured", Axis("threads", ticks=counts), Axis("speed-up"))
    for case in REAL + ("columns_planes1", "columns_planes4", "prism_planes1", "prism_planes4"):
        points = [(threads, ratio(results.ms(case, 1), results.ms(case, threads))) for threads in counts]
        if all(speedup is not None for _, speedup in points):
            panel.line(case, points)
    panel.dotted("ideal", [(threads, threads) for threads in counts])
    return panel


def weak(results):
    counts = results.thread_counts()
    base = results.ms("weak_1", 1)
    points = [(threads, ratio(base, results.ms(f"weak_{threads}", threads))) for threads in counts]
    panel = Panel("weak scaling, measured", Axis("threads", ticks=counts), Axis("efficiency", limits=(0, 1.2)))
    panel.line("1 M triangles a thread", [point for point in points if point[1] is not None])
    panel.dotted("ideal", [(threads, 1) for threads in counts])
    return panel


def allowed_panel(results):
    panel = Panel("allowed by the partition: computed, not measured", Axis("threads", base=2), Axis("speed-up", base=2))
    for name, case in results.partition.items():
        panel.line(name, case["speedups"])
    panel.dotted("ideal", [(2 ** i, 2 ** i) for i in range(8)])
    return panel


def main():
    results = Results(sys.argv[1])
    context = results.context
    heading = (f"{context['processor']}, {context['num_cpus']} cores, {context['compiler']}",
               f"{context['flags']}; {context['pinning']}")
    save(os.path.join(sys.argv[1], "scaling.svg"), [strong(results), weak(results), allowed_panel(results)], 400, 300, heading)
    for readme in sys.argv[2:]:
        replace_table(pathlib.Path(readme), "figures", text(results) + "\n")


if __name__ == "__main__":
    main()
