"""What the benchmarks left in a folder of results: medians of repetitions, and every run by itself."""
import json
import math
import os
import re
import statistics
from typing import NamedTuple, Optional


class Run(NamedTuple):
    what: str  # end_to_end, stage, assemble, nesting, copy
    case: str
    variant: str
    threads: int
    ms: float
    counters: dict
    error: Optional[str]
    repetition: int


class Results:
    def __init__(self, folder):
        self.folder = folder
        bench = self._read("bench.json")
        self.context = bench["context"]
        self.runs = [self._run(entry) for entry in bench["benchmarks"] if entry.get("run_type") != "aggregate"]
        self.partition = self._read("partition.json", missing={})
        self.peaks = self._read("peaks.json", missing=[])

    def _read(self, name, missing=None):
        path = os.path.join(self.folder, name)
        if missing is not None and not os.path.exists(path):
            return missing
        with open(path, encoding="utf-8") as file:
            return json.load(file)

    @staticmethod
    def _run(entry):
        what, case, variant, threads = entry["name"].split("/")[:4]
        known = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
                 "repetition_index", "iterations", "real_time", "cpu_time", "time_unit", "error_occurred", "error_message"}
        counters = {key: value for key, value in entry.items() if key not in known and isinstance(value, (int, float))}
        return Run(what, case, variant, int(re.sub(r"\D", "", threads)), entry.get("real_time", math.nan), counters,
                   entry.get("error_message"), entry.get("repetition_index", 0))

    def select(self, what, case, variant, threads):
        return [run for run in self.runs if run[:4] == (what, case, variant, threads) and run.error is None]

    def ms(self, case, threads, variant="warm_swept", what="end_to_end"):
        """Median over the repetitions, or None."""
        times = [run.ms for run in self.select(what, case, variant, threads)]
        return statistics.median(times) if times else None

    def counter(self, name, case, threads, variant="warm_swept", what="end_to_end"):
        values = [run.counters[name] for run in self.select(what, case, variant, threads) if name in run.counters]
        return statistics.median(values) if values else None

    def cases(self, what="end_to_end"):
        return list(dict.fromkeys(run.case for run in self.runs if run.what == what))

    def thread_counts(self):
        return [int(count) for count in self.context["thread_counts"].split(",")]

    def errors(self):
        return list(dict.fromkeys((f"{run.what}/{run.case}/{run.variant}/threads:{run.threads}", run.error)
                                  for run in self.runs if run.error is not None))


def ratio(above, below):
    """None where either is missing."""
    return above / below if above is not None and below else None


def fitted_exponent(points):
    """Least squares of log y over log x."""
    xs = [math.log(x) for x, _ in points]
    ys = [math.log(y) for _, y in points]
    mean_x, mean_y = statistics.fmean(xs), statistics.fmean(ys)
    below = sum((x - mean_x) ** 2 for x in xs)
    return sum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys)) / below if below > 0 else None


def markdown_table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])
