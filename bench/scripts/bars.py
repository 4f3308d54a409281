#!/usr/bin/env python3
"""Compares results with the bars and prints a table. Usage: bars.py FOLDER (which holds summary.json).

Exit status 1 if a bar is not met, 2 if a benchmark failed."""
import math
import sys

from readme_table import markdown_table
from results import Results, fitted_exponent, ratio

REAL = ("liver", "femur", "brain", "hip_femur", "scan", "scan_shuffled", "figure", "skull")


class Bar:
    """One figure and its bar. `most`: the figure must not exceed the bar; otherwise it must not fall below it."""

    def __init__(self, name, figure, bar, stretch=None, most=True, unit=""):
        self.name, self.figure, self.bar, self.stretch, self.most, self.unit = name, figure, bar, stretch, most, unit

    def reaches(self, limit):
        return self.figure is not None and (self.figure <= limit if self.most else self.figure >= limit)

    def met(self):
        return self.figure is None or self.reaches(self.bar)

    def row(self):
        figure, bar, stretch = (number(value, self.unit) for value in (self.figure, self.bar, self.stretch))
        if self.figure is None:
            verdict = "not measured"
        elif self.stretch is not None and self.reaches(self.stretch):
            verdict = "met, stretch too"
        else:
            verdict = "met" if self.met() else "NOT met"
        return [self.name, figure, ("at most " if self.most else "at least ") + bar, stretch, verdict]


def number(value, unit=""):
    if value is None:
        return "-"
    digits = max(0, 2 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{min(digits, 3)}f}{' ' + unit if unit else ''}"


def on(threads):
    return f"{threads} thread{'s' * (threads > 1)}"


def throughput_bars(results):
    for case, limits in {"liver": ((200, 300), (360, 550)), "femur": ((140, 200), (250, 360))}.items():
        for threads, (bar, stretch) in zip((1, 2), limits):
            rate = ratio(results.counter("segments/s", case, threads), 1e6)
            yield Bar(f"{case}, {on(threads)}", rate, bar, stretch, False, "M segments/s")


def time_bars(results):
    for name, case, threads, variant, bar, stretch in (
            ("scan: 3.4 M triangles, 18 M segments", "scan", 1, "warm_swept", 350, 200),
            ("scan", "scan", 2, "warm_swept", 190, 105),
            ("figure: 8.8 M triangles in 10 mm", "figure", 2, "warm_swept", 110, 60),
            ("figure from a file in the page cache", "figure", 2, "file_read", 170, 110),
            ("skull: 16.7 M triangles, 70 M segments", "skull", 2, "warm_swept", 1050, 500)):
        yield Bar(f"{name}, {on(threads)}", results.ms(case, threads, variant), bar, stretch, unit="ms")


def ratio_bars(results):
    def over(case, other, threads):
        return ratio(results.ms(case, threads), results.ms(other, threads))

    for threads in (1, 2):
        yield Bar(f"scan shuffled over sorted, {on(threads)}", over("scan_shuffled", "scan", threads), 1.4)
    yield Bar("skull cold over warm, 2 threads", ratio(results.ms("skull", 2, "cold_swept"), results.ms("skull", 2)), 1.5)
    for case in results.cases():
        if case.endswith("_irregular"):
            uniform = case.removesuffix("_irregular")
            for threads in (1, 2):
                yield Bar(f"{uniform}, irregular planes over uniform, {on(threads)}", over(case, uniform, threads), 1.3)
    for case in results.cases():
        few = "_planes" in case
        if few or case in REAL:
            yield Bar(f"{case}, speed-up by 2 threads", ratio(results.ms(case, 1), results.ms(case, 2)), 1.5 if few else 1.8, None, False)


def scaling_bars(results):
    for threads in (1, 2):
        times = {case: results.ms(case, threads) for case in results.cases() if case.startswith("linear_")}
        points = [(sum(results.counter(name, case, threads) for name in ("triangles", "planes", "segments")), time)
                  for case, time in times.items() if time is not None]
        yield Bar(f"exponent of time over n + k + m, 10^4 to 10^7 triangles, {on(threads)}",
                  fitted_exponent(points) if len(points) > 2 else None, 1.05)
    few, many = (results.counter("contours/s", f"rings_{count}", 1, "series", "nesting") for count in (10, 10000))
    yield Bar("nesting, time per contour: 10,000 over 10", ratio(few, many), 2.0)


def reading_bars(results):
    for case, variant in results.case_variants("read"):
        if variant == "text":
            rate = ratio(results.counter("bytes/s", case, 2, variant, "read"), 1e6)
            yield Bar(f"read {case}, 2 threads", rate, 500, None, False, "MB/s")
        if variant == "binary":
            share = results.counter("share_of_pread", case, 2, variant, "read")
            yield Bar(f"read {case}, share of pread, 2 threads", share, 0.5, None, False)


def memory_bars(results):
    for peak in results.peaks:
        bound = peak["input_bytes"] + 48 * peak["crossed"] + 1.2 * peak["result_bytes"] + 64e6
        cut = f"{peak['band_planes']} planes a band" if peak["band_planes"] else "bands by work"
        yield Bar(f"peak memory, {peak['name']}, {cut}, {peak['threads']} threads", peak["peak_bytes"] / 1e6, bound / 1e6, unit="MB")


def all_bars(results):
    return [bar for group in (throughput_bars, time_bars, ratio_bars, scaling_bars, reading_bars, memory_bars) for bar in group(results)]


def bars_table(results):
    return markdown_table(["bar", "measured", "bar", "stretch", ""], [bar.row() for bar in all_bars(results)])


def main():
    results = Results(sys.argv[1])
    if "quick" in results.context["sizes"]:
        print("Quick sizes: these figures mean nothing.\n")
    print(bars_table(results))
    for name, error in results.errors():
        print(f"failed: {name}: {error}")
    if results.errors():
        return 2
    return 0 if all(bar.met() for bar in all_bars(results)) else 1


if __name__ == "__main__":
    sys.exit(main())
