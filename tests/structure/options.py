#!/usr/bin/env python3
"""Checks that options are described once: engine/options/options.toml is what the other places follow from.

    options.py ROOT [LAMELLA]    exit status 1 if generate.py would write something else than there is, if an option lacks
                                 its flag of LAMELLA, the tool, or if more files name it than may
    options.py --self-test ROOT  breaks each rule in a copy and checks that it is reported

A file names an option by its C++ member, its flag or its Python keyword. Comments, tests, examples and what generate.py writes
do not count. ROOM, which does what options ask, counts as one file where no more of its own name the option than may.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

MOST_FILES = 5
ROOM = "engine/slicing"
HEADER, C_HEADER = "include/lamella/options.hpp", "include/lamella/lamella.h"
WRITTEN = [HEADER, C_HEADER, "engine/options/options.inc", "engine/options/option_words.hpp"]
SUFFIXES = {".cpp", ".hpp", ".h", ".py"}
COMMENT = {".py": r'#[^\n]*|"""(?:.|\n)*?"""'}
C_COMMENT = r"//[^\n]*|/\*(?:.|\n)*?\*/"


def options_of(root):
    return tomllib.loads((root / "engine/options/options.toml").read_text())["option"]


def keyword_of(option):
    return option.get("python", option["name"].removesuffix("_mm"))


def flag_of(option):
    flag = option.get("tool", option["name"].removesuffix("_mm").replace("_", "-"))
    return f"--{flag}" if flag else ""


def copy_of(root, folder):
    for path in [*WRITTEN, "engine/options/options.toml", "engine/options/generate.py"]:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(root / path, folder / path)
    return folder


def stale(root):
    """Files that generate.py would write otherwise."""
    with tempfile.TemporaryDirectory() as name:
        copy = copy_of(root, pathlib.Path(name))
        subprocess.run([sys.executable, copy / "engine/options/generate.py"], check=True)
        for path in WRITTEN:
            if (copy / path).read_bytes() != (root / path).read_bytes():
                yield f"{path} is not what engine/options/generate.py writes"


def missing(root, tool):
    """Options without a flag, though their description does not say why. That C++, C and Python have them follows from stale()."""
    shown = subprocess.run([tool, "slice", "--help"], check=True, capture_output=True, text=True).stdout if tool else None
    for option in options_of(root):
        if shown is not None and flag_of(option) and not re.search(rf"{flag_of(option)}\b(?!-)", shown):
            yield f"{option['name']} has no {flag_of(option)} in lamella slice --help"


def sources(root):
    """Path and code of each file that is no test, without comments and what generate.py writes."""
    for folder in ("engine", "include", "tools/lamella", "tools/python"):
        for path in sorted((root / folder).rglob("*")):
            inner = path.relative_to(root)
            if path.suffix in SUFFIXES and not {"tests", "examples", "options"} & set(inner.parts):
                text = re.sub(r"\bbegin (\w+)(?:.|\n)*?\bend \1\b", "", path.read_text(errors="replace"))
                yield inner, re.sub(COMMENT.get(path.suffix, C_COMMENT), "", text)


def pattern_of(option, files):
    """A name that other public structs have, too, or one word, as `side`, counts only as a member of options."""
    name, keyword, flag, group = option["name"], keyword_of(option), flag_of(option), option.get("group", "options")
    shared = any(path.parts[0] == "include" and path.suffix == ".hpp" and re.search(rf"\b{name}\b", code) for path, code in files)
    owner = {"region": "region|rules"}.get(group, group)
    spelled = [rf"\b(?:{owner}|options)\.{name}\b" if shared or "_" not in name else rf"\b{name}\b"]
    if flag:
        spelled.append(rf'"{flag}\b(?!-)')
    if keyword:
        spelled.append(rf'^ +{keyword}: [A-Z]\w+\[|slice_options\([^)]*"{keyword}"')
    return re.compile("|".join(spelled), re.MULTILINE)


def named_too_often(root):
    files = list(sources(root))
    for option in options_of(root):
        pattern = pattern_of(option, files)
        named = [path for path, code in files if pattern.search(code)]
        inside = [path for path in named if path.is_relative_to(ROOM)]
        named = [path for path in named if path not in inside[1:] or len(inside) > MOST_FILES]
        if len(named) > MOST_FILES:
            yield f"{option['name']} is named in {len(named)} files, at most {MOST_FILES}: {', '.join(map(str, named))}"


def complaints(root, tool):
    return [*stale(root), *missing(root, tool), *named_too_often(root)]


# For each rule: a file, what is replaced in it, by what, and a part of the complaint.
PLANTED = [
    (HEADER, "double closing_mm = 0;", "double closing_mm = 1;", f"{HEADER} is not what"),
    (C_HEADER, "int32_t side;", "int32_t sides;", f"{C_HEADER} is not what"),
    *((f"engine/named_{i}.cpp", "", "options.frame.transform;", None) for i in range(MOST_FILES)),
    ("engine/named_last.cpp", "", "options.frame.transform;", "transform is named in"),
]


def self_test(root):
    with tempfile.TemporaryDirectory() as name:
        copy = copy_of(root, pathlib.Path(name))
        for path, old, new, expected in PLANTED:
            file = copy / path
            before = file.read_text() if file.exists() else ""
            assert old in before, f"{path} has no {old}"
            file.write_text(before.replace(old, new, 1) if old else new)
            if expected is not None:
                assert any(expected in complaint for complaint in complaints(copy, None)), f"not reported: {new} in {path}"
                file.write_text(before)


def main():
    if sys.argv[1] == "--self-test":
        return self_test(pathlib.Path(sys.argv[2]))
    found = complaints(pathlib.Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None)
    print(*found, sep="\n", end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
