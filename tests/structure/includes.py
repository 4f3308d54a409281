#!/usr/bin/env python3
"""Checks that includes run downwards only, between libraries and between the folders of engine/slicing.

    includes.py ROOT              lists the includes of the checkout at ROOT that break the order; exit status 1 if there are any
    includes.py --self-test ROOT  breaks each rule in a copy and checks that it is reported
"""

import pathlib
import re
import shutil
import sys
import tempfile

# From below to above. A file may include its own library and those below it.
LIBRARIES = ["base", "options", "slicing", "mesh", "audit", "c", "io", "medical", "tools"]

# What differs between systems: below the rest of its library, but for what is no more than C++.
ROOM = "base/system/"
BELOW_THE_ROOM = ["base/function_ref.hpp"]

# Folders of engine/slicing, from below to above; those in one line must not include each other. What is above calls what is
# below: slice_layers.cpp begins the sweeps of bands, a sweep links and walks contours, and the layer has them repaired, filled and
# nested, and appends them to the band's output in result.
SLICING = [
    ["tuning.hpp"],
    ["grid"],
    ["planes"],
    ["buckets"],
    ["bands"],
    ["result", "nesting"],
    ["edges", "contours"],
    ["repair", "offset"],
    ["regions"],
    ["simplify"],
    ["layer"],
    ["sweep"],
    ["slicer.hpp"],
    ["slice_layers.hpp"],
    ["slice_layers.cpp", "handover", "faces"],
    ["measures"],
    ["overlay", "heights", "tracks"],
    ["parts"],
    ["sections", "compare"],
    ["slicer.cpp"],
]

# Two ways to sweep, neither of which knows the other.
PEERS = [("slicing/sweep/band_sweep", "slicing/sweep/wide_plane")]

# Public headers that are not in a folder named after their library.
PUBLIC = {
    "array": "base", "context": "base", "error": "base", "integer128": "base", "version": "base",
    "grid": "options", "mesh": "options", "options": "options",
    "compare": "slicing", "destination": "slicing", "heights": "slicing", "layers": "slicing", "measures": "slicing", "overlay": "slicing", "result": "slicing", "sections": "slicing", "slice": "slicing", "source": "slicing", "tracks": "slicing",
    "check": "mesh", "weld": "mesh", "audit": "audit",
    "lamella": "audit", "lamella.h": "c", "overlay.h": "c", "heights.h": "c", "tracks.h": "c", "measures.h": "c", "io": "io", "medical": "medical",
}  # fmt: skip

# What a host that includes the core's headers is not to be burdened with.
NOT_IN_CORE_HEADERS = r"(oneapi/)?tbb|mimalloc|iostream|memory_resource|functional|stop_token"
NAMES_NOT_IN_CORE_HEADERS = r"std::pmr|std::function\b|std::stop_token|std::jthread|\btbb::"

# The only places that know a library of others; None: regions are made by the engine itself.
OTHERS = {
    r"(oneapi/)?tbb/": "base/parallel.cpp",
    r"(polyclipping/)?clipper|CGAL/|boost/(geometry|polygon)": None,
    r"mimalloc": "tools/",
    r"(expat|zip)\b": "io/",
    r"(zlib|fast_float)\b": ("io/", "medical/", "tools/lamella/view/"),
    r"nlohmann\b": ("io/", "medical/", "tools/lamella/batch/", "tools/lamella/processes/"),
    r"openssl\b|bcrypt\.h|CommonCrypto": "base/system/",
    r"png\.h\b": "medical/",
    r"hdf5\.h": "medical/hdf5/",
    # Systems and processors.
    r"sys/|arpa/|net|csignal|(dirent|dlfcn|fcntl|glob|io|poll|process|psapi|sched|shellapi|signal|spawn|termios|unistd|windows|winsock2)\.h": (
        "base/system/", "tools/lamella/system/"),
    r"pthread\.h": ("base/system/", "tools/lamella/system/", "tools/python/native/"),
    r"(x86intrin|cpuid|intrin|[a-z]mmintrin|arm_neon|wasm_simd128)\.h": ("base/system/", "base/dispatch.hpp"),
}

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


def library_of(path):
    """Of a path below include/lamella, engine/ or tools/, without that folder; None where it is in no library."""
    first = path.split("/")[0]
    if first == "lamella":
        rest = path.removeprefix("lamella/")
        return rest.split("/")[0] if "/" in rest else PUBLIC.get(rest.removesuffix(".hpp"))
    return first if first in LIBRARIES else None


def slicing_level(path):
    """Which line of SLICING, and which folder of it, a path like slicing/FOLDER/FILE is in; None for other paths."""
    parts = path.split("/")
    if parts[0] != "slicing":
        return None
    for level, folders in enumerate(SLICING):
        if parts[1] in folders:
            return level, parts[1]
    return -1, parts[1]


def complaint_about(path, included):
    """What is wrong with `path` including the project's file `included`, or None."""
    own, other = library_of(path), library_of(included)
    if own is None or other is None:
        unknown = path if own is None else included
        return f"{unknown} is in none of the libraries that tests/structure/includes.py lists"
    if path.startswith(ROOM) and included.startswith("base/") and not included.startswith((ROOM, *BELOW_THE_ROOM)):
        return "base/system must not include base, which is above it"
    if LIBRARIES.index(other) > LIBRARIES.index(own):
        return f"{own} must not include {other}, which is above it"
    from_level, to_level = slicing_level(path), slicing_level(included)
    if from_level and to_level:
        if min(from_level[0], to_level[0]) < 0:
            return "a folder of engine/slicing that tests/structure/includes.py does not list"
        if to_level[1] != from_level[1] and to_level[0] >= from_level[0]:
            return f"slicing/{from_level[1]} must not include slicing/{to_level[1]}, which is beside or above it"
    for a, b in PEERS:
        if (path.startswith(a) and included.startswith(b)) or (path.startswith(b) and included.startswith(a)):
            return "neither of two peers includes the other"
    return None


def complaints_about_others(path, included):
    """What is wrong with `path` including a header from elsewhere."""
    for name, place in OTHERS.items():
        if re.match(name, included) and (place is None or not path.startswith(place)):
            yield f"nothing includes <{included}>" if place is None else f"only {place if isinstance(place, str) else ', '.join(place)} includes <{included}>"


def complaints(root):
    sources = []  # (file, path as included or as if it were)
    for folder, prefix in (("include/lamella", "lamella/"), ("engine", ""), ("tools", "tools/")):
        top = root / folder
        for file in sorted([*top.rglob("*.[hc]pp"), *top.rglob("*.h"), *top.rglob("*.inc")]):
            sources.append((file, prefix + file.relative_to(top).as_posix()))
    if len(sources) < 100:
        yield f"{root}: only {len(sources)} source files found"
    known = {path for _, path in sources}
    for file, path in sources:
        text = file.read_text(encoding="utf-8")
        core_header = path.startswith("lamella/") and library_of(path) not in ("io", "medical")
        for match in INCLUDE.finditer(text):
            included = match.group(2)
            found = list(complaints_about_others(path, included))
            if included in known:
                found.append(complaint_about(path, included))
            elif match.group(1) == '"' and not path.startswith("tools/"):
                found.append(f'"{included}" is no file of include/ or engine/')
            if core_header and re.fullmatch(f"({NOT_IN_CORE_HEADERS})([./].*)?", included):
                found.append(f"<{included}> must not be in a header of the core")
            line = text.count("\n", 0, match.start(2)) + 1
            yield from (f"{file.relative_to(root)}:{line}: {what}" for what in found if what)
        for match in re.finditer(NAMES_NOT_IN_CORE_HEADERS, COMMENT.sub("", text)) if core_header else ():
            yield f"{file.relative_to(root)}: {match.group(0)} must not be in a header of the core"


# Each rule, broken: a file, a line to add to it, and a part of the complaint.
PLANTED = [
    ("engine/slicing/slice_layers.cpp", '#include "mesh/check/finders.hpp"', "slicing must not include mesh"),
    ("engine/base/parallel.hpp", '#include "lamella/result.hpp"', "base must not include slicing"),
    ("include/lamella/lamella.hpp", '#include "lamella/io.hpp"', "audit must not include io"),
    ("engine/slicing/grid/bounds.hpp", '#include "slicing/planes/plane_set.hpp"', "slicing/planes, which is beside or above"),
    ("engine/slicing/nesting/nest.cpp", '#include "slicing/result/layer_target.hpp"', "slicing/result, which"),
    ("engine/slicing/sweep/band_sweep.cpp", '#include "slicing/sweep/wide_plane.hpp"', "peers"),
    ("engine/slicing/grid/bounds.cpp", '#include "gird/blocks.hpp"', "no file of"),
    ("engine/slicing/sweep/band_sweep.cpp", "#include <tbb/parallel_for.h>", "only base/parallel.cpp"),
    ("tools/lamella/terminal/console.cpp", "#include <nlohmann/json.hpp>", "only io/, medical/"),
    ("engine/io/write/output_file.cpp", "#include <unistd.h>", "only base/system/, tools/lamella/system/ includes <unistd.h>"),
    ("engine/base/array.cpp", "#include <sys/mman.h>", "only base/system/, tools/lamella/system/ includes <sys/mman.h>"),
    ("tools/lamella/batch/results.cpp", "#include <fcntl.h>", "only base/system/, tools/lamella/system/ includes <fcntl.h>"),
    ("tools/lamella/terminal/console.cpp", "#include <pthread.h>", "tools/python/native/ includes <pthread.h>"),
    ("engine/slicing/grid/bounds.cpp", "#include <immintrin.h>", "only base/system/, base/dispatch.hpp"),
    ("engine/base/system/file.hpp", '#include "base/parallel.hpp"', "base/system must not include base"),
    ("engine/slicing/regions/fill.cpp", "#include <polyclipping/clipper.hpp>", "nothing includes <polyclipping/clipper.hpp>"),
    ("include/lamella/context.hpp", "#  include <memory_resource>", "<memory_resource> must not be"),
    ("include/lamella/slice.hpp", "#include <tbb/task_arena.h>", "<tbb/task_arena.h> must not be"),
    ("include/lamella/slice.hpp", "inline void call(std::function<void()>);", "std::function must not be"),
    ("include/lamella/fresh.hpp", "#pragma once", None),
    ("include/lamella/slice.hpp", '#include "lamella/fresh.hpp"', "in none of the libraries"),
]  # fmt: skip


def self_test(root):
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder)
        for part in ("engine", "include", "tools"):
            shutil.copytree(root / part, copy / part)
        for name, line, expected in PLANTED:
            file = copy / name
            before = file.read_text(encoding="utf-8") if file.exists() else ""
            file.write_text(f"{before}\n{line}\n", encoding="utf-8")
            if expected is not None:  # else it stays for the next one
                assert any(found.startswith(name) and expected in found for found in complaints(copy)), f"not reported: {line} in {name}"
                file.write_text(before, encoding="utf-8")


def main():
    root = pathlib.Path(sys.argv[-1])
    if "--self-test" in sys.argv:
        return self_test(root)
    found = list(complaints(root))
    print(*found, sep="\n", end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
