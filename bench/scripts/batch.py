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
import sys
import tempfile
import time

from readme_table import compare, markdown_table, run

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
    return ["--like", folder / "like.nii.gz", "--frame", "lps"]


def make_meshes(tool, folder, count, large):
    meshes = folder / "meshes"
    meshes.mkdir(parents=True)
    for i in range(DISTINCT):
        triangles = round(LEAST * (MOST / LEAST) ** (i / (DISTINCT - 1)))
        shape = ["bone", "bone", "torus", "sphere"][i % 4]
        run(tool, "make", shape, "--triangles", str(triangles), "--height", "100", "-o", folder / f"made{i}.stl")
    for i in range(count - DAMAGED - 1):
        os.link(folder / f"made{i % DISTINCT}.stl", meshes / f"mesh{i:03}.stl")
    for i in range(DAMAGED):
        (meshes / f"damaged{i}.stl").write_bytes((folder / f"made{i}.stl").read_bytes()[: 84 + 50 * 1000 + 17])
    run(tool, "make", "bone", "--triangles", str(large), "--height", "100", "-o", meshes / "large.stl")
    run(tool, "slice", folder / "made3.stl", "--spacing", "1,1,1", "--frame", "lps", "-o", folder / "like.nii.gz")


def emptied(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    return folder


def slice_one_by_one(tool, folder, memory):
    out = emptied(folder / "single")
    for mesh in sorted((folder / "meshes").iterdir()):
        budget = ["--memory", memory] if mesh.stem == "large" else []
        run(tool, "slice", mesh, "--threads", "1", *options(folder), "-o", out / f"{mesh.stem}.nii.gz", *budget, may_fail=True)


def slice_batch(tool, folder, jobs, memory):
    run(tool, "batch", folder / "meshes", *options(folder), "-o", emptied(folder / "out") / "{stem}.nii.gz", "--jobs", str(jobs),
        "--memory", memory, "--progress", "never", may_fail=True)


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


def tables(arguments, bars):
    with tempfile.TemporaryDirectory(dir=arguments.folder or None) as name:
        tool, folder = arguments.tool, pathlib.Path(name)
        make_meshes(tool, folder, arguments.meshes, arguments.large)
        works = {"single runs, one after the other": lambda: slice_one_by_one(tool, folder, arguments.memory),
                 "batch, 1 job": lambda: slice_batch(tool, folder, 1, arguments.memory),
                 f"batch, {arguments.jobs} jobs": lambda: slice_batch(tool, folder, arguments.jobs, arguments.memory)}  # fmt: skip
        times = {what: [] for what in works}
        for _ in range(arguments.rounds):
            for what, work in works.items():
                now = timed(work)
                times[what].append(now)
                print(f"{what}: {now[0]:.1f} s, {now[1]:.1f} s of processors, load {os.getloadavg()[0]:.1f}", file=sys.stderr)
        wrong = wrong_results(folder, arguments.meshes)
    single, one, several = times.values()
    gain = statistics.median(a[0] / b[0] for a, b in zip(one, several))
    cost = statistics.median(b[1] / a[1] for a, b in zip(single, several))
    rows = [[f"throughput of {arguments.jobs} jobs over one, at least {THROUGHPUT_BAR}", bars.least(f"{gain:.2f}", gain, THROUGHPUT_BAR)],
            [f"processor time over the single runs', at most {PROCESSOR_BAR}", bars.most(f"{cost:.3f}", cost, PROCESSOR_BAR)]]
    medians = [[what, *(f"{statistics.median(each):.1f}" for each in zip(*rounds))] for what, rounds in times.items()]
    if wrong:
        bars.met = False
        print("wrong results: " + "; ".join(wrong[:10]), file=sys.stderr)
    return [markdown_table(["run", "s", "s of processors"], medians), markdown_table(["bar", "measured"], rows)]


if __name__ == "__main__":
    # `large`: triangles of the mesh larger than the memory
    sys.exit(compare(__doc__, "batch", tables, "tool", meshes=500, jobs=2, memory="1G", large=10_000_000, rounds=1, folder=""))
