#!/usr/bin/env python3
"""Measures what a batch gains from a second processor, and what it costs beside single runs.

    bench/scripts/batch.py LAMELLA [--meshes 500] [--jobs 2] [--memory 1G] [--rounds 1] [--folder DIR] [--readme bench/README.md]

Cuts 500 meshes of 10 thousand to 2 million triangles into masks of 1 mm. Three of them are damaged, and one is larger than the
memory that the batch is given. Of 25 meshes each has 20 names (hard links), so that all files stay in the page cache. Each round runs
every mesh by `lamella slice --threads 1`, one after the other, then the batch with one job, then with several. Ratios are those
within a round, since a machine changes its speed between rounds. Prints a table of the medians; with --readme it also replaces the
one between the markers there. The exit status is 1 if a bar is not met.
"""

import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

from readme_table import mark, mark_least, show, table_parser

THROUGHPUT_BAR = 1.8
PROCESSOR_BAR = 1.10
DISTINCT = 25
LEAST, MOST = 10_000, 2_000_000
DAMAGED = 3


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def timed(work):
    """Wall and processor seconds."""
    wall, processor = time.perf_counter(), processor_seconds()
    work()
    return time.perf_counter() - wall, processor_seconds() - processor


def options(folder):
    return ["--like", str(folder / "like.nii.gz"), "--frame", "lps"]


def make_meshes(tool, folder, count, large):
    meshes = folder / "meshes"
    meshes.mkdir(parents=True)
    for i in range(DISTINCT):
        triangles = round(LEAST * (MOST / LEAST) ** (i / (DISTINCT - 1)))
        made = folder / f"made{i}.stl"
        shape = ["bone", "bone", "torus", "sphere"][i % 4]
        command = [tool, "make", shape, "--triangles", str(triangles), "--height", "100", "-o", str(made)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    for i in range(count - DAMAGED - 1):
        os.link(folder / f"made{i % DISTINCT}.stl", meshes / f"mesh{i:03}.stl")
    for i in range(DAMAGED):
        (meshes / f"damaged{i}.stl").write_bytes((folder / f"made{i}.stl").read_bytes()[: 84 + 50 * 1000 + 17])
    command = [tool, "make", "bone", "--triangles", str(large), "--height", "100", "-o", str(meshes / "large.stl")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    command = [tool, "slice", str(folder / "made3.stl"), "--spacing", "1,1,1", "--frame", "lps", "-o", str(folder / "like.nii.gz")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def slice_one_by_one(tool, folder, memory):
    out = folder / "single"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    for mesh in sorted((folder / "meshes").iterdir()):
        command = [tool, "slice", str(mesh), "--threads", "1", *options(folder), "-o", str(out / f"{mesh.stem}.nii.gz")]
        command += ["--memory", memory] if mesh.stem == "large" else []
        subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def slice_batch(tool, folder, jobs, memory):
    shutil.rmtree(folder / "out", ignore_errors=True)
    command = [tool, "batch", str(folder / "meshes"), *options(folder), "-o", str(folder / "out" / "{stem}.nii.gz"),
               "--jobs", str(jobs), "--memory", memory, "--progress", "never"]  # fmt: skip
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def wrong_results(folder, count):
    """What differs from the single runs, or is not as it should be."""
    lines = [json.loads(line) for line in (folder / "out" / "results.jsonl").read_text().splitlines()]
    failed = [pathlib.Path(line["mesh"]).stem for line in lines if line["status"] == "failed"]
    wrong = [] if len(lines) == count else [f"{len(lines)} lines"]
    if failed != [f"damaged{i}" for i in range(DAMAGED)]:
        wrong.append(f"failed: {failed}")
    for line in lines:
        for output in line.get("outputs", []) if line["status"] == "done" else []:
            path = pathlib.Path(output["path"])
            alone = folder / "single" / path.name
            if path.name.endswith(".nii.gz") and path.read_bytes() != alone.read_bytes():
                wrong.append(path.name)
    return wrong


def main():
    parser = table_parser(__doc__, "tool")
    parser.add_argument("--meshes", type=int, default=500)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--memory", default="1G")
    parser.add_argument("--large", type=int, default=10_000_000, help="triangles of the mesh larger than the memory")
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--folder", type=pathlib.Path)
    arguments = parser.parse_args()
    tool = str(pathlib.Path(arguments.tool).resolve())
    with tempfile.TemporaryDirectory(dir=arguments.folder) as name:
        folder = pathlib.Path(name)
        make_meshes(tool, folder, arguments.meshes, arguments.large)
        runs = {"single runs, one after the other": lambda: slice_one_by_one(tool, folder, arguments.memory),
                "batch, 1 job": lambda: slice_batch(tool, folder, 1, arguments.memory),
                f"batch, {arguments.jobs} jobs": lambda: slice_batch(tool, folder, arguments.jobs, arguments.memory)}  # fmt: skip
        times = {what: [] for what in runs}
        for _ in range(arguments.rounds):
            for what, work in runs.items():
                now = timed(work)
                times[what].append(now)
                print(f"{what}: {now[0]:.1f} s, {now[1]:.1f} s of processors, load {os.getloadavg()[0]:.1f}", file=sys.stderr)
        wrong = wrong_results(folder, arguments.meshes)
    single, one, several = times.values()
    gain = statistics.median(a[0] / b[0] for a, b in zip(one, several))
    cost = statistics.median(b[1] / a[1] for a, b in zip(single, several))
    medians = {what: map(statistics.median, zip(*rounds)) for what, rounds in times.items()}
    lines = ["| run | s | s of processors |", "|---|---|---|"]
    lines += [f"| {what} | {wall:.1f} | {processor:.1f} |" for what, (wall, processor) in medians.items()]
    lines += ["", "| bar | measured |", "|---|---|",
              f"| throughput of {arguments.jobs} jobs over one, at least {THROUGHPUT_BAR} | {mark_least(f'{gain:.2f}', gain, THROUGHPUT_BAR)[0]} |",
              f"| processor time over the single runs', at most {PROCESSOR_BAR} | {mark(f'{cost:.3f}', cost, PROCESSOR_BAR)[0]} |"]  # fmt: skip
    show(arguments.readme, "batch", lines)
    if wrong:
        print("wrong results: " + "; ".join(wrong[:10]))
    return 0 if not wrong and gain >= THROUGHPUT_BAR and cost <= PROCESSOR_BAR else 1


if __name__ == "__main__":
    sys.exit(main())
