#!/usr/bin/env python3
"""Draws scaling.svg from a folder's summary.json, into the same folder. Usage: scaling.py FOLDER"""
import os
import sys

from chart import Axis, Panel, save
from results import Results, ratio

STRONG = ("liver", "femur", "brain", "hip_femur", "scan", "scan_shuffled", "figure", "skull", "columns_planes1",
          "columns_planes4", "prism_planes1", "prism_planes4")


def strong(results):
    counts = results.thread_counts()
    panel = Panel("strong scaling, measured", Axis("threads", ticks=counts), Axis("speed-up"))
    for case in STRONG:
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


def allowed(results):
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
    save(os.path.join(sys.argv[1], "scaling.svg"), [strong(results), weak(results), allowed(results)], 400, 300, heading)


if __name__ == "__main__":
    main()
