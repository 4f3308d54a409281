#!/usr/bin/env python3
"""Prints bench/results/hosts.md: page.py TABLES BUILD COMMAND

TABLES holds suites.md, layers.md and times.md, BUILD the host's build."""
import datetime
import os
import pathlib
import platform
import re
import subprocess
import sys

HEAD = """# lamella in PrusaSlicer

`tests/hosts/prusaslicer.sh` made this page. PrusaSlicer is Debian's source package, built without its window, unchanged but
for the functions `slice_mesh`, `slice_mesh_ex` and `slice_mesh_slabs`, which the adapter in tests/hosts/prusaslicer defines in
their place.
"""

SUITES = """## The host's own tests

"""

LAYERS = """## Layers of both

Both slice at 0.2 mm. A row shows the layer in which they differ most: by how much area, of how much, and how far their contours
lie apart on average (that area by the length of the contours). The host rounds vertices to float in units of 1e-6 mm, lamella to
even multiples of them.

"""

TIMES = """## Times

Wall ms, the host's own -> with lamella (how many times faster): medians of 7 runs that alternate (3
or more, if they take longer than 20 s), after one that is not counted. Both include the conversion to the host's polygons.

"""


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def field(path, name):
    found = re.search(rf"^{name}\s*[:=]\s*(.*)$", pathlib.Path(path).read_text(), re.MULTILINE)
    return found.group(1) if found else "unknown"


def rows(build, command):
    kib = int(field("/proc/meminfo", "MemTotal").split()[0])
    compiler = field(build / "CMakeCache.txt", "CMAKE_CXX_COMPILER:[A-Z]*")
    package = next(build.parent.glob("slic3r-prusa_*.dsc")).stem
    return {
        "processor": field("/proc/cpuinfo", "model name"),
        "cores": len(os.sched_getaffinity(0)),
        "memory": f"{kib / 2**20:.0f} GiB",
        "system": platform.freedesktop_os_release()["PRETTY_NAME"],
        "compiler": output(compiler, "--version").splitlines()[0],
        "host": package + ", with -O1; what is timed, and the adapter, with -O3",
        "commit": output("git", "-C", str(pathlib.Path(__file__).parent), "rev-parse", "--short", "HEAD"),
        "measured": datetime.date.today().isoformat(),
        "command": f"`{command}`",
    }


def main():
    tables, build, command = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    print(HEAD)
    print("|  |  |\n|---|---|")
    for name, value in rows(build, command).items():
        print(f"| {name} | {value} |")
    for text, table in ((SUITES, "suites"), (LAYERS, "layers"), (TIMES, "times")):
        print(f"\n{text}{(tables / f'{table}.md').read_text().strip()}")


if __name__ == "__main__":
    main()
