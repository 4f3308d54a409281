#!/usr/bin/env python3
"""Reduces a run of the benchmarks to the medians in summary.json.

Usage: summarise.py RUN_FOLDER RESULTS_FOLDER [--add]

Reads bench.json, partition.json and peaks.json from RUN_FOLDER. With --add, medians of earlier runs on the same machine are kept
unless this run measured them again."""
import json
import os
import pathlib
import re
import statistics
import sys

from partition import accounted_for, allowed_speedups
from readme_table import field

MACHINE = ("processor", "num_cpus", "memory", "compiler", "flags", "allocator", "pinning", "transparent_huge_pages", "sizes",
           "thread_counts")
NOT_COUNTERS = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions", "repetition_index",
                "iterations", "real_time", "cpu_time", "time_unit", "threads", "error_occurred", "error_message"}


def rounded(value):
    """To eight digits, enough for tables to equal those made from the single runs."""
    return float(f"{value:.8g}")


def median(runs, name):
    values = [run[name] for run in runs if name in run]
    return rounded(statistics.median(values)) if values else None


def key_of(row):
    return row["what"], row["case"], row["variant"], row["threads"]


def medians(runs):
    """One row for all repetitions of a benchmark, without those that failed."""
    repetitions = {}
    for run in runs:
        repetitions.setdefault(tuple(run["name"].split("/")[:4]), []).append(run)
    for (what, case, variant, threads), all_runs in repetitions.items():
        good = [run for run in all_runs if "error_message" not in run]
        names = dict.fromkeys(name for run in good for name, value in run.items()
                              if name not in NOT_COUNTERS and isinstance(value, (int, float)))
        yield {"what": what, "case": case, "variant": variant, "threads": int(re.sub(r"\D", "", threads)),
               "ms": median(good, "real_time"), "counters": {name: median(good, name) for name in names},
               "errors": list(dict.fromkeys(run["error_message"] for run in all_runs if "error_message" in run))}


def added(earlier, summary):
    """The new summary, completed by the earlier one's entries that it lacks."""
    other = [name for name in MACHINE if earlier["context"][name] != summary["context"][name]]
    if other:
        raise SystemExit("error: the earlier medians come from a different " + ", ".join(other) + "; run all of bench/run.sh")
    rows = {key_of(row): row for row in earlier["medians"] + summary["medians"]}
    dates = dict.fromkeys(earlier["context"]["dates"] + summary["context"]["dates"])
    measured_again = {peak["name"] for peak in summary["peaks"]}
    peaks = [peak for peak in earlier["peaks"] if peak["name"] not in measured_again] + summary["peaks"]
    return {"context": summary["context"] | {"dates": list(dates)}, "partition": earlier["partition"] | summary["partition"],
            "peaks": peaks, "medians": list(rows.values())}


def machine():
    """What the benchmarks ran on, as this script does."""
    pages = pathlib.Path("/sys/kernel/mm/transparent_hugepage/enabled")
    cores = ",".join(map(str, sorted(os.sched_getaffinity(0))))
    return {"processor": field("/proc/cpuinfo", "model name"), "memory": field("/proc/meminfo", "MemTotal"),
            "pinning": f"process on cores {cores}, threads not pinned one by one",
            "transparent_huge_pages": pages.read_text().strip() if pages.exists() else "unknown"}


def read_summary(folder):
    """The summary of a run."""
    bench, partition = (json.loads((folder / name).read_text()) for name in ("bench.json", "partition.json"))
    found = bench["context"] | machine()
    context = {name: found.get(name, "unknown") for name in MACHINE} | {"dates": [bench["context"]["date"]]}
    allowed = {name: {"speedups": [[threads, rounded(speedup)] for threads, speedup in allowed_speedups(case)],
                      "accounted_for": rounded(accounted_for(case))} for name, case in partition.items()}
    return {"context": context, "partition": allowed,
            "peaks": [json.loads(line) for line in (folder / "peaks.json").read_text().splitlines()],
            "medians": list(medians(run for run in bench["benchmarks"] if run.get("run_type") != "aggregate"))}


def text_of(summary):
    """JSON with one row a line, so that a diff shows what was measured again."""
    parts = []
    for name, part in summary.items():
        keyed = isinstance(part, dict)
        rows = [f"{json.dumps(key)}: {json.dumps(part[key])}" if keyed else json.dumps(key) for key in part]
        begin, end = "{}" if keyed else "[]"
        parts.append(f' "{name}": {begin}\n' + ",\n".join("  " + row for row in rows) + f"\n {end}")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main():
    path = pathlib.Path(sys.argv[2]) / "summary.json"
    summary = read_summary(pathlib.Path(sys.argv[1]))
    if "--add" in sys.argv[3:] and path.exists():
        summary = added(json.loads(path.read_text()), summary)
    path.write_text(text_of(summary))


if __name__ == "__main__":
    main()
