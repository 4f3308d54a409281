#!/usr/bin/env python3
"""Reduces a run of the benchmarks to the medians in summary.json, from which all tables are made.

    summary.py BUILD RUN_FOLDER RESULTS_FOLDER full|quick [--add]

Reads bench.json and once.jsonl from RUN_FOLDER. With --add, medians of earlier runs on the same machine are kept unless this run
measured them again."""
import json
import os
import pathlib
import statistics
import sys

from readme_table import field, machine

# Numbers of a run that its medians leave out.
NOT_FIGURES = {"family_index", "per_family_instance_index", "repetitions", "repetition_index", "iterations", "threads", "hash"}


def medians(all_runs):
    """One row for all runs of a benchmark, "what/case/variant/threads:N": medians to eight digits, of those that did not fail."""
    by_name = {}
    for run in all_runs:
        by_name.setdefault("/".join(run["name"].split("/")[:4]), []).append(run)
    for name, runs in by_name.items():
        good = [{key: statistics.median(value) if isinstance(value, list) else value for key, value in run.items()}
                for run in runs if "error_message" not in run]
        keys = [key for key, value in (good[0] if good else {}).items() if isinstance(value, (int, float)) and key not in NOT_FIGURES]
        yield {"name": name, **{key: float(f"{statistics.median(run[key] for run in good):.8g}") for key in keys},
               "errors": list(dict.fromkeys(run["error_message"] for run in runs if "error_message" in run))}


def context_of(build, sizes):
    """What the benchmarks ran on, as this script does."""
    pages = pathlib.Path("/sys/kernel/mm/transparent_hugepage/enabled")
    cores = ",".join(map(str, sorted(os.sched_getaffinity(0))))
    flags = field(pathlib.Path(build, "CMakeCache.txt"), r"CMAKE_CXX_FLAGS_RELEASE:\w*")
    return machine(build, flags=f"{flags} -ffp-contract=off", allocator="mimalloc", pinning=f"process on cores {cores}",
                   transparent_huge_pages=pages.read_text().strip() if pages.exists() else "unknown", sizes=sizes)


def added(earlier, summary):
    """The new summary, completed by the earlier one's rows that it lacks, if they are the same machine's."""
    before, now = earlier["context"], summary["context"]
    other = [name for name in now if name not in ("commit", "measured") and before.get(name) != now[name]]
    if other:
        print("The earlier medians are dropped: they come from a different " + ", ".join(other), file=sys.stderr)
        return summary
    rows = {row["name"]: row for row in earlier["medians"] + summary["medians"]}
    several = {name: ", ".join(dict.fromkeys(f"{before[name]}, {now[name]}".split(", "))) for name in ("commit", "measured")}
    return {"context": now | several, "medians": list(rows.values())}


class Results:
    """Reads a folder's summary.json. Benchmarks are named "what/case/variant"; a figure that is not there is None."""

    def __init__(self, folder):
        summary = json.loads((pathlib.Path(folder) / "summary.json").read_text())
        self.context, rows = summary["context"], summary["medians"]
        self.errors = [(row["name"], error) for row in rows for error in row["errors"]]
        self._rows = {row["name"]: row for row in rows}
        self.thread_counts = sorted({int(name.rsplit(":", 1)[1]) for name in self._rows if name.startswith(("bandwidth/", "end_to_end/"))})

    def figure(self, name, threads, key="real_time"):
        return self._rows.get(f"{name}/threads:{threads}", {}).get(key)

    def ms(self, case, threads, variant="warm_swept"):
        return self.figure(f"end_to_end/{case}/{variant}", threads)

    def variants(self, what):
        """Pairs of case and variant."""
        return list(dict.fromkeys(tuple(name.split("/")[1:3]) for name in self._rows if name.startswith(what + "/")))

    def cases(self, what):
        return list(dict.fromkeys(case for case, _ in self.variants(what)))


def main():
    build, run, results, sizes = sys.argv[1:5]
    text = pathlib.Path(run, "bench.json").read_text() or '{"benchmarks": []}'  # empty if the filter matched none
    runs = [row for row in json.loads(text)["benchmarks"] if row["run_type"] != "aggregate"]
    runs += map(json.loads, pathlib.Path(run, "once.jsonl").read_text().splitlines())
    summary = {"context": context_of(build, sizes), "medians": list(medians(runs))}
    path = pathlib.Path(results, "summary.json")
    if "--add" in sys.argv[5:] and path.exists():
        summary = added(json.loads(path.read_text()), summary)
    rows = ",\n".join("  " + json.dumps(row) for row in summary["medians"])  # a diff shows what was measured again
    path.write_text(f'{{\n "context": {json.dumps(summary["context"])},\n "medians": [\n{rows}\n ]\n}}\n')


if __name__ == "__main__":
    main()
