#!/usr/bin/env python3
"""Runs the paper's experiments and writes their tables and figures. Called by bench/paper.sh, which builds what it needs."""
import argparse
import os
import subprocess
import sys
import time

from paper_figures import compact_layers, figure_9, figure_11, figure_12
from paper_models import MODELS, QUICK
from paper_rows import PEERS, Bench, failures, measure
from paper_tables import Rows, bars, exponents, peers, table_1, table_2, table_3, table_4
from readme_table import machine_table, markdown_table, output_of

PICTURES = [  # like the paper's Figures 2 and 10: name, model, options of `lamella slice`
    ("paper_figure_2.svg", "liver", ["--layer-height", "4", "--normal", "0,1,0.3"]),
    ("paper_figure_10.svg", "femur", ["--layer-height", "2", "--normal", "0.25,1,0.15"]),
]


def arguments():
    parser = argparse.ArgumentParser(prog="bench/paper.sh", description="The paper's experiments, measured here")
    names = [model.name for model in MODELS]
    parser.add_argument("--models", help="comma list of " + ", ".join(names) + " (all)")
    parser.add_argument("--quick", action="store_true", help="liver, femur and bunny")
    parser.add_argument("--threads", help="comma list of thread counts of the engine (1 and all cores)")
    parser.add_argument("--limit", type=int, default=60, help="seconds after which a method is stopped (60)")
    parser.add_argument("--files", default="../shared/models", help="folder of meshes; NAME.stl there replaces the stand-in")
    parser.add_argument("--cura-definitions", help="folder of Cura's definitions (where Debian's cura puts them)")
    parser.add_argument("--build", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--keep", default="build/paper", help="folder for generated meshes and finished rows")
    parser.add_argument("--results", default="bench/results", help="folder for tables and figures")
    told = parser.parse_args()
    wanted = told.models.split(",") if told.models else list(QUICK) if told.quick else names
    unknown = [name for name in wanted if name not in names]
    if unknown:
        parser.error("no model is called " + ", ".join(unknown))
    told.models = [model for model in MODELS if model.name in wanted]
    cores = os.cpu_count() or 1
    told.threads = sorted({1} | ({int(count) for count in told.threads.split(",")} if told.threads else {cores}))
    return told


def environment(told):
    return machine_table("c++", {"build": "Release, mimalloc for all methods", "limit": f"{told.limit} s",
                                 "command": "`bench/paper.sh " + " ".join(sys.argv[3:]) + "`"})


def lower_bound(build):
    made = output_of(os.path.join(build, "bench/lamella_lower_bound"))
    rows = [[f"{one['n']:,}", f"{one['k']:,}", f"{one['least']:,.0f}", f"{one['search']:,}", f"{one['sweep']:,}",
             f"{(one['search'] + one['sweep']) / one['least']:.2f}"] for one in made]
    return markdown_table(["n", "k", "n log2 k", "comparisons of the search", "of the sweep", "all / n log2 k"], rows)


def draw_pictures(bench, folder, models):
    drawn = []
    for name, model_name, options in PICTURES:
        model = next((model for model in models if model.name == model_name), None)
        mesh = bench.make_mesh(model) if model else None
        if mesh:
            whole = os.path.join(bench.folder, name)
            subprocess.run([os.path.join(bench.build, "tools/lamella"), "slice", mesh, *options, "-o", whole],
                           check=True, stdout=subprocess.DEVNULL)
            with open(whole, encoding="utf-8") as svg, open(os.path.join(folder, name), "w", encoding="utf-8") as compact:
                compact.write(compact_layers(svg.read()))
            drawn.append(name)
    return drawn


def document(rows, told, figures, pictures, search):
    links = "\n".join(f"![{name}]({name})" for name in pictures + figures)
    parts = [
        "# The paper's experiments, measured here",
        "`bench/paper.sh` made this page. Times are in seconds, from the soup in memory to contours, quantising included, on one\n"
        "thread unless stated. They are medians of 5 runs if a run takes less than 2 s, of 3 if less than 10 s, else of 1. Every answer\n"
        "was compared with the engine's, plane by plane and contour by contour, before its time was printed. Where it differs, the\n"
        "difference stands beside the time. LDNI samples, so its contours differ by design; tests check that their areas agree within\n"
        "its resolution. Columns named *paper* are the paper's own figures, from another machine and, for models marked as stand-ins,\n"
        "another mesh. Do not divide them by the figures beside them.", environment(told),
        "## Table 1: models", table_1(rows),
        "## Table 2: slicing, uniform", table_2(rows, "uniform"),
        "## Table 2: slicing, adaptive (random spacing, 0.016 to 0.032 mm)", table_2(rows, "adaptive"),
        "## Table 3: contours, uniform", table_3(rows),
        "## Table 4: both, uniform", table_4(rows),
        "Park is the sum of the trivial slicing and the sweep line, measured separately. The printed algorithms do not orient contours;\n"
        "the engine orients and nests them. For that, the paper names point-in-polygon rays as the next step (*sense by rays*).",
        "## Peers, uniform", "Programs that a user might choose instead; see [bench/peers](../peers/README.md). CGAL and VTK: from the soup in memory\n"
        "to contours, one thread. Slicing programs: the time that they print for their slicing stage.", peers(rows, PEERS),
        "## Fitted exponents", exponents(rows),
        "## The lower bound (3.5)", "Instances of the multipoint search problem, posed as meshes.", search,
        "## Bars", bars(rows), "## Figures", links]
    return "\n\n".join(parts) + "\n"


def main():
    told = arguments()
    start = time.monotonic()

    def say(what):
        print(f"[{time.monotonic() - start:6.0f} s] {what}", flush=True)

    peer_options = {"CuraEngine": ["--definitions", told.cura_definitions]} if told.cura_definitions else {}
    bench = Bench(told.build, told.files, told.keep, told.limit, peer_options)
    os.makedirs(told.results, exist_ok=True)
    measured = measure(bench, told.models, told.threads, say)
    rows = Rows(measured, told.threads)
    say("tables and figures")
    figures = [draw(rows, told.results) for draw in (figure_9, figure_11, figure_12)]
    pictures = draw_pictures(bench, told.results, told.models)
    with open(os.path.join(told.results, "paper.md"), "w", encoding="utf-8") as file:
        file.write(document(rows, told, figures, pictures, lower_bound(told.build)))
    say("written to " + os.path.join(told.results, "paper.md"))
    if failures(measured):
        raise SystemExit("\n".join(failures(measured)))


if __name__ == "__main__":
    main()
