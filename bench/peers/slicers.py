#!/usr/bin/env python3
"""Times a slicing program as a whole process and prints one line of JSON.

    slicers.py slic3r|prusa-slicer|CuraEngine MESH --layer-height MM [--threads N] [--limit S] [--lamella PROGRAM]

Everything after slicing that can be switched off is off (infill, solid layers, skirt). Stage times are those that the program
prints. Exit status: 0 done, 75 over the time limit before the slices were made, 77 not installed.
"""
import argparse
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time

OVER_LIMIT = 75
NOT_INSTALLED = 77


def not_installed(what):
    print(f"slicers.py: {what}", file=sys.stderr)
    sys.exit(NOT_INSTALLED)


def between(lines, begin, end):
    """Seconds between the printing of two texts; None if one has not been printed."""
    at_s = [next((at_s for at_s, line in lines if text in line), None) for text in (begin, end)]
    return None if None in at_s else at_s[1] - at_s[0]


def number(lines, pattern):
    found = re.search(pattern, "".join(line for _, line in lines))
    return float(found[1]) if found else None


# A program has words(request, engine) of its command line, and slice_s(lines) and planes(file, lines) of the lines that it printed, each
# with its time.

class Slic3r:
    output = "slices.svg"

    def words(self, request, _engine):
        height = str(request.layer_height)
        return ["--no-gui", "--threads", str(request.threads), "--layer-height", height, "--first-layer-height", height,
                "--export-svg", "--output", self.output, request.mesh]

    def slice_s(self, lines):
        return between(lines, "Processing triangulated mesh", "Exporting to")

    def planes(self, file, _lines):
        return len(contours_by_layer(file))


class PrusaSlicer:
    output = "paths.gcode"

    def words(self, request, _engine):
        height = str(request.layer_height)
        return ["--export-gcode", "--loglevel", "3", "--datadir", "settings", "--output", self.output,
                "--layer-height", height, "--first-layer-height", height,
                "--nozzle-diameter", str(max(0.4, request.layer_height)),  # PrusaSlicer refuses layers higher than the nozzle
                "--bed-shape", "0x0,2000x0,2000x2000,0x2000", "--max-print-height", "1200",
                "--slice-closing-radius", "0", "--elefant-foot-compensation", "0", "--resolution", "0",
                "--perimeters", "1", "--perimeter-generator", "classic", "--fill-density", "0",
                "--top-solid-layers", "0", "--bottom-solid-layers", "0", "--skirts", "0", request.mesh]

    def slice_s(self, lines):
        return between(lines, "Slicing volumes...", "Generating perimeters")

    def planes(self, file, _lines):
        with open(file, encoding="utf-8") as paths:
            return sum(line.startswith(";LAYER_CHANGE") for line in paths)


class CuraEngine:
    output = "paths.gcode"

    def words(self, request, engine):
        definition = "/usr/share/cura/resources/definitions/fdmprinter.def.json"
        if not os.path.exists(definition):
            not_installed(f"CuraEngine needs {definition}, of Debian's package cura")
        settings = {"layer_height": request.layer_height, "layer_height_0": request.layer_height,
                    # CuraEngine cuts from z = 0 up, wherever the mesh begins.
                    "mesh_position_z": -engine["box_mm"]["min"][2],
                    "wall_line_count": 1, "top_layers": 0, "bottom_layers": 0, "infill_line_distance": 0,
                    "adhesion_type": "none"}
        options = [word for name, value in settings.items() for word in ("-s", f"{name}={value}")]
        return ["slice", "-v", f"-m{request.threads}", "-j", definition, "-o", self.output, *options, "-e0", *options,
                "-l", request.mesh]

    def slice_s(self, lines):
        return number(lines, r"Progress: slice accomplished in ([\d.]+)s")

    def planes(self, _file, lines):
        return number(lines, r"Layer count: (\d+)")


PEERS = {"slic3r": Slic3r(), "prusa-slicer": PrusaSlicer(), "CuraEngine": CuraEngine()}


def contours_by_layer(svg):
    """Contours by layer in an SVG of Slic3r's convention, which the engine follows too."""
    counts = []
    with open(svg, encoding="utf-8") as file:
        for line in file:
            if "<g " in line:
                counts.append(0)
            if counts:
                counts[-1] += line.count("<polygon") + line.count("<polyline")
    return counts


def run(words, folder, cores, limit_s):
    """The lines that the program printed, each with its time, and the run time in seconds; None if it was stopped at the limit."""
    start = time.monotonic()
    # Not every program has an option for threads, but all of them respect the set of cores that they may use.
    with subprocess.Popen(words, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace", preexec_fn=lambda: os.sched_setaffinity(0, cores)) as process:
        alarm = threading.Timer(limit_s, process.kill)
        alarm.start()
        lines = [(time.monotonic() - start, line) for line in process.stdout]
        alarm.cancel()
    seconds = time.monotonic() - start
    if process.returncode != 0 and seconds < limit_s:
        sys.exit(f"slicers.py: {words[0]} ended with status {process.returncode}: {''.join(line for _, line in lines)[-300:]}")
    return lines, seconds if seconds < limit_s else None


def engine_answer(request, folder):
    """The engine's report, and the number of its contours by layer."""
    svg = os.path.join(folder, "engine.svg")
    words = [request.lamella, "slice", request.mesh, "--layer-height", str(request.layer_height), "-o", svg, "--report", "-"]
    sliced = subprocess.run(words, capture_output=True, text=True, check=False)
    if sliced.returncode != 0:
        sys.exit(sliced.stderr.strip())
    counts = contours_by_layer(svg)
    os.remove(svg)
    return json.loads(sliced.stdout), counts


def measure(request, folder):
    peer = PEERS[request.peer]
    engine, expected = engine_answer(request, folder)
    words = [request.peer, *peer.words(request, engine)]
    cores = sorted(os.sched_getaffinity(0))[:request.threads]
    deadline = time.monotonic() + (request.limit or threading.TIMEOUT_MAX / 2)
    row = {"engine_planes": engine["planes"], "engine_contours": engine["contours"], "slice_s": [], "total_s": []}
    wanted = 1
    while len(row["total_s"]) < wanted:
        lines, seconds = run(words, folder, cores, deadline - time.monotonic())
        if seconds is None and row["total_s"]:
            break
        sliced_s = peer.slice_s(lines)
        if sliced_s is None:
            sys.exit(OVER_LIMIT if seconds is None else f"slicers.py: {request.peer} did not print when it had sliced")
        row["slice_s"].append(sliced_s)
        row["total_s"].append(seconds)
        if seconds is None:
            break
        wanted = 5 if row["total_s"][0] < 2 else 3 if row["total_s"][0] < 10 else 1
        file = os.path.join(folder, peer.output)
        row["planes"] = peer.planes(file, lines)
        if file.endswith(".svg"):  # tool paths are offset, joined and dropped, so their contours cannot be counted
            apart = [abs(a - b) for a, b in itertools.zip_longest(contours_by_layer(file), expected, fillvalue=0)]
            row |= {"planes_apart": sum(map(bool, apart)), "contours_apart": sum(apart)}
    return row


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description="Times a slicing program as a whole process.")
    parser.add_argument("peer", choices=PEERS)
    parser.add_argument("mesh", type=os.path.abspath)
    parser.add_argument("--layer-height", type=float, default=0.032, metavar="MM")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("--limit", type=float, default=0, metavar="S", help="seconds for all runs together; 0: none")
    parser.add_argument("--lamella", default=os.path.join(here, "../../build/tools/lamella"), type=os.path.abspath,
                        metavar="PROGRAM", help="the engine to compare with")
    request = parser.parse_args()
    if not os.path.exists(request.lamella):
        parser.error(f"there is no {request.lamella}: build it, or pass --lamella PROGRAM")
    if shutil.which(request.peer) is None:
        not_installed(f"{request.peer} is not installed")
    with tempfile.TemporaryDirectory(prefix="lamella-peer-") as folder:
        print(json.dumps(measure(request, folder)))


if __name__ == "__main__":
    main()
