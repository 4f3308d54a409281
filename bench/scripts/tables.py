#!/usr/bin/python3
"""Makes every table of bench/README.md that bench/run.sh measures, and scaling.svg, from a folder's summary.json.

    tables.py FOLDER [README]

Prints the table of bars; with README, puts all tables whose benchmarks have been run between its marks. Exit status 1 if a bar is not
met, 2 if a benchmark failed."""
import pathlib
import statistics
import sys

from drawing import Panel, save
from readme_table import Bars, fitted_exponent, markdown_table, number, ratio, replace_table
from summary import Results

REAL = ("liver", "femur", "brain", "hip_femur", "scan", "scan_shuffled", "figure", "skull")
STAGES = ("measure", "count", "scatter", "sweep", "place", "serial")  # of bench_partition.cpp


def on(threads):
    return f"{threads} thread{'s' * (threads > 1)}"


def hold_ratios(bars, results):
    for case, bar in (("liver", 10), ("figure", 10), ("femur", 12), ("brain", 15), ("scan", 16), ("skull", 18)):
        over = results.figure(f"end_to_end/{case}/warm_swept", 2, "times_limit")
        bars.hold(f"{case}, times the limit, 2 threads", over, "at most", bar)
    for case in results.cases("baseline"):
        seconds, *apart = (results.figure(f"baseline/{case}/topological", 1, key) for key in ("contours_s", "planes_apart", "contours_apart"))
        gain = 0 if any(apart) else ratio(1000 * seconds, results.ms(case, 2))
        bars.hold(f"{case}, times as fast as the authors' later way, 2 threads", gain, "at least", 8)
    for threads in (1, 2):
        over = ratio(results.ms("scan_shuffled", threads), results.ms("scan", threads))
        bars.hold(f"scan shuffled over sorted, {on(threads)}", over, "at most", 1.2)
    for case in results.cases("end_to_end"):
        uniform = case.removesuffix("_irregular")
        for threads in (1, 2) if case != uniform else ():
            over = ratio(results.ms(case, threads), results.ms(uniform, threads))
            bars.hold(f"{uniform}, irregular planes over uniform, {on(threads)}", over, "at most", 1.3)
    for case in results.cases("end_to_end"):
        if "_planes" in case or case in REAL:
            gain = ratio(results.ms(case, 1), results.ms(case, 2))
            bars.hold(f"{case}, speed-up by 2 threads", gain, "at least", 1.5 if "_planes" in case else 1.8)
    for threads in (1, 2):
        names = [f"end_to_end/{case}/warm_swept" for case in results.cases("end_to_end") if case.startswith("linear_")]
        points = [(sum(results.figure(name, threads, key) for key in ("triangles", "planes", "segments")), results.figure(name, threads))
                  for name in names if results.figure(name, threads)]
        bars.hold(f"exponent of time over n + k + m, 10^4 to 10^7 triangles, {on(threads)}", fitted_exponent(points), "at most", 1.05)
    few, many = (results.figure(f"nesting/rings_{count}/series", 1, "contours/s") for count in (10, 10000))
    bars.hold("nesting, time per contour: 10,000 over 10", ratio(few, many), "at most", 2.0)


def hold_reading_and_memory(bars, results):
    for case, variant in results.variants("read"):
        name = f"read/{case}/{variant}"
        if variant == "text":
            bars.hold(f"read {case}, 2 threads", ratio(results.figure(name, 2, "bytes/s"), 1e6), "at least", 500, "MB/s")
        if variant == "binary":
            bars.hold(f"read {case}, share of pread, 2 threads", results.figure(name, 2, "share_of_pread"), "at least", 0.5)
    for case, variant in results.variants("peak"):
        peak, read, crossed, made = (results.figure(f"peak/{case}/{variant}", 2, key)
                                     for key in ("peak_bytes", "input_bytes", "crossed", "result_bytes"))
        planes = variant.removeprefix("bands_")
        cut = "bands by work" if planes == "0" else f"{planes} planes a band"
        bars.hold(f"peak memory, {case}, {cut}, 2 threads", peak / 1e6, "at most", (read + 24 * crossed + made + 32e6) / 1e6, "MB")


def machine_of(results):
    rows = [[name.replace("_", " "), value] for name, value in results.context.items() if name != "sizes"]
    for threads in results.thread_counts:
        for what in ("read", "write"):
            speed = ratio(results.figure("bandwidth/memory/warm", threads, what), 1e9)
            rows.append([f"memory, {what}, {on(threads)}", "-" if speed is None else f"{speed:.1f} GB/s"])
    return markdown_table(["machine", ""], rows)


def times(results):
    """Time by thread count, then speed-up, segments/s and times the limit at the most threads."""
    rows = []
    for case, variant in results.variants("end_to_end"):
        ms = [results.ms(case, threads, variant) for threads in results.thread_counts]
        rate, limit = (results.figure(f"end_to_end/{case}/{variant}", results.thread_counts[-1], key) for key in ("segments/s", "times_limit"))
        rows.append([case, variant, *map(number, (*ms, ratio(ms[0], ms[-1]), ratio(rate, 1e6), limit))])
    heads = [f"ms, {threads} thr." for threads in results.thread_counts]
    return markdown_table(["case", "variant", *heads, f"speed-up, {results.thread_counts[-1]}", "M segments/s", "times the limit"], rows)


def reading(results):
    rows, counts = [], results.thread_counts
    for case, variant in results.variants("read"):
        name = f"read/{case}/{variant}"
        rates = [ratio(results.figure(name, threads, key), 1e6) for key in ("bytes/s", "unpacked_bytes/s") for threads in counts]
        rows.append([case, variant, *map(number, (*rates, results.figure(name, counts[-1], "share_of_pread")))])
    heads = [f"{what}, {threads} thr." for what in ("MB/s", "unpacked") for threads in counts]
    return markdown_table(["format", "as", *heads, "share of pread"], rows)


def nesting(results):
    names = {case: f"nesting/{case}/series" for case in results.cases("nesting")}
    rows = [[case, number(results.figure(name, 1)), number(ratio(1e9, results.figure(name, 1, "contours/s")))] for case, name in names.items()]
    return markdown_table(["layer", "ms", "ns a contour"], rows)


def figures(results, bars):
    for hold in (hold_ratios, hold_reading_and_memory):
        hold(bars, results)
    return "\n\n".join([
        machine_of(results),
        "### Bars", bars.table(),
        "### End to end, in memory and from a file", times(results),
        "### Reading, by format", reading(results),
        "### Nesting on lattices of rings; 1 thread", nesting(results)])


OPERATIONS = {"union": "union", "difference": "difference", "intersection": "intersection", "miter": "offset, miter", "round": "offset, round",
              "walls": "three walls"}
OVER_SLICE = {"non_zero": ("non-zero", 1.25), "closing": ("and closing 0.049 mm", 1.5), "offset": ("and offset 0.2 mm", 3.0),
              "top": ("top surfaces", 2.0), "overhang": ("overhang", 2.0)}


def regions(results, bars):
    slices, beside, gains = [], [], []
    for name, kind in results.variants("regions"):
        if kind == "slices":
            plain, *times = (results.figure(f"regions/{name}/slices", 2, key) for key in ("plain", *OVER_SLICE))
            slices.append([name, f"{plain:.1f} ms", *(f"{ms:.1f} ms: " + bars.most(f"{ms / plain:.2f}", ms / plain, bar)
                                                      for ms, (_, bar) in zip(times, OVER_SLICE.values()))])
            continue
        pairs = [[results.figure(f"regions/{name}/operations", 1, prefix + key) for prefix in ("", "library_")] for key in OPERATIONS]
        gains += [theirs / own for own, theirs in pairs]
        beside.append([name, *(f"{own:.1f} ms: " + bars.least(f"{theirs / own:.1f}", theirs / own, 3.0) for own, theirs in pairs)])
    squares = ratio(*(results.figure("regions/checkerboard_100000/operations", 1, key) for key in ("contours", "union")))
    return "\n\n".join([
        markdown_table(["mesh", "slice", *(f"{head} (at most {bar})" for head, bar in OVER_SLICE.values())], slices),
        markdown_table(["layers", *OPERATIONS.values()], beside),
        f"Times as fast as the library, the median of all: {bars.least(f'{statistics.median(gains):.1f}', statistics.median(gains), 10)}. "
        f"Squares a millisecond of the checkerboard: {bars.least(f'{squares:.0f}', squares, 500)}."])


def hosts(results, bars):
    prepared, small, first = [], [], []
    has_huge_pages = "[never]" not in results.context["transparent_huge_pages"]
    for name in results.cases("first"):
        ms = {key: results.figure(f"host/{name}/prepared", 2, key)
              for key in ("prepare", "bytes", "plane_mesh", "plane_prepared")}
        first_ms, warm_ms, touched, small_faults, made, scratch, page_rate = (
            results.figure(f"first/{name}/slice", 2, key)
            for key in ("real_time", "warm_ms", "touched_bytes", "small_faults", "result_bytes", "scratch_bytes", "fresh_bytes/s"))
        first_over_warm, plane_bar = first_ms / warm_ms, {"femur": 0.1, "brain": 0.3}.get(name)
        prepared.append([name, f"{ms['prepare']:.1f} ms", f"{ms['bytes'] / 1e6:.1f} MB", f"{ms['plane_mesh']:.3f} ms",
                         bars.most(f"{ms['plane_prepared']:.3f} ms", ms["plane_prepared"], plane_bar)])
        first.append([name, f"{warm_ms:.1f} ms", f"{first_ms:.1f} ms",
                      bars.most(f"{first_over_warm:.2f}", first_over_warm, 1.3 if page_rate >= 1e9 else None), f"{page_rate / 1e9:.2f} GB/s",
                      bars.most(f"{touched / (made + scratch):.2f}", touched / (made + scratch), 1.15 if has_huge_pages else None),
                      bars.most(f"{small_faults:.0f}", small_faults, 300 if has_huge_pages else None)])
    for threads in (1, 2):
        kept, blocks, fresh = (results.figure("host/box/small", threads, key) for key in ("kept_us", "blocks", "fresh_us"))
        small.append([on(threads), bars.most(f"{kept:.2f} us", kept, 2), bars.most(f"{blocks:.0f}", blocks, 0), f"{fresh:.1f} us"])
    return "\n\n".join([
        markdown_table(["mesh", "`prepare()`", "memory", "one plane of the mesh", "prepared (femur at most 0.1, brain 0.3 ms)"],
                       prepared),
        markdown_table(["12 triangles, one plane", "kept `Slicer` (at most 2 us)", "blocks taken (at most 0)", "without one"], small),
        markdown_table(["mesh", "warm slice", "first slice of a process", "over the warm one (at most 1.3 where pages come at 1 GB/s)",
                        "fresh pages of 4 KB", "touched first, over result and scratch (at most 1.15)", "pages of 4 KB (at most 300)"], first)])


def masks(results, bars):
    """Where others use the machine, wall times say little: the raster meets its bar also if it would with all its work on free cores."""
    rows = []
    for way, words in {"raster": "contours to voxels in memory", "nii": "`write_mask()`, .nii", "nrrd": "`write_mask()`, .nrrd (gzip)"}.items():
        for threads in (1, 2):
            ms, processor_ms, rate = (results.figure(f"mask/bone/{way}", threads, key) for key in ("real_time", "cpu_time", "voxels/s"))
            by_work = rate * ms / processor_ms * threads
            best = bars.least(f"{by_work / 1e9:.2f}", max(rate, by_work), 1e9 if way == "raster" and threads == 2 else None)
            rows.append([words, threads, f"{ms:.0f} ms", f"{processor_ms:.0f} ms", f"{rate / 1e9:.2f}", best])
    return markdown_table(["way", "threads", "wall time", "processor time", "G voxels/s", "of processor time"], rows)


def partition(results, bars):
    """The speed-up that bands and shares allow, and where the time of 64 threads goes."""
    held = {**dict.fromkeys(("scan", "figure", "skull"), {64: 45, 128: 80}), "brain": {32: 24}, "liver": {32: 12}}
    gains, times, counts = [], [], (2, 4, 8, 16, 32, 64, 128)
    for case in results.cases("partition"):
        of = {threads: results.figure(f"partition/{case}/modelled", 1, f"speedup_{threads}") for threads in counts}
        share, known = (results.figure(f"partition/{case}/modelled", 1, key) for key in ("serial_share", "accounted_for"))
        beyond = min(of[64], of[128]) / of[32]
        gains.append([case, *(bars.least(number(of[threads]), of[threads], held.get(case, {}).get(threads)) for threads in counts),
                      bars.least(f"{beyond:.2f}", beyond, 1 if case == "liver" else None),
                      bars.most(f"{100 * share:.2f} %", share, 0.003 if case == "scan" else None), f"{known:.2f}"])
        stages = [results.figure(f"partition/{case}/modelled", 1, f"{stage}_64") for stage in STAGES]
        times.append([case, *(number(each) for each in (*stages, sum(stages)))])
    return "\n\n".join([
        markdown_table(["case", *(f"{threads} thr." for threads in counts), "least beyond 32 over that at 32", "serial at 1 thread",
                        "accounted for"], gains),
        markdown_table(["us on 64 threads", *STAGES, "all"], times)])


def cores(results, bars):
    count, rows = int(results.context["cores"]), []
    for case in results.cases("cores"):
        alone, *times, beside = (results.figure(f"cores/{case}/{variant}", count, "warm_ms")
                                 for variant in ("times_1", "times_2", "times_4", "times_8", "neighbour"))
        rows.append([case, f"{alone:.1f} ms", *(bars.most(f"{each / alone:.2f}", each / alone, 1.1) for each in times),
                     bars.most(f"{beside / alone:.2f}", beside / alone, 1.6)])
    heads = [f"{times * count} threads over that (at most 1.1)" for times in (2, 4, 8)]
    return markdown_table(["mesh", f"{on(count)}, {count} cores", *heads, "beside a spinning process (at most 1.6)"], rows)


# By name of the marks: what must have been measured, and the tables.
SECTIONS = {"figures": (["end_to_end"], figures), "regions": (["regions"], regions), "hosts": (["host", "first"], hosts),
            "masks": (["mask"], masks), "partition": (["partition"], partition), "cores": (["cores"], cores)}


def draw_scaling(results, path):
    counts, context = results.thread_counts, results.context
    strong = {case: [(threads, ratio(results.ms(case, 1) / threads, results.ms(case, threads))) for threads in counts]
              for case in (*REAL, "columns_planes1", "columns_planes4", "prism_planes1", "prism_planes4") if results.ms(case, counts[-1])}
    weak = [(threads, ratio(results.ms("weak_1", 1), results.ms(f"weak_{threads}", threads))) for threads in counts]
    save(path, [
        Panel("strong scaling, measured", "threads", "efficiency", strong, [(count, 1) for count in counts], (2, None), 1.2),
        Panel("weak scaling, measured", "threads", "efficiency", {"1 M triangles a thread": [point for point in weak if point[1]]},
              [(count, 1) for count in counts], (2, None), 1.2)],
        heading=f"{context['processor']}, {context['cores']} cores, {context['compiler']}\n{context['flags']}; {context['pinning']}")


def main():
    folder, readme = pathlib.Path(sys.argv[1]), sys.argv[2:]
    results, bars = Results(folder), Bars()
    if results.cases("end_to_end"):
        draw_scaling(results, folder / "scaling.svg")
    failed = {name.split("/")[0] for name, _ in results.errors} - {"end_to_end"}
    for name, (measured, section) in SECTIONS.items():
        if all(results.cases(what) for what in measured) and not failed & set(measured):
            text = section(results, bars)
            for page in readme:
                replace_table(page, name, text + "\n")
            print(f"{text}\n")
    if "quick" in results.context["sizes"]:
        print("Quick sizes: these figures mean nothing.\n")
    for name, error in results.errors:
        print(f"failed: {name}: {error}")
    return 2 if results.errors else 0 if bars.met else 1


if __name__ == "__main__":
    sys.exit(main())
