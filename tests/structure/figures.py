#!/usr/bin/env python3
"""Prints how large the house is, and what a newcomer opens to follow one slice; holds the bars.

    figures.py ROOT              prints the figures; exit status 1 if one is beyond its bar
    figures.py --self-test ROOT  checks that lines above a bar, and a file that includes more, are noticed

Lines are those of C++, C, Python and shell. Files of a slice: what slicer.cpp includes in the engine, each header with its
source, followed on; the core of it leaves out regions, offsets, simplification, repair, faces and parts. Fields of a sweep:
those of BandSweep and of its members, a standard container being one; counted where there is a clang.
"""

import pathlib
import re
import shutil
import subprocess
import sys

FOLDERS = ("engine", "include", "tests", "bench", "tools")
SUFFIXES = {".cpp", ".hpp", ".h", ".py", ".sh", ".ts"}
OPTIONAL = ("regions", "offset", "simplify", "repair", "faces", "parts")
# Figure: (at most, or at least, this). A bar is lowered when the house has become smaller; it was raised by what other systems,
# layers of many contours, records in tiers, scratch made ahead, combined layers, roles, heights, offsets in steps, lines that
# are clipped, islands that are followed, copies, the lab's measures, sections, formats and Python, and packages take.
AT_MOST = {"lines": 118_770, "files of a slice": 111, "lines of a slice": 17_786, "longest file": 500, "fields of a sweep": 120}
AT_LEAST = {"comment lines, %": 7.5}


def sources(root):
    return sorted(path for folder in FOLDERS for path in (root / folder).rglob("*") if path.suffix in SUFFIXES and path.is_file() and "node_modules" not in path.parts)


def is_comment(line):
    return line.lstrip().startswith(("//", "/*", "* ", "#")) and not line.lstrip().startswith(("#include", "#if", "#endif", "#define", "#pragma", "#el", "#!"))


def reached(root, without=()):
    """The engine's files that slicer.cpp reaches by includes."""
    engine, include = root / "engine", root / "include"
    found, left = set(), [engine / "slicing" / "slicer.cpp"]
    while left:
        path = left.pop()
        if path in found or any(f"/slicing/{room}/" in path.as_posix() for room in without):
            continue
        found.add(path)
        for name in re.findall(r'^#include "([^"]+)"', path.read_text(), re.MULTILINE):
            left += [base / name for base in (engine, include) if (base / name).is_file()]
        if path.suffix == ".hpp":
            left += [source for source in (path.with_suffix(".cpp"),) if source.is_file()]
    return found


def fields_of_sweep(root):
    """By clang's picture of the record, in which a member's members follow it, indented by two."""
    source = '#include "slicing/sweep/band_sweep.hpp"\nvoid make(const lamella::Memory* memory) { lamella::BandSweep sweep(memory, {}); }\n'
    command = ["clang++", "-std=c++20", f"-I{root / 'engine'}", f"-I{root / 'include'}", "-Xclang", "-fdump-record-layouts", "-fsyntax-only", "-xc++", "-"]
    picture = subprocess.run(command, input=source, capture_output=True, text=True, check=True).stdout
    lines = re.search(r"^ *0 \| class lamella::BandSweep\n((?:.*\|  .*\n)*)", picture, re.MULTILINE)[1].splitlines()
    members = [re.fullmatch(r"[^|]*\| ( +)(.*)", line).groups() for line in lines]
    fields, whole = 0, 999  # members indented further than `whole` are within a standard container
    for (indent, name), (next_indent, _) in zip(members, members[1:] + [("", "")]):
        if len(indent) <= whole:
            whole = len(indent) if re.match(r"(class|struct) std::", name) else 999
            fields += (whole < 999 or next_indent <= indent) and "(base)" not in name and "(empty)" not in name
    return fields


def count(path):
    return path.read_bytes().count(b"\n")


def figures(root):
    files = sources(root)
    lines = [line for path in files for line in path.read_text(errors="replace").splitlines()]
    whole, core = reached(root), reached(root, OPTIONAL)
    sweep = {"fields of a sweep": fields_of_sweep(root)} if shutil.which("clang++") else {}
    return sweep | {
        "lines": len(lines),
        "files": len(files),
        "median lines of a file": sorted(map(count, files))[len(files) // 2],
        "longest file": max(map(count, files)),
        "comment lines, %": 100 * sum(map(is_comment, lines)) / sum(1 for line in lines if line.strip()),
        "files of a slice": len(whole),
        "lines of a slice": sum(map(count, whole)),
        "files of its core": len(core),
        "lines of its core": sum(map(count, core)),
    }


def beyond(found):
    return [f"{name} is {found[name]:g}, at most {bar:g}" for name, bar in AT_MOST.items() if found.get(name, 0) > bar] + [
        f"{name} is {found[name]:g}, at least {bar:g}" for name, bar in AT_LEAST.items() if found[name] < bar
    ]


def self_test(root):
    found = figures(root)
    for name, bar in AT_MOST.items():
        assert beyond({**found, name: bar + 1}), f"{name} beyond its bar goes unnoticed"
    for name, bar in AT_LEAST.items():
        assert beyond({**found, name: bar - 1}), f"{name} below its bar goes unnoticed"
    assert found["files of its core"] < found["files of a slice"] < found["files"]
    assert root / "engine" / "slicing" / "slicer.cpp" in reached(root)


def main():
    if sys.argv[1] == "--self-test":
        return self_test(pathlib.Path(sys.argv[2]))
    found = figures(pathlib.Path(sys.argv[1]))
    for name, value in found.items():
        bar = f"  at most {AT_MOST[name]:,}" if name in AT_MOST else f"  at least {AT_LEAST[name]}" if name in AT_LEAST else ""
        print(f"{name:24} {value:>10,.4g}{bar}" if isinstance(value, float) else f"{name:24} {value:>10,}{bar}")
    problems = beyond(found)
    print(*problems, sep="\n", end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
