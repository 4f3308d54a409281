"""The page that bench/scripts/python.py writes: the machine and the versions, and the tables with what they show."""

import datetime
import os
import pathlib
import platform
import re
import subprocess

from results import markdown_table

HEAD = """# lamella in Python

`bench/scripts/python.py` made this page. What is timed is described in [bench/README.md](../README.md#python).
"""
TEXTS = ("""## The same slice in C++

Vertices are float32, indices int32, in memory. Each side is a process of its own, and they take turns. Freeing results is not
timed. The bar is met by at most 1.05 times the time in C++ plus 200 us.
""", """## Many layers of a small mesh
""", """## Other ways to cut the femur, layers of 0.32 mm

Times are from mesh to contours. numpy starts at arrays, VTK at a mesh of its own; `prepared` is `lamella.prepare(mesh)`. An answer
of VTK counts as another one if a polyline is open, or if the number of contours or the area is not lamella's.
""")


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def field(path, name):
    found = re.search(rf"^{name}\s*[:=]\s*(.*)$", pathlib.Path(path).read_text(), re.MULTILINE)
    return found.group(1) if found else "unknown"


def machine_table(build, versions, command):
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    compiler = field(build / "CMakeCache.txt", "CMAKE_CXX_COMPILER:[A-Z]*")
    rows = {
        "processor": field("/proc/cpuinfo", "model name"),
        "cores": len(os.sched_getaffinity(0)),
        "memory": f"{memory:.0f} GiB",
        "system": platform.freedesktop_os_release()["PRETTY_NAME"],
        "compiler": output(compiler, "--version").splitlines()[0],
        **versions,
        "commit": output("git", "-C", str(pathlib.Path(__file__).parent), "rev-parse", "--short", "HEAD"),
        "measured": datetime.date.today().isoformat(),
        "command": f"`{command}`",
    }
    return markdown_table(["", ""], rows.items())


def page(build, versions, command, tables):
    parts = [HEAD, machine_table(build, versions, command) + "\n"]
    for text, table in zip(TEXTS, tables):
        parts += [text, table + "\n"]
    return "\n".join(parts)
