"""What scripts share that measure programs, compare figures with bars and put their tables into pages."""
import math
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import time
from typing import NamedTuple


def run(*command, may_fail=False):
    """Runs a program and drops what it prints."""
    subprocess.run(command, check=not may_fail, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL if may_fail else None)


class Usage(NamedTuple):
    """What a program took, and what it printed."""
    wall_s: float
    processor_s: float
    peak_bytes: int
    text: str


def usage_of(*command, may_fail=False, cwd=None):
    """/usr/bin/time is a small process itself, whose own memory hides no peak."""
    start = time.perf_counter()
    done = subprocess.run(["/usr/bin/time", "-q", "-f", "%U %S %M", *command], check=False, cwd=cwd, capture_output=True, text=True)
    wall = time.perf_counter() - start
    if done.returncode != 0 and not may_fail:
        sys.exit(done.stderr)
    user, system, kilobytes = done.stderr.splitlines()[-1].split()
    return Usage(wall, float(user) + float(system), 1024 * int(kilobytes), done.stdout)


def ms_of(work):
    start = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - start)


def in_turn(works, rounds):
    """What each of some works returned in every round, by name. All take turns, so that a change of the machine's load falls on all;
    the first turn only warms."""
    all_rounds = [{name: work() for name, work in works.items()} for _ in range(rounds + 1)]
    return {name: [each[name] for each in all_rounds[1:]] for name in works}


def medians_of(works, rounds):
    """The medians of what works return, by name."""
    return {name: statistics.median(own) for name, own in in_turn(works, rounds).items()}


def ratio(above, below):
    """The ratio; None if either value is missing."""
    return above / below if above is not None and below else None


def fitted_exponent(points):
    """The slope of log y over log x, fitted by least squares; None of fewer than three points."""
    if len(points) < 3:
        return None
    return statistics.linear_regression(*zip(*((math.log(x), math.log(y)) for x, y in points))).slope


def number(value, unit=""):
    if value is None:
        return "-"
    digits = max(0, 2 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{min(digits, 3)}f}{' ' + unit if unit else ''}"


class Bars:
    """Whether all bars are met, and a table of those that hold() was asked for."""

    def __init__(self):
        self.met, self.rows = True, []

    def most(self, text, value, bar):
        """The text, with whether the value is at most the bar, if there is one."""
        return self._mark(text, bar, bar is None or value <= bar)

    def least(self, text, value, bar):
        return self._mark(text, bar, bar is None or value >= bar)

    def _mark(self, text, bar, met):
        self.met = self.met and met
        return text if bar is None else f"{text} ({'met' if met else 'not met'})"

    def hold(self, name, figure, word, bar, unit=""):
        mark = {"at most": self.most, "at least": self.least}[word]
        measured = "not measured" if figure is None else mark(number(figure, unit), figure, bar)
        self.rows.append([name, f"{word} {number(bar, unit)}", measured])

    def table(self):
        return markdown_table(["bar", "", "measured"], self.rows)


def markdown_table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def field(path, name):
    """What follows a name in a file of names and values, which a colon or an equals sign separates."""
    found = re.search(rf"^{name}\s*[:=]\s*(.*)$", pathlib.Path(path).read_text(), re.MULTILINE)
    return found.group(1) if found else "unknown"


def machine(folder, **more):
    """The processor and what else decides times, and `more`, by name; `folder` is where the programs were built."""
    def output(*command):
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()

    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    compiler = field(pathlib.Path(folder, "CMakeCache.txt"), r"CMAKE_CXX_COMPILER:\w*")
    return {
        "processor": field("/proc/cpuinfo", "model name"),
        "cores": len(os.sched_getaffinity(0)),
        "memory": f"{memory:.0f} GiB",
        "system": platform.freedesktop_os_release()["PRETTY_NAME"],
        "compiler": (output(compiler, "--version").splitlines() or ["unknown"])[0],
        "commit": output("git", "-C", str(pathlib.Path(__file__).parent), "rev-parse", "--short", "HEAD") or "unknown",
        "measured": time.strftime("%Y-%m-%d"),
        **more,
    }


def machine_table(folder, **more):
    return markdown_table(["", ""], machine(folder, **more).items())


def replace_table(readme, name, text):
    """Puts `text` between the markers `<!-- name: begin -->` and `<!-- name: end -->` of the file `readme`."""
    parts = re.split(rf"(<!-- {name}: (?:begin|end) -->\n)", pathlib.Path(readme).read_text())
    if len(parts) != 5:
        sys.exit(f"{readme}: has not one pair of markers '<!-- {name}: begin -->' and '... end'")
    parts[2] = "\n" + text + "\n"
    pathlib.Path(readme).write_text("".join(parts))
