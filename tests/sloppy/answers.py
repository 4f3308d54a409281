#!/usr/bin/env python3
"""Compares what lamella makes of the sloppy files in files/ with the committed table answers.txt.

    answers.py LAMELLA             checks lamella's rows
    answers.py LAMELLA --update    writes them; rows of other readers and reasons stay

Fails too where lamella breaks the rule: what two of the other readers agree on is lamella's answer, and lamella warns. A line "why" in
the table says why a file is an exception.
"""

import difflib
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
FILES, TABLE = HERE / "files", HERE / "answers.txt"
OTHERS = ["assimp", "VTK", "CGAL", "meshio"]


def words(triangles):
    """The number of triangles given as nine numbers each, the box of their corners, their area."""
    if not triangles:
        return "no triangles"
    area = 0.0
    for row in triangles:
        u, v = ([row[3 * k + i] - row[i] for i in range(3)] for k in (1, 2))
        cross = [u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)]
        area += math.sqrt(sum(x * x for x in cross)) / 2
    low, high = (" ".join("%.5g" % most(row[at] for row in triangles for at in (i, i + 3, i + 6)) for i in range(3)) for most in (min, max))
    return "%d triangles, box %s to %s, area %.5g" % (len(triangles), low, high, area)


def lamella_rows(tool, path):
    """Rows of the table. Messages name the path, which differs from machine to machine."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.stl"
        got = subprocess.run([tool, "convert", path, "-o", out], capture_output=True, timeout=60, errors="replace", check=False)
        said = got.stderr.splitlines()
        if got.returncode != 0:
            return [("lamella", "refused: " + said[-1].removeprefix(f"lamella: {path}: "))]
        answer = words([row[3:] for row in struct.iter_unpack("<12f2x", out.read_bytes()[84:])])
        return [("lamella", answer)] + [("warns", line.removeprefix(f"lamella: warning: {path}: ")) for line in said]


def read_table(text):
    """The lines before the first file, and the rows by file."""
    head, *entries = text.split("\n\n")
    rows = {lines[0]: [tuple(line.split(None, 1)) for line in lines[1:]] for lines in (entry.splitlines() for entry in entries)}
    return head, rows


def broken_rule(rows):
    """The complaint about answers that two of the others share, being no refusals; None where lamella gives it and warns."""
    answers = [answer for name, answer in rows if name in OTHERS and "triangles, " in answer]
    agreed = next((answer for answer in answers if answers.count(answer) > 1), None)
    names = dict(rows)
    if agreed is None or "why" in names:
        return None
    if names["lamella"] != agreed:
        return f"two readers agree on '{agreed}', lamella answers '{names['lamella']}'"
    return None if "warns" in names else "two readers agree with lamella, which does not warn"


def main():
    old = TABLE.read_text()
    head, table = read_table(old)
    for path in sorted(FILES.iterdir()):
        kept = table.get(path.name, [])
        own = lamella_rows(sys.argv[1], path)
        table[path.name] = [row for row in kept if row[0] in OTHERS] + own + [row for row in kept if row[0] == "why"]
    files = {name: "".join("\n    %-8s %s" % row for row in rows) for name, rows in sorted(table.items())}
    new = head + "".join(f"\n\n{name}{rows}" for name, rows in files.items()) + "\n"
    if "--update" in sys.argv[2:]:
        TABLE.write_text(new)
    problems = list(difflib.unified_diff(TABLE.read_text().splitlines(), new.splitlines(), "table", "now", lineterm=""))
    problems += [f"{name}: {rule}" for name, rows in table.items() if (rule := broken_rule(rows))]
    problems += [f"{name} is not in {FILES}" for name in table if not (FILES / name).exists()]
    print("\n".join(problems))
    print(f"{len(table)} files, {len(problems)} lines of problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
