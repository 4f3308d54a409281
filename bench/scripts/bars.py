#!/usr/bin/env python3
"""Compares results with the bars and prints a table. Usage: bars.py FOLDER (which holds summary.json).

Exit status 1 if a bar is not met, 2 if a benchmark failed."""
import math
import sys

from results import Results, fitted_exponent, markdown_table, ratio

MB = 1e6


class Bar:
    """One figure and its bar. `most`: the figure must not exceed the bar; otherwise it must not fall below it."""

    def __init__(self, name, figure, bar, stretch=None, most=True, unit=""):
        self.name, self.figure, self.bar, self.stretch, self.most, self.unit = name, figure, bar, stretch, most, unit

    def reaches(self, limit):
        return self.figure is not None and (self.figure <= limit if self.most else self.figure >= limit)

    def met(self):
        return self.figure is None or self.reaches(self.bar)

    def row(self):
        shown = [number(value, self.unit) for value in (self.figure, self.bar, self.stretch)]
        sign = "at most " if self.most else "at least "
        if self.figure is None:
            verdict = "not measured"
        elif self.stretch is not None and self.reaches(self.stretch):
            verdict = "met, stretch too"
        else:
            verdict = "met" if self.met() else "NOT met"
        return [self.name, shown[0], sign + shown[1], shown[2], verdict]


def number(value, unit):
    if value is None:
        return "-"
    digits = max(0, 2 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{min(digits, 3)}f}{' ' + unit if unit else ''}"


def throughput_bars(results):
    bars = []
    for case, limits in {"liver": ((200, 300), (360, 550)), "femur": ((140, 200), (250, 360))}.items():
        for threads, (bar, stretch) in zip((1, 2), limits):
            rate = results.counter("segments/s", case, threads)
            bars.append(Bar(f"{case}, {threads} thread{'s' * (threads > 1)}", ratio(rate, 1e6), bar, stretch, False,
                            "M segments/s"))
    return bars


def time_bars(results):
    def ms(name, case, threads, variant, bar, stretch):
        return Bar(f"{name}, {threads} thread{'s' * (threads > 1)}", results.ms(case, threads, variant), bar, stretch,
                   unit="ms")
    return [
        ms("scan: 3.4 M triangles, 18 M segments", "scan", 1, "warm_swept", 350, 200),
        ms("scan", "scan", 2, "warm_swept", 190, 105),
        ms("figure: 8.8 M triangles in 10 mm", "figure", 2, "warm_swept", 110, 60),
        ms("figure from a file in the page cache", "figure", 2, "file_read", 170, 110),
        ms("skull: 16.7 M triangles, 70 M segments", "skull", 2, "warm_swept", 1050, 500),
    ]


def ratio_bars(results):
    bars = []
    for threads in (1, 2):
        bars.append(Bar(f"scan shuffled over sorted, {threads} thread{'s' * (threads > 1)}",
                        ratio(results.ms("scan_shuffled", threads), results.ms("scan", threads)), 1.4))
    bars.append(Bar("skull cold over warm, 2 threads",
                    ratio(results.ms("skull", 2, "cold_swept"), results.ms("skull", 2)), 1.5))
    for case in results.cases():
        if case.endswith("_irregular"):
            uniform = case.removesuffix("_irregular")
            for threads in (1, 2):
                bars.append(Bar(f"{uniform}, irregular planes over uniform, {threads} thread{'s' * (threads > 1)}",
                                ratio(results.ms(case, threads), results.ms(uniform, threads)), 1.3))
    for case in results.cases():
        few = "_planes" in case
        if few or case in ("liver", "femur", "brain", "hip_femur", "scan", "scan_shuffled", "figure", "skull"):
            bars.append(Bar(f"{case}, speed-up by 2 threads", ratio(results.ms(case, 1), results.ms(case, 2)),
                            1.5 if few else 1.8, None, False))
    return bars


def scaling_bars(results):
    bars = []
    for threads in (1, 2):
        points = []
        for case in results.cases():
            time = results.ms(case, threads)
            if case.startswith("linear_") and time is not None:
                work = sum(results.counter(name, case, threads) for name in ("triangles", "planes", "segments"))
                points.append((work, time))
        exponent = fitted_exponent(points) if len(points) > 2 else None
        bars.append(Bar(f"exponent of time over n + k + m, 10^4 to 10^7 triangles, {threads} thread{'s' * (threads > 1)}",
                        exponent, 1.05))
    few, many = (results.counter("contours/s", f"rings_{count}", 1, "series", "nesting") for count in (10, 10000))
    bars.append(Bar("nesting, time per contour: 10,000 over 10", ratio(few, many), 2.0))
    return bars


def reading_bars(results):
    bars = []
    for case, variant in results.case_variants("read"):
        if variant == "text":
            rate = ratio(results.counter("bytes/s", case, 2, variant, "read"), 1e6)
            bars.append(Bar(f"read {case}, 2 threads", rate, 500, None, False, "MB/s"))
        if variant == "binary":
            share = results.counter("share_of_pread", case, 2, variant, "read")
            bars.append(Bar(f"read {case}, share of pread, 2 threads", share, 0.5, None, False))
    return bars


def memory_bars(results):
    bars = []
    for peak in results.peaks:
        bound = peak["input_bytes"] + 48 * peak["crossed"] + 1.2 * peak["result_bytes"] + 64 * MB
        cut = f"{peak['band_planes']} planes a band" if peak["band_planes"] else "bands by work"
        bars.append(Bar(f"peak memory, {peak['name']}, {cut}, {peak['threads']} threads", peak["peak_bytes"] / MB, bound / MB,
                        unit="MB"))
    return bars


def all_bars(results):
    return (throughput_bars(results) + time_bars(results) + ratio_bars(results) + scaling_bars(results)
            + reading_bars(results) + memory_bars(results))


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
