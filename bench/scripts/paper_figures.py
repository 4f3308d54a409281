"""The paper's Figures 9, 11 and 12 from the rows measured here, as SVG."""
import math
import os

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plot  # noqa: E402  (the backend must be chosen first)

from paper_tables import PRINTED, SWEEP_LINE  # noqa: E402
from results import ratio  # noqa: E402


def draw(axes, rows, methods, key, spacing, x_of):
    """Seconds over what bounds them, a line for each method."""
    for method, label in methods:
        points = sorted((x_of(rows.engine(model, spacing).figures), rows.seconds(model, method, key, spacing))
                        for model in rows.models
                        if rows.engine(model, spacing) is not None and rows.seconds(model, method, key, spacing))
        if points:
            axes.plot(*zip(*points), marker="o", markersize=3, label=label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylabel("seconds")
    axes.grid(True, which="major", linewidth=0.3)
    axes.legend(fontsize=7)


def save(figure, folder, name):
    figure.tight_layout()
    path = os.path.join(folder, name)
    figure.savefig(path, metadata={"Date": None})
    plot.close(figure)
    return name


def figure_9(rows, folder):
    figure, (left, right) = plot.subplots(1, 2, figsize=(11, 4.5))
    methods = [("trivial", "Park (trivial)"), ("Tata", "Tata"), ("Slic3r", "Slic3r"), (PRINTED, "incremental, as printed")]
    draw(left, rows, methods + [("Huang", "Huang"), ("engine", "engine, 1 thread")], "slicing_s", "uniform",
         lambda f: f["n"] + f["k"] + f["m"])
    left.set(title="uniform slicing", xlabel="n + k + m")
    draw(right, rows, methods + [("sort-first", "sort first"), ("engine", "engine, 1 thread")], "slicing_s", "adaptive",
         lambda f: f["n"] * math.log2(f["k"]) + f["k"] + f["m"])
    right.set(title="adaptive slicing", xlabel="n log k + k + m")
    return save(figure, folder, "paper_figure_9.svg")


def figure_11(rows, folder):
    figure, axes = plot.subplots(figsize=(6, 4.5))
    draw(axes, rows, [("Huang+trivial", "trivial"), (SWEEP_LINE, "Park (sweep line)"), ("Slic3r", "Slic3r"),
                      (PRINTED, "hashed, as printed"), ("engine", "engine, 1 thread")], "contours_s", "uniform",
         lambda f: f["m"])
    axes.set(title="contours", xlabel="m")
    return save(figure, folder, "paper_figure_11.svg")


def figure_12(rows, folder):
    figure, axes = plot.subplots(figsize=(9, 4.5))
    names = [model.name for model in rows.models]
    bars = [("as printed / Slic3r's way", lambda m: ratio(rows.seconds(m, PRINTED, "total_s"), rows.seconds(m, "Slic3r", "total_s"))),
            ("engine / Slic3r's way", lambda m: ratio(rows.seconds(m, "engine", "total_s"), rows.seconds(m, "Slic3r", "total_s"))),
            ("engine / as printed", lambda m: ratio(rows.seconds(m, "engine", "total_s"), rows.seconds(m, PRINTED, "total_s"))),
            ("engine / Park", lambda m: ratio(rows.seconds(m, "engine", "total_s"), rows.park_total(m)))]
    for place, (label, share) in enumerate(bars):
        heights = [100 * (share(model) or 0) for model in rows.models]
        axes.bar([x + 0.2 * place for x in range(len(names))], heights, width=0.2, label=label)
    axes.set_yscale("log")
    axes.set_xticks([x + 0.3 for x in range(len(names))], names, rotation=30)
    axes.set(title="total time relative to others, 1 thread", ylabel="%")
    axes.legend(fontsize=7)
    return save(figure, folder, "paper_figure_12.svg")
