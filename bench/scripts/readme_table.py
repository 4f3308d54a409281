"""What scripts share that measure programs, compare figures with bars and put their tables into bench/README.md."""
import argparse
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import time
from typing import NamedTuple

WORDS = {
    "build": {"type": pathlib.Path},
    "tool": {"type": os.path.abspath},
    "meshes": {"nargs": "*", "metavar": "NAME=MESH", "type": lambda word: tuple(word.split("=", 1))},
}


def compare(doc, name, measure, *words, **options):
    """The main() of a script: takes words, options with these defaults, and --readme; shows the tables of measure(arguments, bars).

    The help is the script's own. Returns the exit status: 1 if a bar is not met."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    for word in words:
        parser.add_argument(word, **WORDS[word])
    for option, default in options.items():
        parser.add_argument("--" + option.replace("_", "-"), type=type(default), default=default)
    parser.add_argument("--readme", type=pathlib.Path)
    arguments, bars = parser.parse_args(), Bars()
    text = "\n\n".join(measure(arguments, bars)) + "\n"
    print(text, end="")
    if arguments.readme:
        replace_table(arguments.readme, name, text)
    return 0 if bars.met else 1


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


class Bars:
    """Remembers whether all bars are met."""

    def __init__(self):
        self.met = True

    def most(self, text, value, bar):
        """The text, with whether the value is at most the bar, if there is one."""
        return self._mark(text, bar, bar is None or value <= bar)

    def least(self, text, value, bar):
        return self._mark(text, bar, bar is None or value >= bar)

    def _mark(self, text, bar, met):
        self.met = self.met and met
        return text if bar is None else f"{text} ({'met' if met else 'not met'})"


def markdown_table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def field(path, name):
    """What follows a name in a file of names and values, which a colon or an equals sign separates."""
    found = re.search(rf"^{name}\s*[:=]\s*(.*)$", pathlib.Path(path).read_text(), re.MULTILINE)
    return found.group(1) if found else "unknown"


def machine_table(compiler, more):
    """The processor and what else decides times, and the rows of `more`, by name."""
    def output(*command):
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()

    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    rows = {
        "processor": field("/proc/cpuinfo", "model name"),
        "cores": len(os.sched_getaffinity(0)),
        "memory": f"{memory:.0f} GiB",
        "system": platform.freedesktop_os_release()["PRETTY_NAME"],
        "compiler": (output(compiler, "--version").splitlines() or ["unknown"])[0],
        "commit": output("git", "-C", str(pathlib.Path(__file__).parent), "rev-parse", "--short", "HEAD") or "unknown",
        "measured": time.strftime("%Y-%m-%d"),
        **more,
    }
    return markdown_table(["", ""], rows.items())


def replace_table(readme, name, text):
    """Puts `text` between the markers `<!-- name: begin -->` and `<!-- name: end -->` of the file `readme`."""
    parts = re.split(rf"(<!-- {name}: (?:begin|end) -->\n)", readme.read_text())
    if len(parts) != 5:
        sys.exit(f"{readme}: has not one pair of markers '<!-- {name}: begin -->' and '... end'")
    parts[2] = "\n" + text + "\n"
    readme.write_text("".join(parts))
