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


def across(results, what, case, variant, counts):
    """The cells for time by thread count, then speed-up, segments/s and floor at the most threads."""
    most = counts[-1]
    speedup = ratio(results.ms(case, 1, variant, what), results.ms(case, most, variant, what))
    rate = results.counter("segments/s", case, most, variant, what)
    return ([number(results.ms(case, threads, variant, what), "") for threads in counts] +
            [number(speedup, ""), number(ratio(rate, 1e6), ""),
             number(results.counter("floor", case, most, variant, what), "")])


def times(results, what):
    counts = results.thread_counts()
    heads = (["case", "variant"] + [f"ms, {threads} thr." for threads in counts] +
             [f"speed-up, {counts[-1]}", "M segments/s", "floor"])
    return markdown_table(heads, [[case, variant] + across(results, what, case, variant, counts)
                                  for case, variant in results.case_variants(what)])


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
        variant = "series" if case.startswith("rings_") else "most_contours"
        rate = results.counter("contours/s", case, 1, variant, "nesting")
        rows.append([case, number(results.ms(case, 1, variant, "nesting"), ""), number(1e9 / rate, "") if rate else "-"])
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
        "### End to end, in memory and from a file", times(results, "end_to_end"),
        "### Stages", times(results, "stage"),
        "### Reading, by format", reading(results),
        "### assemble() on a case's largest layer", times(results, "assemble"),
        "### Nesting on a case's layer of most contours, and on lattices of rings; 1 thread", nesting(results),
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
