#!/usr/bin/env python3
"""Times a slicing program as a whole process and prints one line of JSON.

    slicers.py slic3r|prusa-slicer|CuraEngine --mesh FILE --layer-height MM [--threads N] [--limit S] [--lamella PROGRAM]
               [--definitions FOLDER]

Everything after slicing that can be switched off is off (infill, solid layers, skirt). Stage times are those that the program
prints. Exit status: 0 done, 75 over the time limit before the slices were made, 77 not installed.
"""
import argparse
import itertools
import json
import os
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time

OVER_LIMIT = 75
NOT_INSTALLED = 77
CURA_DEFINITIONS = "/usr/share/cura/resources/definitions"


class NotInstalled(Exception):
    pass


class Transcript:
    """The output of a process, with times."""

    def __init__(self):
        self.text = ""
        self.pieces = []  # (length of the text so far, seconds since the start)

    def add(self, piece, at_s):
        self.text += piece
        self.pieces.append((len(self.text), at_s))

    def time_of(self, words):
        """When these words had been printed; None: not yet."""
        place = self.text.find(words)
        return None if place < 0 else next(at_s for length, at_s in self.pieces if length >= place + len(words))

    def span(self, begin, end):
        """Seconds between the printing of two texts."""
        begin_s, end_s = self.time_of(begin), self.time_of(end)
        return None if begin_s is None or end_s is None else end_s - begin_s

    def number(self, pattern):
        found = re.search(pattern, self.text)
        return float(found[1]) if found else None


class Slicer:
    """What may differ between the programs: also words(request, engine), stages(transcript) and planes(folder, transcript)."""

    output = "paths.gcode"
    version_words, version_pattern = ["--help"], None

    def contours(self, _folder):
        return None  # tool paths are offset, joined and dropped, so contours cannot be counted


class Slic3r(Slicer):
    program = "slic3r"
    way = "slices exported as SVG"
    output = "slices.svg"
    version_words, version_pattern = ["--version"], r"^([\d.]+)"

    def words(self, request, _engine):
        height = str(request.layer_height)
        return ["--no-gui", "--threads", str(request.threads), "--layer-height", height, "--first-layer-height", height,
                "--export-svg", "--output", self.output, request.mesh]

    def stages(self, transcript):
        begin = "Processing triangulated mesh"
        return transcript.time_of(begin), transcript.span(begin, "Exporting to")

    def contours(self, folder):
        return contours_by_layer(os.path.join(folder, self.output))

    def planes(self, folder, _transcript):
        return len(self.contours(folder))


class PrusaSlicer(Slicer):
    program = "prusa-slicer"
    way = "G-code of one perimeter; gaps are not closed"
    version_pattern = r"PrusaSlicer-([\d.]+)"

    def words(self, request, _engine):
        height = str(request.layer_height)
        return ["--export-gcode", "--loglevel", "3", "--datadir", "settings", "--output", self.output,
                "--layer-height", height, "--first-layer-height", height,
                "--nozzle-diameter", str(max(0.4, request.layer_height)),  # PrusaSlicer refuses layers higher than the nozzle
                "--bed-shape", "0x0,2000x0,2000x2000,0x2000", "--max-print-height", "1200",
                "--slice-closing-radius", "0", "--elefant-foot-compensation", "0", "--resolution", "0",
                "--perimeters", "1", "--perimeter-generator", "classic", "--fill-density", "0",
                "--top-solid-layers", "0", "--bottom-solid-layers", "0", "--skirts", "0", request.mesh]

    def stages(self, transcript):
        begin = "Slicing volumes..."
        return transcript.time_of(begin), transcript.span(begin, "Generating perimeters")

    def planes(self, folder, _transcript):
        with open(os.path.join(folder, self.output), encoding="utf-8") as paths:
            return sum(line.startswith(";LAYER_CHANGE") for line in paths)


class CuraEngine(Slicer):
    program = "CuraEngine"
    way = "G-code of one wall"
    version_words, version_pattern = ["help"], r"version ([\d.]+)"

    def words(self, request, engine):
        definition = os.path.join(request.definitions, "fdmprinter.def.json")
        if not os.path.exists(definition):
            raise NotInstalled(f"CuraEngine needs {definition}, of Debian's package cura")
        settings = {"layer_height": request.layer_height, "layer_height_0": request.layer_height,
                    # CuraEngine cuts from z = 0 up, wherever the mesh begins.
                    "mesh_position_z": -engine["box_mm"]["min"][2],
                    "wall_line_count": 1, "top_layers": 0, "bottom_layers": 0, "infill_line_distance": 0,
                    "adhesion_type": "none"}
        options = [word for name, value in settings.items() for word in ("-s", f"{name}={value}")]
        return ["slice", "-v", f"-m{request.threads}", "-j", definition, "-o", self.output, *options, "-e0", *options,
                "-l", request.mesh]

    def stages(self, transcript):
        return (transcript.number(r"Loaded from disk in ([\d.]+)s"),
                transcript.number(r"Progress: slice accomplished in ([\d.]+)s"))

    def planes(self, _folder, transcript):
        layers = transcript.number(r"Layer count: (\d+)")
        return None if layers is None else int(layers)


PEERS = {peer.program: peer for peer in (Slic3r(), PrusaSlicer(), CuraEngine())}


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


class Runner:
    """Runs a program on a given number of cores, up to a deadline."""

    def __init__(self, request, folder):
        self.folder = folder
        self.deadline = time.monotonic() + request.limit if request.limit else None
        cores = sorted(os.sched_getaffinity(0))
        if request.threads > len(cores):
            sys.exit(f"slicers.py: {request.threads} threads asked for, {len(cores)} cores at hand")
        self.cores = cores[:request.threads]

    def run(self, words):
        """The program's transcript and its run time in seconds; None if it was stopped at the deadline."""
        transcript = Transcript()
        start = time.monotonic()
        # Not every program has an option for threads, but all of them respect the set of cores that they may use.
        process = subprocess.Popen(words, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, preexec_fn=lambda: os.sched_setaffinity(0, self.cores))
        while select.select([process.stdout], [], [], self.seconds_left())[0]:
            piece = os.read(process.stdout.fileno(), 1 << 16)
            if not piece:
                break
            transcript.add(piece.decode("utf-8", "replace"), time.monotonic() - start)
        else:
            process.kill()
            process.wait()
            return transcript, None
        status = process.wait()
        if status != 0:
            sys.exit(f"slicers.py: {words[0]} ended with status {status}: {transcript.text[-300:]}")
        return transcript, time.monotonic() - start

    def seconds_left(self):
        return None if self.deadline is None else max(0, self.deadline - time.monotonic())


def version_of(peer):
    if shutil.which(peer.program) is None:
        raise NotInstalled(f"{peer.program} is not installed")
    printed = subprocess.run([peer.program, *peer.version_words], capture_output=True, text=True, check=False)
    found = re.search(peer.version_pattern, printed.stdout + printed.stderr, re.MULTILINE)
    return found[1] if found else None


def engine_answer(request, folder):
    """The engine's report, and the number of its contours by layer."""
    svg = os.path.join(folder, "engine.svg")
    words = [request.lamella, "slice", request.mesh, "--layer-height", str(request.layer_height), "-o", svg, "--report", "-"]
    sliced = subprocess.run(words, capture_output=True, text=True, check=False)
    if sliced.returncode != 0:
        sys.exit(sliced.stderr.strip())
    report = json.loads(sliced.stdout)
    counts = contours_by_layer(svg)
    os.remove(svg)
    return report, counts


def measure(peer, request, folder):
    version = version_of(peer)
    engine, expected = engine_answer(request, folder)
    words = [peer.program, *peer.words(request, engine)]
    runner = Runner(request, folder)
    load_s, planes, contours, slice_s, total_s = None, None, None, [], []
    wanted = 1
    while len(total_s) < wanted:
        transcript, seconds = runner.run(words)
        if seconds is None and total_s:
            break
        load_s, sliced_s = peer.stages(transcript)
        if sliced_s is None:
            sys.exit(OVER_LIMIT if seconds is None else f"slicers.py: {peer.program} did not print when it had sliced")
        slice_s.append(sliced_s)
        total_s.append(seconds)
        if seconds is None:
            break
        wanted = 5 if total_s[0] < 2 else 3 if total_s[0] < 10 else 1
        planes, contours = peer.planes(folder, transcript), peer.contours(folder)
    apart = [abs(a - b) for a, b in itertools.zip_longest(contours, expected, fillvalue=0)] if contours else None
    return {"peer": peer.program, "version": version, "way": peer.way, "threads": request.threads,
            "triangles": engine["triangles"], "planes": planes,
            "contours": sum(contours) if contours else None, "segments": None,
            "engine_planes": engine["planes"], "engine_contours": engine["contours"], "engine_segments": engine["segments"],
            "planes_apart": sum(map(bool, apart)) if apart else None, "contours_apart": sum(apart) if apart else None,
            "load_s": load_s, "slice_s": slice_s, "total_s": total_s}


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description="Times a slicing program as a whole process.")
    parser.add_argument("peer", choices=PEERS)
    parser.add_argument("--mesh", required=True, type=os.path.abspath)
    parser.add_argument("--layer-height", type=float, default=0.032, metavar="MM")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("--limit", type=float, default=0, metavar="S", help="seconds for all runs together; 0: none")
    parser.add_argument("--lamella", default=os.path.join(here, "../../build/tools/lamella"), type=os.path.abspath,
                        metavar="PROGRAM", help="the engine to compare with")
    parser.add_argument("--definitions", default=CURA_DEFINITIONS, type=os.path.abspath, metavar="FOLDER",
                        help="where Cura's fdmprinter.def.json is")
    request = parser.parse_args()
    if not os.path.exists(request.lamella):
        parser.error(f"there is no {request.lamella}: build it, or pass --lamella PROGRAM")
    try:
        with tempfile.TemporaryDirectory(prefix="lamella-peer-") as folder:
            print(json.dumps(measure(PEERS[request.peer], request, folder)))
    except NotInstalled as absence:
        print(f"slicers.py: {absence}", file=sys.stderr)
        sys.exit(NOT_INSTALLED)


if __name__ == "__main__":
    main()
