#!/usr/bin/env python3
"""Tables of prusaslicer.sh.

    tables.py suites OWN ADAPTER SUITE...   the host's test suites by themselves and with the adapter. Both folders hold SUITE.xml,
                                            written by Catch2. The exit status is 1 if a case passes only without the adapter.
    tables.py page TABLES BUILD COMMAND     bench/results/hosts.md. TABLES holds suites.md, layers.md, times.md and
                                            operations.md, BUILD the host's build.
"""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "bench" / "scripts"))
from readme_table import machine_table  # noqa: E402

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

OPERATIONS = """## Operations on layers

Both are given the same layers, cut at 0.2 mm by lamella: united with the next layer, without it, narrowed by 0.2 mm, closed by
0.049 mm, and told apart into top, bottom and inner surfaces as `PrintObject::detect_surfaces_type()` does. The host's functions
run layer by layer in `tbb::parallel_for`. lamella::Overlay takes a lamella::SliceResult; its times include the conversion of
what it gives to the host's polygons. First by how much they differ, as above: an opening may keep or drop a strip that is just
as wide as itself. Then wall ms, as above.

"""


def read(path):
    """Whether each case passed, by name, and the number of assertions that held. A crash leaves the file cut off."""
    cases, assertions = {}, 0
    try:
        for _, element in ElementTree.iterparse(path, events=("end",)):
            if element.tag == "TestCase":
                cases[element.get("name")] = element.find("OverallResult").get("success") == "true"
            elif element.tag == "OverallResults":  # of a section, or, last of all, of the suite
                assertions = int(element.get("successes"))
    except ElementTree.ParseError as error:
        print(f"{path}: {error}", file=sys.stderr)
    return cases, assertions


def suites(own_folder, adapter_folder, *names):
    broken = []
    print("| suite | cases | pass by themselves | pass with the adapter | assertions, by themselves | with the adapter |")
    print("|---|---|---|---|---|---|")
    for suite in names:
        own, own_assertions = read(f"{own_folder}/{suite}.xml")
        adapter, adapter_assertions = read(f"{adapter_folder}/{suite}.xml")
        if not own:
            sys.exit(f"error: {own_folder}/{suite}.xml holds no case")
        broken += [f"{suite}: {name}" for name, passed in own.items() if passed and not adapter.get(name)]
        print(f"| {suite} | {len(own)} | {sum(own.values())} | {sum(adapter.values())} | {own_assertions} | {adapter_assertions} |")
    for case in broken:
        print(f"\nPasses only without the adapter: {case}")
    return 1 if broken else 0


def page(tables, build, command):
    tables, build = pathlib.Path(tables), pathlib.Path(build)
    package = next(build.parent.glob("slic3r-prusa_*.dsc")).stem
    host = package + ", with -O1; what is timed, and the adapter, with -O3"
    print(HEAD)
    print(machine_table(build, host=host, command=f"`{command}`"))
    for text, table in ((SUITES, "suites"), (LAYERS, "layers"), (TIMES, "times"), (OPERATIONS, "operations")):
        print(f"\n{text}{(tables / f'{table}.md').read_text().strip()}")
    return 0


if __name__ == "__main__":
    sys.exit({"suites": suites, "page": page}[sys.argv[1]](*sys.argv[2:]))
