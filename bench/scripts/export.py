#!/usr/bin/env python3
"""Writes runs.csv (a row for each run) and scaling.svg beside the results. Usage: export.py FOLDER"""
import csv
import os
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plot  # noqa: E402  (the backend must be chosen first)

from partition import allowed_speedups  # noqa: E402
from results import Results, ratio  # noqa: E402

STRONG = ("liver", "femur", "brain", "hip_femur", "scan", "scan_shuffled", "figure", "skull", "columns_planes1",
          "columns_planes4", "prism_planes1", "prism_planes4")


def write_csv(results):
    counters = sorted({name for run in results.runs for name in run.counters})
    with open(os.path.join(results.folder, "runs.csv"), "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["what", "case", "variant", "threads", "repetition", "ms", "error"] +
                        [name for name in counters if name != "threads"])
        for run in results.runs:
            writer.writerow([run.what, run.case, run.variant, run.threads, run.repetition, run.ms, run.error or ""] +
                            [run.counters.get(name, "") for name in counters if name != "threads"])


def plot_strong(results, axes):
    counts = results.thread_counts()
    for case in STRONG:
        times = [(threads, ratio(results.ms(case, 1), results.ms(case, threads))) for threads in counts]
        if all(speedup is not None for _, speedup in times):
            axes.plot(*zip(*times), marker="o", label=case)
    axes.plot(counts, counts, "k:", label="ideal")
    axes.set(title="strong scaling, measured", xlabel="threads", ylabel="speed-up", xticks=counts)
    axes.legend(fontsize=6)


def plot_weak(results, axes):
    counts = results.thread_counts()
    base = results.ms("weak_1", 1)
    points = [(threads, ratio(base, results.ms(f"weak_{threads}", threads))) for threads in counts]
    axes.plot(*zip(*[point for point in points if point[1] is not None]), marker="o", label="1 M triangles a thread")
    axes.axhline(1, color="k", linestyle=":", label="ideal")
    axes.set(title="weak scaling, measured", xlabel="threads", ylabel="efficiency", xticks=counts, ylim=(0, 1.2))
    axes.legend(fontsize=6)


def plot_allowed(results, axes):
    for name, case in results.partition.items():
        axes.plot(*zip(*allowed_speedups(case)), marker=".", label=name)
    counts = [2 ** i for i in range(8)]
    axes.plot(counts, counts, "k:", label="ideal")
    axes.set(title="allowed by the partition: computed, not measured", xlabel="threads", ylabel="speed-up", xticks=counts)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log", base=2)
    axes.legend(fontsize=6)


def plot_scaling(results):
    plot.rcParams["axes.prop_cycle"] = plot.cycler(color=plot.get_cmap("tab20").colors)
    figure, panels = plot.subplots(1, 3, figsize=(15, 5))
    plot_strong(results, panels[0])
    plot_weak(results, panels[1])
    plot_allowed(results, panels[2])
    context = results.context
    figure.suptitle("\n".join([f"{context['processor']}, {context['num_cpus']} cores, {context['compiler']}",
                               f"{context['flags']}; {context['pinning']}"]), fontsize=8)
    figure.tight_layout()
    figure.savefig(os.path.join(results.folder, "scaling.svg"))


def main():
    results = Results(sys.argv[1])
    write_csv(results)
    plot_scaling(results)


if __name__ == "__main__":
    main()
