#!/usr/bin/env python3
"""Prints bench/results/hosts.md: page.py TABLES BUILD COMMAND

TABLES holds suites.md, layers.md and times.md, BUILD the host's build."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "bench" / "scripts"))
from readme_table import field, machine_table  # noqa: E402

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


def main():
    tables, build, command = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    package = next(build.parent.glob("slic3r-prusa_*.dsc")).stem
    compiler = field(build / "CMakeCache.txt", "CMAKE_CXX_COMPILER:[A-Z]*")
    host = package + ", with -O1; what is timed, and the adapter, with -O3"
    print(HEAD)
    print(machine_table(compiler, {"host": host, "command": f"`{command}`"}))
    for text, table in ((SUITES, "suites"), (LAYERS, "layers"), (TIMES, "times")):
        print(f"\n{text}{(tables / f'{table}.md').read_text().strip()}")


if __name__ == "__main__":
    main()
