"""Measures rows of the paper's tables: one method on one model, in a process of its own. Finished rows are kept in files."""
import json
import os
import statistics
import subprocess
import sys
from typing import NamedTuple, Optional

from paper_models import ALIKE, LAYER_MM, RANDOM_MM

OVER_LIMIT, NOT_INSTALLED, NOT_FOR_THIS_MESH = 75, 77, 78  # exit statuses of the programs


class Method(NamedTuple):
    name: str
    adaptive: bool = False   # also measured with random spacing
    limited: bool = True     # stopped at the time limit
    takes_open: bool = True  # False: the row is "n/a" for a mesh that is not closed
    exact: bool = True       # whether its contours must equal the engine's


# A slicing method and a contour method are measured in separate rows, so that a timeout of one does not hide the other.
METHODS = [
    Method("incremental+hashed+rays", adaptive=True, limited=False),
    Method("presorted", adaptive=True),
    Method("trivial", adaptive=True),
    Method("Tata", adaptive=True),
    Method("Huang"),
    Method("sort-first", adaptive=True),
    Method("Huang+trivial"),
    Method("Huang+sweep-line+rays", exact=False),  # splits segments where they touch; contours have either orientation
    Method("Slic3r", adaptive=True),
    Method("McMains", adaptive=True, takes_open=False),
    Method("topological", adaptive=True, takes_open=False),
    Method("LDNI, 0.1 mm", exact=False, takes_open=False),
]
PEERS = ["cgal", "vtk", "slic3r", "prusa-slicer", "CuraEngine"]


class Row(NamedTuple):
    model: str
    spacing: str  # uniform or adaptive
    method: str
    threads: int
    figures: Optional[dict]  # None: not measured, for the reason in `missing`
    missing: str = ""

    def seconds(self, key):
        """Median of slicing_s, contours_s, sense_s or their sum ("total_s"); None if it was not measured."""
        if self.figures is None:
            return None
        if key == "total_s":
            parts = [self.figures.get(part) for part in ("slicing_s", "contours_s")]
            runs = [sum(run) for run in zip(*(part for part in parts if part))]
        else:
            runs = self.figures.get(key)
        return statistics.median(runs) if runs else None


class Bench:
    """Locations of programs, meshes and rows, and the time limit of a method."""

    def __init__(self, build, files, folder, limit, peer_options):
        self.build, self.files, self.folder, self.limit, self.peer_options = build, files, folder, limit, peer_options
        self.meshes, self.kept = os.path.join(folder, "meshes"), os.path.join(folder, "rows")
        for path in (self.meshes, self.kept):
            os.makedirs(path, exist_ok=True)

    def mesh(self, model):
        """The path of the user's file of that name, or of the stand-in, and whether it is the stand-in."""
        own = os.path.join(self.files, model.name + ".stl")
        if os.path.exists(own):
            return own, False
        return (None, False) if model.recipe is None else (os.path.join(self.meshes, model.name + ".stl"), True)

    def make_mesh(self, model):
        """Makes the stand-in if the model has no file yet."""
        path, stand_in = self.mesh(model)
        if stand_in and not os.path.exists(path):
            shape, height, seed = model.recipe
            subprocess.run([os.path.join(self.build, "tools/lamella"), "make", shape, "--triangles", str(model.n),
                            "--height", str(height), "--segments", str(model.m), "--layer-height", str(LAYER_MM),
                            "--seed", str(seed), "-o", path], check=True, stdout=subprocess.DEVNULL)
        return path

    def forget_mesh(self, model):
        path, stand_in = self.mesh(model)
        if stand_in and os.path.exists(path):
            os.remove(path)

    def command(self, mesh, spacing, method, threads, limit):
        program = os.path.join(self.build, "bench/lamella_paper_row")
        planes = ["--layer-height", str(LAYER_MM)] if spacing == "uniform" else ["--random-heights", RANDOM_MM]
        return [program, "--mesh", mesh, "--method", method, "--threads", str(threads), "--limit", str(limit), *planes]

    def peer_command(self, mesh, peer, threads):
        if peer in ("cgal", "vtk"):
            program = [os.path.join(self.build, "bench/peers/lamella_peer_" + peer)]
            if not os.path.exists(program[0]):
                program = ["sh", "-c", f"exit {NOT_INSTALLED}"]
        else:
            program = [sys.executable, "bench/peers/slicers.py", peer, "--lamella",
                       os.path.join(self.build, "tools/lamella"), *self.peer_options.get(peer, [])]
        return [*program, "--mesh", mesh, "--layer-height", str(LAYER_MM), "--threads", str(threads), "--limit",
                str(self.limit)]

    def run(self, model, spacing, method, threads, command, limit):
        """The stored row; if there is none, measures it and stores it."""
        path = os.path.join(self.kept, f"{model.name}.{spacing}.{method.replace('/', '-')}.{threads}.json")
        if os.path.exists(path):
            with open(path, encoding="utf-8") as file:
                return Row(*json.load(file))
        self.make_mesh(model)
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        said = done.stderr.strip().splitlines()
        reasons = {OVER_LIMIT: f"> {limit} s", NOT_INSTALLED: "not installed", NOT_FOR_THIS_MESH: "n/a"}
        failed = f"failed: {said[-1] if said else 'status ' + str(done.returncode)}"
        figures = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else None
        row = Row(model.name, spacing, method, threads, figures, "" if figures else reasons.get(done.returncode, failed))
        with open(path + ".part", "w", encoding="utf-8") as file:
            json.dump(row, file)
        os.replace(path + ".part", path)
        return row


def unlike(model, engine):
    """The quantities in which a stand-in differs from the paper's model; empty if it matches."""
    wrong = [name for name, most in ALIKE.items()
             if abs(engine.figures[name] / getattr(model, name) - 1) > most]
    return wrong + (["k"] if engine.figures["k"] != model.k else [])


def failures(rows):
    """Errors: methods that failed, or that did not find the engine's segments on a closed mesh."""
    said = [f"{row.model}, {row.spacing}, {row.method}: {row.missing}" for row in rows if row.missing.startswith("failed")]
    exact = {method.name for method in METHODS if method.exact} | {"engine"}
    return said + [f"{row.model}, {row.spacing}, {row.method}: not the engine's segments" for row in rows
                   if row.method in exact and row.figures and row.figures["open"] == 0 and row.figures["planes_apart"] > 0]


def measure(bench, models, threads, say):
    """Every row of these models, from the smallest to the largest. A stopped method is not run on larger models."""
    rows, beaten = [], {}
    for model in sorted(models, key=lambda model: model.size()):
        mesh, stand_in = bench.mesh(model)
        if mesh is None:
            say(f"{model.name}: left out, there is no {model.name}.stl in {bench.files}")
            continue
        for spacing in ("uniform", "adaptive"):
            engines = []
            for count in threads:
                say(f"{model.name}, {spacing}: engine, threads: {count}")
                engines.append(bench.run(model, spacing, "engine", count, bench.command(mesh, spacing, "engine", count, 0), 0))
            rows += engines
            if engines[0].figures is None:
                raise SystemExit(f"{model.name}: the engine {engines[0].missing}")
            engines[0].figures["stand_in"] = stand_in
            if stand_in and spacing == "uniform" and unlike(model, engines[0]):
                raise SystemExit(f"{model.name}: the stand-in differs from the paper's model in " +
                                 ", ".join(unlike(model, engines[0])))
            closed = engines[0].figures["open"] == 0
            for method in METHODS:
                if spacing == "adaptive" and not method.adaptive:
                    continue
                if not closed and not method.takes_open:
                    rows.append(Row(model.name, spacing, method.name, 1, None, "n/a"))
                    continue
                limit = bench.limit if method.limited else 0
                command = bench.command(mesh, spacing, method.name, 1, limit)
                rows.append(row_within(limit, bench, model, spacing, method.name, command, beaten, say))
        for peer in PEERS:
            rows.append(row_within(bench.limit, bench, model, "uniform", "peer " + peer, bench.peer_command(mesh, peer, 1), beaten, say))
        bench.forget_mesh(model)
    return rows


def row_within(limit, bench, model, spacing, method, command, beaten, say):
    """The row of a method that was not stopped on a smaller model."""
    if (spacing, method) in beaten:
        return Row(model.name, spacing, method, 1, None, beaten[spacing, method])
    say(f"{model.name}, {spacing}: {method}")
    row = bench.run(model, spacing, method, 1, command, limit)
    late = row.figures is not None and None in row.figures.get("total_s", [])  # stopped at the limit, after its slices were made
    if late or row.missing.startswith(">"):
        beaten[spacing, method] = f"not run: > {limit} s on {model.name}"
    return row
