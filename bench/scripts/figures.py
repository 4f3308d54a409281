#!/usr/bin/env python3
"""Writes the figures of a results folder into README.md, between its two marks. Usage: figures.py FOLDER README"""
import sys

from bars import bars_table, number
from results import Results, markdown_table, ratio

BEGIN, END = "<!-- figures: begin -->\n", "<!-- figures: end -->\n"


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
        rows.append([case, variant] + [number(value, "") for value in figures])
    heads = (["case", "variant"] + [f"ms, {threads} thr." for threads in counts] +
             [f"speed-up, {most}", "M segments/s", "floor"])
    return markdown_table(heads, rows)


def reading(results):
    counts = results.thread_counts()
    rows = []
    for case, variant in results.case_variants("read"):
        def rates(counter):
            return [number(ratio(results.counter(counter, case, threads, variant, "read"), 1e6), "") for threads in counts]
        share = results.counter("share_of_pread", case, counts[-1], variant, "read")
        rows.append([case, variant] + rates("bytes/s") + rates("unpacked_bytes/s") + [number(share, "")])
    heads = ["format", "as"] + [f"{what}, {threads} thr." for what in ("MB/s", "unpacked") for threads in counts]
    return markdown_table(heads + ["share of pread"], rows)


def nesting(results):
    rows = []
    for case in results.cases("nesting"):
        rate = results.counter("contours/s", case, 1, "series", "nesting")
        rows.append([case, number(results.ms(case, 1, "series", "nesting"), ""), number(1e9 / rate, "") if rate else "-"])
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


def main():
    results = Results(sys.argv[1])
    with open(sys.argv[2], encoding="utf-8") as file:
        before, _, rest = file.read().partition(BEGIN)
    _, _, after = rest.partition(END)
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write(before + BEGIN + "\n" + text(results) + "\n\n" + END + after)


if __name__ == "__main__":
    main()
