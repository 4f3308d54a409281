#!/usr/bin/env python3
"""Reduces a run of the benchmarks to the medians in summary.json, from which all tables are made.

    summary.py RUN_FOLDER RESULTS_FOLDER [--add]

Reads bench.json and once.jsonl from RUN_FOLDER. With --add, medians of earlier runs on the same machine are kept unless this run
measured them again."""
import json
import math
import os
import pathlib
import statistics
import sys

from readme_table import field

MACHINE = ("processor", "num_cpus", "memory", "compiler", "flags", "allocator", "pinning", "transparent_huge_pages", "sizes",
           "thread_counts")
NOT_FIGURES = {"family_index", "per_family_instance_index", "repetitions", "repetition_index", "iterations", "threads"}


def medians(runs):
    """One row for all repetitions of a benchmark, "what/case/variant/threads:N": medians to eight digits, of those that did not fail."""
    repetitions = {}
    for run in runs:
        repetitions.setdefault("/".join(run["name"].split("/")[:4]), []).append(run)
    for name, all_runs in repetitions.items():
        good = [run for run in all_runs if "error_message" not in run]
        figures = dict.fromkeys(key for run in good for key, value in run.items()
                                if key not in NOT_FIGURES and isinstance(value, (int, float)))
        values = {key: statistics.median(run[key] for run in good if key in run) for key in figures}
        yield {"name": name, **{key: float(f"{value:.8g}") for key, value in values.items()},
               "errors": list(dict.fromkeys(run["error_message"] for run in all_runs if "error_message" in run))}


def machine():
    """What the benchmarks ran on, as this script does."""
    pages = pathlib.Path("/sys/kernel/mm/transparent_hugepage/enabled")
    cores = ",".join(map(str, sorted(os.sched_getaffinity(0))))
    return {"processor": field("/proc/cpuinfo", "model name"), "memory": field("/proc/meminfo", "MemTotal"),
            "pinning": f"process on cores {cores}, threads not pinned one by one",
            "transparent_huge_pages": pages.read_text().strip() if pages.exists() else "unknown"}


def read_run(folder):
    bench = json.loads((folder / "bench.json").read_text())
    once = [json.loads(line) for line in (folder / "once.jsonl").read_text().splitlines()]
    found = bench["context"] | machine()
    runs = [run for run in bench["benchmarks"] if run["run_type"] != "aggregate"] + once
    context = {name: found.get(name, "unknown") for name in MACHINE} | {"dates": [bench["context"]["date"]]}
    return {"context": context, "medians": list(medians(runs))}


def added(earlier, summary):
    """The new summary, completed by the earlier one's rows that it lacks, if they are the same machine's."""
    other = [name for name in MACHINE if earlier["context"][name] != summary["context"][name]]
    if other:
        print("The earlier medians are dropped: they come from a different " + ", ".join(other), file=sys.stderr)
        return summary
    rows = {row["name"]: row for row in earlier["medians"] + summary["medians"]}
    dates = dict.fromkeys(earlier["context"]["dates"] + summary["context"]["dates"])
    return {"context": summary["context"] | {"dates": list(dates)}, "medians": list(rows.values())}


class Results:
    """Reads a folder's summary.json. Benchmarks are named "what/case/variant"; a figure that is not there is None."""

    def __init__(self, folder):
        summary = json.loads((pathlib.Path(folder) / "summary.json").read_text())
        self.context, rows = summary["context"], summary["medians"]
        self.thread_counts = [int(count) for count in self.context["thread_counts"].split(",")]
        self.errors = [(row["name"], error) for row in rows for error in row["errors"]]
        self._rows = {row["name"]: row for row in rows}

    def figure(self, name, threads, key="real_time"):
        return self._rows.get(f"{name}/threads:{threads}", {}).get(key)

    def ms(self, case, threads, variant="warm_swept"):
        return self.figure(f"end_to_end/{case}/{variant}", threads)

    def variants(self, what):
        """Pairs of case and variant."""
        return list(dict.fromkeys(tuple(name.split("/")[1:3]) for name in self._rows if name.startswith(what + "/")))

    def cases(self, what):
        return list(dict.fromkeys(case for case, _ in self.variants(what)))


def ratio(above, below):
    """The ratio; None if either value is missing."""
    return above / below if above is not None and below else None


def fitted_exponent(points):
    """The slope of log y over log x, fitted by least squares; None of fewer than three points."""
    if len(points) < 3:
        return None
    return statistics.linear_regression(*zip(*((math.log(x), math.log(y)) for x, y in points))).slope


def main():
    path = pathlib.Path(sys.argv[2]) / "summary.json"
    summary = read_run(pathlib.Path(sys.argv[1]))
    if "--add" in sys.argv[3:] and path.exists():
        summary = added(json.loads(path.read_text()), summary)
    rows = ",\n".join("  " + json.dumps(row) for row in summary["medians"])  # a diff shows what was measured again
    path.write_text(f'{{\n "context": {json.dumps(summary["context"])},\n "medians": [\n{rows}\n ]\n}}\n')


if __name__ == "__main__":
    main()
