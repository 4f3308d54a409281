#!/usr/bin/env python3
"""Reduces a run of the benchmarks to the medians in summary.json.

Usage: summarise.py RUN_FOLDER RESULTS_FOLDER [--add]

Reads bench.json, partition.json and peaks.json from RUN_FOLDER, and writes every single measurement to runs.csv there. With
--add, medians of earlier runs on the same machine are kept unless this run measured them again."""
import csv
import json
import math
import os
import re
import statistics
import sys
from typing import NamedTuple, Optional

from partition import accounted_for, allowed_speedups

MACHINE = ("processor", "num_cpus", "memory", "compiler", "flags", "allocator", "pinning", "transparent_huge_pages", "sizes",
           "thread_counts")
NOT_COUNTERS = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions", "repetition_index",
                "iterations", "real_time", "cpu_time", "time_unit", "threads", "error_occurred", "error_message"}


class Run(NamedTuple):
    what: str
    case: str
    variant: str
    threads: int
    repetition: int
    ms: float
    error: Optional[str]
    counters: dict


def run_of(entry):
    what, case, variant, threads = entry["name"].split("/")[:4]
    counters = {key: value for key, value in entry.items() if key not in NOT_COUNTERS and isinstance(value, (int, float))}
    return Run(what, case, variant, int(re.sub(r"\D", "", threads)), entry.get("repetition_index", 0),
               entry.get("real_time", math.nan), entry.get("error_message"), counters)


def write_runs(path, runs):
    counters = sorted({name for run in runs for name in run.counters})
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["what", "case", "variant", "threads", "repetition", "ms", "error"] + counters)
        writer.writerows([*run[:6], run.error or ""] + [run.counters.get(name, "") for name in counters] for run in runs)


def median(values):
    """Rounds to eight digits, enough for tables to equal those made from the single runs."""
    return float(f"{statistics.median(values):.8g}") if values else None


def medians(runs):
    """One row for all repetitions of a benchmark, without those that failed."""
    repetitions = {}
    for run in runs:
        repetitions.setdefault(run[:4], []).append(run)
    rows = []
    for (what, case, variant, threads), all_runs in repetitions.items():
        good = [run for run in all_runs if run.error is None]
        names = dict.fromkeys(name for run in good for name in run.counters)
        rows.append({
            "what": what, "case": case, "variant": variant, "threads": threads, "ms": median([run.ms for run in good]),
            "counters": {name: median([run.counters[name] for run in good if name in run.counters]) for name in names},
            "errors": list(dict.fromkeys(run.error for run in all_runs if run.error is not None)),
        })
    return rows


def key_of(row):
    return row["what"], row["case"], row["variant"], row["threads"]


def added(earlier, summary):
    """The new summary, completed by the earlier one's entries that it lacks."""
    other = [name for name in MACHINE if earlier["context"][name] != summary["context"][name]]
    if other:
        raise SystemExit("error: the earlier medians come from a different " + ", ".join(other) + "; run all of bench/run.sh")
    rows = {key_of(row): row for row in earlier["medians"]} | {key_of(row): row for row in summary["medians"]}
    dates = dict.fromkeys(earlier["context"]["dates"] + summary["context"]["dates"])
    context = summary["context"] | {"dates": list(dates)}
    measured_again = {peak["name"] for peak in summary["peaks"]}
    peaks = [peak for peak in earlier["peaks"] if peak["name"] not in measured_again] + summary["peaks"]
    return {"context": context, "partition": earlier["partition"] | summary["partition"], "peaks": peaks,
            "medians": list(rows.values())}


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def read_summary(folder):
    """The summary of a run, and the run's measurements."""
    bench, partition, peaks = (read_json(os.path.join(folder, name)) for name in ("bench.json", "partition.json", "peaks.json"))
    runs = [run_of(entry) for entry in bench["benchmarks"] if entry.get("run_type") != "aggregate"]
    context = {name: bench["context"].get(name, "unknown") for name in MACHINE} | {"dates": [bench["context"]["date"]]}
    allowed = {name: {"speedups": [[threads, float(f"{speedup:.8g}")] for threads, speedup in allowed_speedups(case)],
                      "accounted_for": float(f"{accounted_for(case):.8g}")} for name, case in partition.items()}
    return {"context": context, "partition": allowed, "peaks": peaks, "medians": medians(runs)}, runs


def write_summary(path, summary):
    """JSON with one row a line, so that a diff shows what was measured again."""
    def lines(items):
        return ",\n".join("  " + item for item in items)

    def fields(values):
        return "{\n" + lines(f"{json.dumps(key)}: {json.dumps(value)}" for key, value in values.items()) + "\n }"

    def rows(values):
        return "[\n" + lines(json.dumps(value) for value in values) + "\n ]"

    parts = {"context": fields(summary["context"]), "partition": fields(summary["partition"]),
             "peaks": rows(summary["peaks"]), "medians": rows(summary["medians"])}
    with open(path, "w", encoding="utf-8") as file:
        file.write("{\n" + ",\n".join(f' "{name}": {part}' for name, part in parts.items()) + "\n}\n")


def main():
    run_folder, results_folder = sys.argv[1:3]
    summary, runs = read_summary(run_folder)
    write_runs(os.path.join(run_folder, "runs.csv"), runs)
    path = os.path.join(results_folder, "summary.json")
    if "--add" in sys.argv[3:] and os.path.exists(path):
        summary = added(read_json(path), summary)
    write_summary(path, summary)


if __name__ == "__main__":
    main()
