#!/usr/bin/python3
"""Measures slices on more and more pinned cores, and writes a page that holds all figures and the plots.

    scaling.py FOLDER PAGES [OPTION...]

FOLDER has the summary.json of an unpinned run, OPTIONs are those of lamella_bench. `compact` fills one socket after the other, `spread`
takes cores at equal distances. The second threads of cores come last, all of them at once."""
import base64
import collections
import json
import os
import pathlib
import platform
import re
import subprocess
import sys

import tables
from readme_table import Bars
from summary import Results, context_of, medians

CASES = "(instead_of_)?(liver|femur)|brain|scan|figure|skull"


def processors():
    """Those that this process may use: one of each core, socket after socket, and the others. Containers may hide what is read here."""
    def read(cpu, name, otherwise):
        path = pathlib.Path(f"/sys/devices/system/cpu/cpu{cpu}/topology/{name}")
        return int(path.read_text()) if path.exists() else otherwise

    seen, found = collections.Counter(), []
    for cpu in sorted(os.sched_getaffinity(0)):
        core = read(cpu, "physical_package_id", 0), read(cpu, "core_id", cpu)
        found.append((seen[core], core[0], cpu))
        seen[core] += 1
    return [[cpu for thread, _, cpu in sorted(found) if (thread > 0) == others] for others in (False, True)]


def lists(placement):
    """Of 1, 2, 4, ..., all cores, and all threads of cores."""
    cores, others = processors()
    counts = sorted({*(1 << i for i in range(len(cores).bit_length())), len(cores)})
    step = {"compact": lambda _: 1, "spread": lambda count: len(cores) / count}[placement]
    found = [[cores[int(i * step(count))] for i in range(count)] for count in counts]
    return found + [cores + others] if others else found


def measure(cpu_lists, folder, options):
    rows = []
    for cpus in cpu_lists:
        wanted = f"^(bandwidth/memory|end_to_end/({CASES}|weak_{len(cpus)}))/warm(_swept)?/threads:{len(cpus)}/"
        subprocess.run(["taskset", "-c", ",".join(map(str, cpus)), "build/bench/lamella_bench", *options, f"--benchmark_filter={wanted}",
                        f"--benchmark_out={folder}/bench.json", "--benchmark_display_aggregates_only=true"], check=True)
        rows += json.loads((folder / "bench.json").read_text())["benchmarks"]
    sizes = "quick" if "--quick" in options else "full"
    context = context_of("build", sizes) | {"pinning": "; ".join(",".join(map(str, cpus)) for cpus in cpu_lists)}
    summary = {"context": context, "medians": list(medians(row for row in rows if row["run_type"] != "aggregate"))}
    (folder / "summary.json").write_text(json.dumps(summary))
    return Results(folder)


def main():
    folder, options = pathlib.Path(sys.argv[1]), sys.argv[3:]
    page = pathlib.Path(sys.argv[2], re.sub(r"[^\w.-]", "_", f"scaling_{platform.node()}.md"))
    unpinned, bars = Results(folder), Bars()
    sections = [f"# Scaling on {platform.node()}", "## What the partition allows", tables.partition(unpinned, bars),
                "## Crowded cores", tables.cores(unpinned, bars)]
    for placement in ("compact", "spread") if lists("spread") != lists("compact") else ("compact",):
        own = folder / placement
        own.mkdir(exist_ok=True)
        results = measure(lists(placement), own, options)
        tables.draw_scaling(results, own / "scaling.svg")
        plot = base64.b64encode((own / "scaling.svg").read_bytes()).decode()
        sections += [f"## Measured, {placement}", tables.machine_of(results), tables.times(results), f"![](data:image/svg+xml;base64,{plot})"]
    page.write_text("\n\n".join(sections) + "\n")
    print(f"Please send {page}")


if __name__ == "__main__":
    main()
