#!/usr/bin/python3
"""Compares what readers make of the sloppy files in files/ with the committed table answers.txt.

    answers.py --lamella TOOL [--cgal PROGRAM]            checks the rows of the readers that are installed
    answers.py --lamella TOOL [--cgal PROGRAM] --update   writes them

Fails too where lamella breaks the rule: what two of the other readers agree on is lamella's answer, and lamella warns.
A line "why" in the table says why a file is an exception. assimp, VTK and meshio are used where Debian's packages
assimp-utils, python3-vtk9 and python3-meshio are installed, CGAL where libcgal-dev was at build time.
"""

import argparse
import difflib
import importlib.util
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
FILES = HERE / "files"
TABLE = HERE / "answers.txt"
OTHERS = ["assimp", "VTK", "CGAL", "meshio"]
TIMEOUT_S = 60
REFUSED = "refused"
NO_READER = "no reader"
NONE = "no triangles"
UNDEFINED = "undefined"  # it crashes, or gives coordinates that the file does not hold
SANE = 1e9  # the corners of the files lie between 0 and 10

HEAD = """\
# What readers make of the files in files/, which are all sloppy or no meshes at all: triangles, the box of their corners,
# area. Written by answers.py --update, checked by the test sloppy_answers. Versions: those of Debian 12.
#
# Rule: what two of assimp, VTK, CGAL and meshio agree on is lamella's answer, and lamella warns. Lines "why" give the reason
# where it is not so. "undefined": a crash, or coordinates that the file does not hold; not compared again.
"""


def words(triangles):
    """Of triangles given as three points each."""
    if not triangles:
        return NONE
    corners = [corner for triangle in triangles for corner in triangle]
    sizes = [abs(x) for corner in corners for x in corner]
    if not max(sizes) < SANE or not max(sizes) > 1 / SANE:
        return UNDEFINED
    area = 0.0
    for a, b, c in triangles:
        u = [b[i] - a[i] for i in range(3)]
        v = [c[i] - a[i] for i in range(3)]
        cross = [u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)]
        area += math.sqrt(sum(x * x for x in cross)) / 2
    low = " ".join("%.5g" % min(corner[i] for corner in corners) for i in range(3))
    high = " ".join("%.5g" % max(corner[i] for corner in corners) for i in range(3))
    return "%d triangles, box %s to %s, area %.5g" % (len(triangles), low, high, area)


def fan(polygon):
    return [(polygon[0], polygon[i - 1], polygon[i]) for i in range(2, len(polygon))]


def run(command, **options):
    return subprocess.run(command, capture_output=True, timeout=TIMEOUT_S, errors="replace", **options)


def converted(*command):
    """What a program makes of a file as the binary STL "OUT", in words, and what it says on the way."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.stl"
        got = run([out if word == "OUT" else word for word in command])
        said = got.stderr.splitlines()
        if got.returncode != 0 or not out.exists():
            return REFUSED, said
        body = out.read_bytes()[84:]
        rows = struct.iter_unpack("<12f2x", body[: len(body) // 50 * 50])
        return words([(row[3:6], row[6:9], row[9:]) for row in rows]), said


def lamella(tool, path):
    """Rows of the table. Messages name the path, which differs from machine to machine."""
    answer, said = converted(tool, "convert", path, "-o", "OUT")
    if answer == REFUSED:
        return [("lamella", "refused: " + said[-1].removeprefix(f"lamella: {path}: "))]
    return [("lamella", answer)] + [("warns", line.removeprefix(f"lamella: warning: {path}: ")) for line in said]


def assimp(path):
    return converted("assimp", "export", path, "OUT", "-fstlb", "-tri")[0]


def cgal(program, path):
    lines = run([program, path]).stdout.splitlines() or [UNDEFINED]
    rows = [[float(number) for number in line.split()] for line in lines[1:]]
    return words([(row[:3], row[3:6], row[6:]) for row in rows]) if lines[0].endswith(" triangles") else lines[0]


def vtk(path):
    import vtkmodules.vtkIOGeometry as geometry
    import vtkmodules.vtkIOLegacy as legacy
    import vtkmodules.vtkIOPLY as ply
    import vtkmodules.vtkIOXML as xml
    from vtkmodules.vtkCommonCore import vtkObject
    from vtkmodules.vtkFiltersCore import vtkTriangleFilter

    readers = {
        ".stl": geometry.vtkSTLReader,
        ".obj": geometry.vtkOBJReader,
        ".ply": ply.vtkPLYReader,
        ".vtk": legacy.vtkPolyDataReader,
        ".vtp": xml.vtkXMLPolyDataReader,
    }
    if path.suffix not in readers:
        return NO_READER
    vtkObject.GlobalWarningDisplayOff()
    reader = readers[path.suffix]()
    failures = []
    reader.AddObserver("ErrorEvent", lambda *_: failures.append(1))
    reader.SetFileName(str(path))
    triangles = vtkTriangleFilter()
    triangles.SetInputConnection(reader.GetOutputPort())
    triangles.Update()
    mesh = triangles.GetOutput()
    found = []
    for i in range(mesh.GetNumberOfCells()):
        cell = mesh.GetCell(i)
        if cell.GetNumberOfPoints() == 3:
            found.append(tuple(mesh.GetPoint(cell.GetPointId(k)) for k in range(3)))
    return REFUSED if failures or reader.GetErrorCode() != 0 else words(found)


def meshio(path):
    import meshio as library

    if path.suffix not in (".stl", ".obj", ".off", ".ply", ".vtk"):
        return NO_READER
    try:
        mesh = library.read(path)
        points = [tuple(float(x) for x in point) for point in mesh.points]
        faces = [face for block in mesh.cells if block.type in ("triangle", "quad", "polygon") for face in block.data]
        if any(index < 0 for face in faces for index in face):
            return REFUSED
        return words([corners for face in faces for corners in fan([points[i] for i in face])])
    except (Exception, SystemExit):  # what it raises depends on where it gave up
        return REFUSED


def apart(name, path):
    """The answer of a function of this file in a process of its own, as readers crash and hang."""
    try:
        got = run([sys.executable, "-B", __file__, "--one", name, path])
    except subprocess.TimeoutExpired:
        return UNDEFINED
    return got.stdout.splitlines()[-1] if got.returncode == 0 else UNDEFINED


def readers(program):
    """What asks those that are installed, by name."""
    found = {}
    if shutil.which("assimp"):
        found["assimp"] = assimp
    if importlib.util.find_spec("vtkmodules"):
        found["VTK"] = lambda path: apart("vtk", path)
    if program:
        formats = (".stl", ".obj", ".off", ".ply")
        found["CGAL"] = lambda path: cgal(program, path) if path.suffix in formats else NO_READER
    if importlib.util.find_spec("meshio"):
        found["meshio"] = lambda path: apart("meshio", path)
    return found


def rows_of(path, tool, others):
    return [(name, answer(path)) for name, answer in others.items()] + lamella(tool, path)


def read_table():
    table = {}
    for line in TABLE.read_text().splitlines() if TABLE.exists() else []:
        if line.startswith("    "):
            name, _, answer = line.strip().partition(" ")
            table[current].append((name, answer.strip()))
        elif line and not line.startswith("#"):
            current = line
            table[current] = []
    return table


def text_of(table):
    rows = {name: "".join("    %-8s %s\n" % row for row in table[name]) for name in sorted(table)}
    return HEAD + "".join("\n%s\n%s" % entry for entry in rows.items())


def agreed(rows):
    """What two of the others answer, being no refusal; None where there is no such answer."""
    answers = [answer for name, answer in rows if name in OTHERS and "triangles, " in answer]
    return next((answer for answer in answers if answers.count(answer) > 1), None)


def broken_rule(rows):
    if any(name == "why" for name, _ in rows):
        return None
    own = dict(rows)["lamella"]
    answer = agreed(rows)
    if answer and own != answer:
        return "two readers agree on '%s', lamella answers '%s'" % (answer, own)
    if answer and not any(name == "warns" for name, _ in rows):
        return "two readers agree with lamella, which does not warn"
    return None


def merged(old, new, others):
    """The rows of readers that ran, and the old ones of those that are not installed; the reasons stay."""
    kept = {name: answer for name, answer in old if name in OTHERS and name not in others}
    measured = dict(new)
    # What is read from other memory differs from run to run.
    measured.update({name: UNDEFINED for name, answer in old if name in measured and answer == UNDEFINED})
    rows = [(name, measured.get(name, kept.get(name))) for name in OTHERS if name in measured or name in kept]
    return rows + [row for row in new if row[0] not in OTHERS] + [row for row in old if row[0] == "why"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--lamella")
    parser.add_argument("--one", nargs=2, metavar=("READER", "FILE"), help="print the answer of one reader")
    parser.add_argument("--cgal")
    parser.add_argument("--update", action="store_true")
    options = parser.parse_args()
    if options.one:
        print(globals()[options.one[0]](pathlib.Path(options.one[1])))
        return 0

    others = readers(options.cgal)
    for name in OTHERS:
        if name not in others:
            print("skipped: %s is not installed" % name)
    old = read_table()
    table = {}
    for path in sorted(FILES.iterdir()):
        table[path.name] = merged(old.get(path.name, []), rows_of(path, options.lamella, others), others)
    text = text_of(table)
    if options.update:
        TABLE.write_text(text)
    problems = list(difflib.unified_diff(TABLE.read_text().splitlines(), text.splitlines(), "table", "now", lineterm=""))
    problems += ["%s: %s" % (name, rule) for name, rows in table.items() if (rule := broken_rule(rows))]
    print("\n".join(problems))
    print("%d files, %d readers beside lamella, %d lines of problems" % (len(table), len(others), len(problems)))
    return 1 if problems or not table else 0


if __name__ == "__main__":
    sys.exit(main())
