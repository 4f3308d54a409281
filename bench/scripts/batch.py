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
import shutil
import statistics
import sys
import tempfile

from readme_table import compare, markdown_table, run, usage_of

THROUGHPUT_BAR, PROCESSOR_BAR = 1.8, 1.10
DISTINCT, LEAST, MOST = 25, 10_000, 2_000_000
DAMAGED = [f"damaged{i}" for i in range(3)]
LIKE = ["--like", "like.nii.gz", "--frame", "lps"]


def make_meshes(tool, folder, count, large):
    meshes = folder / "meshes"
    meshes.mkdir()
    for i in range(DISTINCT):
        triangles = round(LEAST * (MOST / LEAST) ** (i / (DISTINCT - 1)))
        shape = ["bone", "bone", "torus", "sphere"][i % 4]
        run(tool, "make", shape, "--triangles", str(triangles), "--height", "100", "-o", folder / f"made{i}.stl")
    for i in range(count - len(DAMAGED) - 1):
        os.link(folder / f"made{i % DISTINCT}.stl", meshes / f"mesh{i:03}.stl")
    for i, name in enumerate(DAMAGED):
        (meshes / f"{name}.stl").write_bytes((folder / f"made{i}.stl").read_bytes()[: 84 + 50 * 1000 + 17])
    run(tool, "make", "bone", "--triangles", str(large), "--height", "100", "-o", meshes / "large.stl")
    run(tool, "slice", folder / "made3.stl", "--spacing", "1,1,1", "--frame", "lps", "-o", folder / "like.nii.gz")


def slice_one_by_one(tool, folder, memory):
    empty(folder / "single")
    for mesh in sorted((folder / "meshes").iterdir()):
        budget = ["--memory", memory] if mesh.stem == "large" else []
        yield usage_of(tool, "slice", mesh, "--threads", "1", *LIKE, "-o", f"single/{mesh.stem}.nii.gz", *budget, may_fail=True, cwd=folder)


def slice_batch(tool, folder, memory, jobs):
    empty(folder / "out")
    yield usage_of(tool, "batch", "meshes", *LIKE, "-o", "out/{stem}.nii.gz", "--jobs", str(jobs), "--memory", memory, "--progress", "never",
                   may_fail=True, cwd=folder)


def seconds_of(usages):
    """Wall and processor seconds of all programs."""
    usages = list(usages)
    return sum(usage.wall_s for usage in usages), sum(usage.processor_s for usage in usages)


def empty(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()


def wrong_results(folder, count):
    """What differs from the single runs, or is not as it should be."""
    lines = [json.loads(line) for line in (folder / "out" / "results.jsonl").read_text().splitlines()]
    failed = [pathlib.Path(line["mesh"]).stem for line in lines if line["status"] == "failed"]
    wrong = [] if len(lines) == count else [f"{len(lines)} lines"]
    wrong += [] if failed == DAMAGED else [f"failed: {failed}"]
    masks = list((folder / "out").glob("*.nii.gz"))
    wrong += [] if len(masks) == count - len(DAMAGED) else [f"{len(masks)} masks"]
    return wrong + [mask.name for mask in masks if mask.read_bytes() != (folder / "single" / mask.name).read_bytes()]


def tables(arguments, bars):
    with tempfile.TemporaryDirectory(dir=arguments.folder or None) as name:
        tool, folder = arguments.tool, pathlib.Path(name)
        make_meshes(tool, folder, arguments.meshes, arguments.large)
        times = {"single runs, one after the other": [], "batch, 1 job": [], f"batch, {arguments.jobs} jobs": []}
        for _ in range(arguments.rounds):
            works = (slice_one_by_one(tool, folder, arguments.memory), slice_batch(tool, folder, arguments.memory, 1),
                     slice_batch(tool, folder, arguments.memory, arguments.jobs))
            for what, work in zip(times, works):
                times[what].append(seconds_of(work))
                print(f"{what}: {times[what][-1]} s and s of processors, load {os.getloadavg()[0]:.1f}", file=sys.stderr)
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
