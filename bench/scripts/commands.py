#!/usr/bin/python3
"""Measures whole commands of the tool. Prints tables; with --readme bench/README.md it also replaces those between the markers there.

    commands.py report LAMELLA NAME=MESH...         slices, the report and `check` over the slice of an earlier state, without -o
    commands.py memory LAMELLA NAME=MESH...         slicing within a budget of memory, and --giant NAME=MESH within 900 MB
    commands.py batch LAMELLA                       what a batch gains from a second processor, and costs beside single runs
    commands.py batch-memory LAMELLA                bytes of file and of peak memory a triangle, by format, which a batch estimates

Files are warm, as the first round is not counted. Peak memory is the resident memory of the process; files are read into buffers of
its own, not mapped, so that no page of the page cache counts. Needs the package time, and batch-memory numpy. The exit status is 1 if a
bar is not met.
"""

import argparse
import gzip
import json
import os
import pathlib
import shutil
import statistics
import sys
import tempfile

from readme_table import Bars, in_turn, markdown_table, medians_of, ms_of, replace_table, run, usage_of

LIKE = ["--like", "like.nii.gz", "--frame", "lps"]


def tool_of(commit):
    """The tool of that state, built in build/COMMIT."""
    folder = pathlib.Path("build", commit)
    if not folder.exists():
        run("git", "clone", "--quiet", ".", folder)
        run("git", "-C", folder, "checkout", "--quiet", commit)
        run("cmake", "-S", folder, "-B", folder / "build", "-DCMAKE_BUILD_TYPE=Release", "-DLAMELLA_BUILD_TESTS=OFF")
    run("cmake", "--build", folder / "build", "--parallel", str(os.cpu_count()), "--target", "lamella_cli")
    return folder / "build/tools/lamella"


def table_of_report(arguments, bars):
    """The median of five rounds counts. That state's rule was `contours`, and today's is `non-zero`."""
    rows, old = [], tool_of("f8b4f46b")
    for name, mesh in arguments.meshes:
        work = ["slice", "--layer-height", "0.032", mesh]
        plain = [arguments.tool, *work, "--fill-rule", "contours"]
        commands = {"old": [old, *work], "plain": plain, "filled": [arguments.tool, *work], "report": [*plain, "--report", "/dev/null"],
                    "check": [arguments.tool, "check", mesh]}
        ms = medians_of({what: lambda command=command: ms_of(lambda: run(*command)) for what, command in commands.items()}, 5)
        rows.append([name, f"{ms['old']:.0f} ms"])
        for what, most in (("plain", 1.03), ("filled", None), ("report", 2.0), ("check", 4.0)):
            rows[-1].append(bars.most(f"{ms[what] / ms['old']:.2f}", ms[what] / ms["old"], most))
    heads = ["mesh", "slice of f8b4f46", "slice, `--fill-rule contours` (at most 1, with 3 % for noise)", "slice", "the first with `--report` (at most 2)",
             "`check` (at most 4)"]
    return [markdown_table(heads, rows)]


def read_twice(path):
    """By one thread, 8 MB at a time."""
    buffer = bytearray(8 << 20)
    for _ in range(2):
        with open(path, "rb", buffering=0) as file:
            while file.readinto(buffer):
                pass


def lines_of(usage):
    return dict(line.split(maxsplit=1) for line in usage.text.splitlines())


def least_s(usages):
    return min(usage.wall_s for usage in usages)


def memory_row(name, budget, usages, ratio):
    """The least times, and the last run's memory."""
    ranges = lines_of(usages[-1]).get("ranges", "1 range").split()
    return [name, budget, f"{least_s(usages):.2f} s", ratio, f"{min(usage.processor_s for usage in usages):.2f} s",
            f"{usages[-1].peak_bytes / 1e6:.0f} MB", ranges[0] + (" by a temporary file" if "temporary" in ranges else "")]


def table_of_memory(arguments, bars):
    """Each mesh in memory, and within a half, a tenth and a fiftieth of what that takes, with equal hashes. All take turns."""
    def slicing(mesh, *more):
        return lambda: usage_of(arguments.tool, "slice", mesh, "--layer-height", "0.1", "--progress=never", *more)

    rows = []
    for name, mesh in arguments.meshes:
        whole = slicing(mesh, "--hash")
        budgets = {part: whole().peak_bytes // part for part in (2, 10, 50)}
        within = {part: slicing(mesh, "--hash", "--memory", str(budget)) for part, budget in budgets.items()}
        usages = in_turn({1: whole, **within}, arguments.rounds)
        bars.met = bars.met and len({lines_of(usage)["hash"] for runs in usages.values() for usage in runs}) == 1
        rows.append(memory_row(name, "in memory", usages[1], "1"))
        for part, budget in budgets.items():
            ratio = least_s(usages[part]) / least_s(usages[1])
            text = bars.most(f"{ratio:.2f}", ratio, 1.2 if part == 2 else None)
            rows.append(memory_row("", f"1/{part}: {budget / 1e6:.0f} MB", usages[part], text))
    if arguments.giant:
        name, mesh = arguments.giant.split("=", 1)
        works = {"reads": lambda: ms_of(lambda: read_twice(mesh)) / 1000, "within": slicing(mesh, "--memory", "900000000")}
        found = in_turn(works, arguments.rounds)
        reads_s, ratio = min(found["reads"]), least_s(found["within"]) / min(found["reads"])
        text = bars.most(f"{ratio:.2f}", ratio, 3)
        bars.met = bars.met and found["within"][-1].peak_bytes <= 1_000_000_000
        rows.append(memory_row(name, "900 MB", found["within"], f"{text} of two reads, {reads_s:.2f} s"))
    heads = ["mesh", "budget", "time", "over that in memory (a half: at most 1.2; two reads: at most 3)", "processor time", "peak", "ranges"]
    return [markdown_table(heads, rows)]


DISTINCT, LEAST, MOST, LARGE = 25, 10_000, 2_000_000, 10_000_000  # meshes, and their triangles
DAMAGED = [f"damaged{i}" for i in range(3)]


def make_meshes(arguments, folder):
    """Three of them are damaged, and one is larger than the batch's memory. 25 meshes have 20 names each (hard links), so that all
    files stay in the page cache."""
    meshes = folder / "meshes"
    meshes.mkdir()
    for i in range(DISTINCT):
        triangles = round(LEAST * (MOST / LEAST) ** (i / (DISTINCT - 1)))
        shape = ["bone", "bone", "torus", "sphere"][i % 4]
        run(arguments.tool, "make", shape, "--triangles", str(triangles), "--height", "100", "-o", folder / f"made{i}.stl")
    for i in range(arguments.count - len(DAMAGED) - 1):
        os.link(folder / f"made{i % DISTINCT}.stl", meshes / f"mesh{i:03}.stl")
    for i, name in enumerate(DAMAGED):
        (meshes / f"{name}.stl").write_bytes((folder / f"made{i}.stl").read_bytes()[: 84 + 50 * 1000 + 17])
    run(arguments.tool, "make", "bone", "--triangles", str(LARGE), "--height", "100", "-o", meshes / "large.stl")
    run(arguments.tool, "slice", folder / "made3.stl", "--spacing", "1,1,1", "--frame", "lps", "-o", folder / "like.nii.gz")


def seconds_of(usages):
    """Wall and processor seconds of all programs."""
    usages = list(usages)
    return sum(usage.wall_s for usage in usages), sum(usage.processor_s for usage in usages)


def slice_one_by_one(tool, folder):
    for mesh in sorted((folder / "meshes").iterdir()):
        budget = ["--memory", "1G"] if mesh.stem == "large" else []
        yield usage_of(tool, "slice", mesh, "--threads", "1", *LIKE, "-o", f"single/{mesh.stem}.nii.gz", *budget, may_fail=True, cwd=folder)


def slice_batch(tool, folder, jobs):
    shutil.rmtree(folder / "out", ignore_errors=True)
    (folder / "out").mkdir()
    yield usage_of(tool, "batch", "meshes", *LIKE, "-o", "out/{stem}.nii.gz", "--jobs", str(jobs), "--memory", "1G", "--progress", "never",
                   may_fail=True, cwd=folder)


def wrong_results(folder, count):
    """What differs from the single runs, or is not as it should be."""
    lines = [json.loads(line) for line in (folder / "out" / "results.jsonl").read_text().splitlines()]
    failed = [pathlib.Path(line["mesh"]).stem for line in lines if line["status"] == "failed"]
    masks = list((folder / "out").glob("*.nii.gz"))
    wrong = [] if (len(lines), failed, len(masks)) == (count, DAMAGED, count - len(DAMAGED)) else [
        f"{len(lines)} lines, {len(masks)} masks, failed: {failed}"]
    return wrong + [mask.name for mask in masks if mask.read_bytes() != (folder / "single" / mask.name).read_bytes()]


def tables_of_batch(arguments, bars):
    """500 meshes of 10 thousand to 2 million triangles become masks of 1 mm. Ratios are those within a round, since a machine changes
    its speed between rounds."""
    times = {"single runs, one after the other": [], "batch, 1 job": [], "batch, 2 jobs": []}
    with tempfile.TemporaryDirectory(dir=arguments.folder or None) as name:
        folder = pathlib.Path(name)
        (folder / "single").mkdir()
        make_meshes(arguments, folder)
        for _ in range(arguments.rounds):
            works = slice_one_by_one(arguments.tool, folder), *(slice_batch(arguments.tool, folder, jobs) for jobs in (1, 2))
            for what, work in zip(times, works):
                times[what].append(seconds_of(work))
                print(f"{what}: {times[what][-1]} s and s of processors, load {os.getloadavg()[0]:.1f}", file=sys.stderr)
        wrong = wrong_results(folder, arguments.count)
    single, one, two = times.values()
    gain = statistics.median(a[0] / b[0] for a, b in zip(one, two))
    cost = statistics.median(b[1] / a[1] for a, b in zip(single, two))
    rows = [["throughput of 2 jobs over one, at least 1.8", bars.least(f"{gain:.2f}", gain, 1.8)],
            ["processor time over the single runs', at most 1.1", bars.most(f"{cost:.3f}", cost, 1.1)]]
    medians = [[what, *(f"{statistics.median(each):.1f}" for each in zip(*rounds))] for what, rounds in times.items()]
    if wrong:
        bars.met = False
        print("wrong results: " + "; ".join(wrong[:10]), file=sys.stderr)
    return [markdown_table(["run", "s", "s of processors"], medians), markdown_table(["bar", "measured"], rows)]


WORK = {
    "SVG, 0.2 mm": ["--layer-height", "0.2", "-o", "out.svg"],
    "SVG, 0.05 mm": ["--layer-height", "0.05", "-o", "out.svg"],
    "mask and table, 0.5 mm": ["--spacing", "0.5,0.5,0.5", "--frame", "lps", "-o", "out.nii.gz", "-o", "out.csv"],
}
# By the names in the table: those of mesh_formats.py.
FORMATS = {"text.stl": "stl_ascii.stl", "text.obj": "obj.obj", "text.off": "off.off", "text.ply": "ply_ascii.ply", "text.vtk": "vtk_ascii.vtk",
           "text.vtp": "vtp_ascii.vtp", "binary.stl": "stl_binary.stl", "binary.ply": "ply_little_endian.ply", "binary.vtk": "vtk_binary.vtk",
           "raw.vtp": "vtp_raw.vtp", "zip.3mf": "3mf.3mf"}


def write_formats(stl, folder):
    """Files of the same mesh, and those that are not packed by themselves packed by gzip."""
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
    import mesh_formats

    folder.mkdir()
    mesh = mesh_formats.Mesh(stl)
    mesh_formats.write(mesh_formats.vtp_zlib(mesh, "raw"), folder / "zlib.vtp")
    for name, form in FORMATS.items():
        mesh_formats.write(mesh_formats.FORMATS[form](mesh), folder / name)
        if name != "zip.3mf":
            (folder / (name + ".gz")).write_bytes(gzip.compress((folder / name).read_bytes(), 6))


def tables_of_batch_memory(arguments, _bars):
    """The same bone of 100 mm in every format. Peaks are less that of the smallest mesh."""
    def peak_bytes(mesh, work):
        return usage_of(arguments.tool, "slice", mesh, "--threads", "1", *work, cwd=folder).peak_bytes

    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for path, triangles in (("bone.stl", arguments.triangles), ("bare.stl", 1000)):
            run(arguments.tool, "make", "bone", "--triangles", str(triangles), "--height", "100", "-o", folder / path)
        bare = {what: peak_bytes("bare.stl", work) for what, work in WORK.items()}
        triangles = ((folder / "bone.stl").stat().st_size - 84) // 50
        write_formats(folder / "bone.stl", folder / "files")
        for file in sorted((folder / "files").iterdir()):
            peaks = [f"{(peak_bytes(file, work) - bare[what]) / triangles:.0f}" for what, work in WORK.items()]
            rows.append([file.name, f"{file.stat().st_size / triangles:.1f}", *peaks])
    return [markdown_table(["format", "bytes of file a triangle", *WORK], rows),
            f"Bare process: {max(bare.values()) / 1e6:.0f} MB; {triangles:,} triangles."]


# By name of the marks in the page: what makes the tables, and its options with their defaults.
TABLES = {"report": (table_of_report, {}), "memory": (table_of_memory, {"giant": "", "rounds": 3}),
          "batch": (tables_of_batch, {"count": 500, "rounds": 1, "folder": ""}),
          "batch-memory": (tables_of_batch_memory, {"triangles": 1_000_000})}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ways = parser.add_subparsers(dest="name", required=True)
    for name, (_, options) in TABLES.items():
        way = ways.add_parser(name)
        way.add_argument("tool", type=os.path.abspath)
        way.add_argument("meshes", nargs="*", metavar="NAME=MESH", type=lambda word: tuple(word.split("=", 1)))
        way.add_argument("--readme")
        for option, default in options.items():
            way.add_argument("--" + option, type=type(default), default=default)
    arguments, bars = parser.parse_args(), Bars()
    text = "\n\n".join(TABLES[arguments.name][0](arguments, bars)) + "\n"
    print(text, end="")
    if arguments.readme:
        replace_table(arguments.readme, arguments.name, text)
    return 0 if bars.met else 1


if __name__ == "__main__":
    sys.exit(main())
