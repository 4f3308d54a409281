"""Reads a folder's summary.json (written by summarise.py): the medians of the benchmarks and what else tables show."""
import json
import math
import os
import statistics
from typing import NamedTuple, Optional


class Median(NamedTuple):
    """Medians over the repetitions of one benchmark."""
    what: str  # end_to_end, nesting, read, copy
    case: str
    variant: str
    threads: int
    ms: Optional[float]
    counters: dict
    errors: list


class Results:
    def __init__(self, folder):
        with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
        self.context, self.partition, self.peaks = summary["context"], summary["partition"], summary["peaks"]
        self.medians = [Median(**row) for row in summary["medians"]]
        self._by_name = {row[:4]: row for row in self.medians}

    def ms(self, case, threads, variant="warm_swept", what="end_to_end"):
        row = self._by_name.get((what, case, variant, threads))
        return row.ms if row else None

    def counter(self, name, case, threads, variant="warm_swept", what="end_to_end"):
        row = self._by_name.get((what, case, variant, threads))
        return row.counters.get(name) if row else None

    def cases(self, what="end_to_end"):
        return list(dict.fromkeys(case for case, _ in self.case_variants(what)))

    def case_variants(self, what):
        return list(dict.fromkeys((row.case, row.variant) for row in self.medians if row.what == what))

    def thread_counts(self):
        return [int(count) for count in self.context["thread_counts"].split(",")]

    def errors(self):
        return [(f"{row.what}/{row.case}/{row.variant}/threads:{row.threads}", error)
                for row in self.medians for error in row.errors]


def ratio(above, below):
    """The ratio; None if either value is missing."""
    return above / below if above is not None and below else None


def fitted_exponent(points):
    """The slope of log y over log x, fitted by least squares."""
    xs = [math.log(x) for x, _ in points]
    ys = [math.log(y) for _, y in points]
    mean_x, mean_y = statistics.fmean(xs), statistics.fmean(ys)
    below = sum((x - mean_x) ** 2 for x in xs)
    return sum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys)) / below if below > 0 else None
