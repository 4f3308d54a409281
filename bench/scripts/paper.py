#!/usr/bin/python3
"""Runs the paper's experiments and writes their tables and figures. Called by bench/paper.sh, which builds what it needs."""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import time
from typing import NamedTuple, Optional

from paper_models import ALIKE, LAYER_MM, MODELS, QUICK, RANDOM_MM
from paper_page import Rows, draw_figures, page

OVER_LIMIT, NOT_INSTALLED, NOT_FOR_THIS_MESH = 75, 77, 78  # exit statuses of the programs
PICTURES = [  # like the paper's Figures 2 and 10: name, model, options of `lamella slice`
    ("paper_figure_2.svg", "liver", ["--layer-height", "4", "--normal", "0,1,0.3", "--simplify", "0.3"]),
    ("paper_figure_10.svg", "femur", ["--layer-height", "2", "--normal", "0.25,1,0.15", "--simplify", "0.3"]),
]
# A slicing method and a contour method are measured in separate rows, so that a timeout of one does not hide the other.
#   adaptive    also measured with random spacing
#   unlimited   not stopped at the time limit
#   closed      only closed meshes
#   inexact     contours need not equal the engine's: the sweep line splits segments where they touch
METHODS = {
    "incremental+hashed+rays": {"adaptive", "unlimited"},
    "presorted": {"adaptive"},
    "trivial": {"adaptive"},
    "Tata": {"adaptive"},
    "Huang": set(),
    "sort-first": {"adaptive"},
    "Huang+trivial": set(),
    "Huang+sweep-line+rays": {"inexact"},
    "Slic3r": {"adaptive"},
    "McMains": {"adaptive", "closed"},
    "topological": {"adaptive", "closed"},
}
PEERS = ["cgal", "vtk", "slic3r", "prusa-slicer", "CuraEngine"]


class Row(NamedTuple):
    """A method on a model, measured in a process of its own."""
    model: str
    spacing: str  # uniform or adaptive
    method: str
    threads: int
    figures: Optional[dict]  # None: not measured, for the reason in `missing`
    missing: str = ""

    def seconds(self, key):
        """Median of slicing_s, contours_s, sense_s or the sum of the first two ("total_s"); None if it was not measured."""
        figures = self.figures or {}
        runs = figures.get(key)
        if key == "total_s" and "slicing_s" in figures:
            runs = [sum(run) for run in zip(*(figures[part] for part in ("slicing_s", "contours_s") if part in figures))]
        return statistics.median(runs) if runs else None


class Bench:
    """Measures rows. Finished ones are kept in files and not measured again; a stopped method is not run on larger models."""

    def __init__(self, told):
        self.told, self.start, self.stopped = told, time.monotonic(), {}
        for folder in ("meshes", "rows"):
            os.makedirs(os.path.join(told.keep, folder), exist_ok=True)

    def say(self, what):
        print(f"[{time.monotonic() - self.start:6.0f} s] {what}", flush=True)

    def program(self, name):
        return os.path.join(self.told.build, name)

    def mesh(self, model):
        """The path of the user's file of that name, or of the stand-in, and whether it is the stand-in."""
        own = os.path.join(self.told.files, model.name + ".stl")
        stand_in = model.recipe is not None and not os.path.exists(own)
        return (os.path.join(self.told.keep, "meshes", model.name + ".stl") if stand_in else own), stand_in

    def make_mesh(self, model):
        path, stand_in = self.mesh(model)
        if stand_in and not os.path.exists(path):
            shape, height, seed = model.recipe
            subprocess.run([self.program("tools/lamella"), "make", shape, "--triangles", str(model.n), "--height", str(height),
                            "--segments", str(model.m), "--layer-height", str(LAYER_MM), "--seed", str(seed), "-o", path],
                           check=True, stdout=subprocess.DEVNULL)
        return path

    def command(self, mesh, spacing, method, threads, limit):
        if method in PEERS[:2]:
            return [self.program("bench/peers/lamella_peer_" + method), mesh, str(LAYER_MM), str(threads), str(limit)]
        if method in PEERS:
            return [sys.executable, "bench/peers/slicers.py", method, mesh, "--layer-height", str(LAYER_MM), "--threads", str(threads),
                    "--limit", str(limit), "--lamella", self.program("tools/lamella")]
        heights = str(LAYER_MM) if spacing == "uniform" else RANDOM_MM
        return [self.program("bench/lamella_paper_row"), method, mesh, heights, str(threads), str(limit)]

    def run(self, model, spacing, method, threads, limit):
        path = pathlib.Path(self.told.keep, "rows", f"{model.name}.{spacing}.{method}.{threads}.json")
        if not path.exists():
            self.say(f"{model.name}, {spacing}: {method}, threads: {threads}")
            command = self.command(self.make_mesh(model), spacing, method, threads, limit)
            missing, figures = "not installed", None
            if os.path.exists(command[0]):
                done = subprocess.run(command, capture_output=True, text=True, check=False)
                reasons = {OVER_LIMIT: f"> {limit} s", NOT_INSTALLED: "not installed", NOT_FOR_THIS_MESH: "n/a", 0: ""}
                last = (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]
                missing = reasons.get(done.returncode, "failed: " + last)
                figures = json.loads(done.stdout) if done.returncode == 0 else None
            path.with_suffix(".part").write_text(json.dumps(Row(model.name, spacing, method, threads, figures, missing)))
            path.with_suffix(".part").replace(path)
        return Row(*json.loads(path.read_text()))

    def run_limited(self, model, spacing, method):
        """The row of a method that is stopped at the limit, if it was not stopped on a smaller model."""
        if (spacing, method) in self.stopped:
            return Row(model.name, spacing, method, 1, None, self.stopped[spacing, method])
        limit = 0 if "unlimited" in METHODS.get(method, ()) else self.told.limit
        row = self.run(model, spacing, method, 1, limit)
        # A slicing program may be stopped after its slices were made.
        if row.missing.startswith(">") or None in (row.figures or {}).get("total_s", []):
            self.stopped[spacing, method] = f"not run: > {limit} s on {model.name}"
        return row

    def measure_spacing(self, model, spacing):
        rows = [self.run(model, spacing, "engine", count, 0) for count in self.told.threads]
        engine, stand_in = rows[0].figures, self.mesh(model)[1]
        if engine is None:
            raise SystemExit(f"{model.name}: the engine {rows[0].missing}")
        engine["stand_in"] = stand_in
        unlike = [name for name, most in ALIKE.items() if abs(engine[name] / getattr(model, name) - 1) > most]
        if stand_in and spacing == "uniform" and unlike:
            raise SystemExit(f"{model.name}: the stand-in differs from the paper's model in " + ", ".join(unlike))
        for method, flags in METHODS.items():
            if spacing == "uniform" or "adaptive" in flags:
                is_open = "closed" in flags and engine["open"] > 0
                rows.append(Row(model.name, spacing, method, 1, None, "n/a") if is_open else self.run_limited(model, spacing, method))
        return rows + [self.run_limited(model, spacing, peer) for peer in PEERS if spacing == "uniform"]

    def measure(self):
        """Every row of the models, from the smallest to the largest."""
        rows = []
        for model in sorted(self.told.models, key=lambda model: model.n + model.k + model.m):
            path, stand_in = self.mesh(model)
            if not stand_in and not os.path.exists(path):
                self.say(f"{model.name}: left out, there is no {path}")
                continue
            rows += [row for spacing in ("uniform", "adaptive") for row in self.measure_spacing(model, spacing)]
            if stand_in and os.path.exists(path):
                os.remove(path)
        return rows


def failures(rows):
    """Errors: methods that failed, or that did not find the engine's segments on a closed mesh."""
    said = [f"{row.model}, {row.spacing}, {row.method}: {row.missing}" for row in rows if row.missing.startswith("failed")]
    exact = {method for method, flags in METHODS.items() if "inexact" not in flags} | {"engine"}
    return said + [f"{row.model}, {row.spacing}, {row.method}: not the engine's segments" for row in rows
                   if row.method in exact and row.figures and row.figures["open"] == 0 and row.figures["planes_apart"] > 0]


def arguments():
    parser = argparse.ArgumentParser(prog="bench/paper.sh", description="The paper's experiments, measured here")
    by_name = {model.name: model for model in MODELS}
    parser.add_argument("--models", type=lambda names: names.split(","), help="comma list of " + ", ".join(by_name) + " (all)")
    parser.add_argument("--quick", action="store_true", help="liver, femur and bunny")
    parser.add_argument("--threads", help="comma list of thread counts of the engine (1 and all cores)")
    parser.add_argument("--limit", type=int, default=60, help="seconds after which a method is stopped (60)")
    parser.add_argument("--files", default="../shared/models", help="folder of meshes; NAME.stl there replaces the stand-in")
    parser.add_argument("--build", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--keep", default="build/paper", help="folder for generated meshes and finished rows")
    parser.add_argument("--results", default="bench/results", help="folder for tables and figures")
    told = parser.parse_args()
    names = told.models or (QUICK if told.quick else list(by_name))
    unknown = set(names) - set(by_name)
    if unknown:
        parser.error("no model is called " + ", ".join(sorted(unknown)))
    told.models = [by_name[name] for name in by_name if name in names]
    told.threads = sorted({1, *(int(count) for count in (told.threads or str(os.cpu_count() or 1)).split(","))})
    return told


def draw_pictures(bench):
    for name, model_name, options in PICTURES:
        for model in bench.told.models:
            if model.name == model_name and os.path.exists(bench.mesh(model)[0]):
                picture = os.path.join(bench.told.results, name)
                subprocess.run([bench.program("tools/lamella"), "slice", bench.mesh(model)[0], *options, "-o", picture], check=True,
                               stdout=subprocess.DEVNULL)
                yield name


def main():
    told = arguments()
    bench = Bench(told)
    os.makedirs(told.results, exist_ok=True)
    measured = bench.measure()
    rows = Rows(measured, told.threads)
    bench.say("tables and figures")
    pictures = [*draw_pictures(bench), *draw_figures(rows, told.results)]
    pathlib.Path(told.results, "paper.md").write_text(page(rows, told, PEERS, pictures))
    bench.say("written to " + os.path.join(told.results, "paper.md"))
    if failures(measured):
        raise SystemExit("\n".join(failures(measured)))


if __name__ == "__main__":
    main()
