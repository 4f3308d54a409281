#!/usr/bin/python3
"""Compares what readers make of the sloppy files in files/ with the committed table answers.txt.

    answers.py --lamella PROGRAM [--cgal PROGRAM]            checks the rows of the readers that are installed
    answers.py --lamella PROGRAM [--cgal PROGRAM] --update   writes them

Fails too where lamella breaks the rule: what two of the other readers agree on is lamella's answer, and lamella warns.
A line "why" in the table says why a file is an exception. assimp, VTK and meshio are used where Debian's packages
assimp-utils, python3-vtk9 and python3-meshio are installed, CGAL where libcgal-dev was at build time.
"""

import argparse
import importlib.util
import math
import os
import pathlib
import shutil
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


def told(command):
    """What answer_lamella or answer_cgal prints, with the triangles in words."""
    lines = run(command).stdout.splitlines()
    if not lines or not lines[0].endswith(" triangles"):
        return lines or [UNDEFINED]
    end = 1 + int(lines[0].split()[0])
    numbers = [[float(number) for number in line.split()] for line in lines[1:end]]
    return [words([(row[:3], row[3:6], row[6:]) for row in numbers])] + lines[end:]


def assimp(path):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.ply")
        got = run(["assimp", "export", str(path), out, "-fply", "-tri"])
        if got.returncode != 0 or not os.path.exists(out):
            return REFUSED
        head, body = pathlib.Path(out).read_text().split("end_header\n")
    counts = [int(line.split()[2]) for line in head.splitlines() if line.startswith("element")]
    rows = [line.split() for line in body.splitlines()]
    points = [[float(number) for number in row[:3]] for row in rows[: counts[0]]]
    faces = [[int(number) for number in row[1:]] for row in rows[counts[0] :]]
    return words([corners for face in faces for corners in fan([points[i] for i in face])])


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
    import contextlib
    import io

    import meshio as library

    if path.suffix not in (".stl", ".obj", ".off", ".ply", ".vtk"):
        return NO_READER
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            mesh = library.read(path)
        points = [tuple(float(x) for x in point) for point in mesh.points]
        faces = [face for block in mesh.cells if block.type in ("triangle", "quad", "polygon") for face in block.data]
        if any(index < 0 for face in faces for index in face):
            return REFUSED
        return words([corners for face in faces for corners in fan([points[i] for i in face])])
    except (Exception, SystemExit):  # what it raises depends on where it gave up
        return REFUSED


def apart(answer, path):
    """answer(path) in a process of its own, as readers crash and hang."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(out)
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        try:
            import signal

            signal.alarm(TIMEOUT_S)
            os.write(into, answer(path).encode())
        finally:
            os._exit(0)
    os.close(into)
    with os.fdopen(out) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return text or UNDEFINED


def is_installed(module):
    return importlib.util.find_spec(module) is not None


def readers(cgal):
    """What asks those that are installed, by name."""
    found = {}
    if shutil.which("assimp"):
        found["assimp"] = assimp
    if is_installed("vtkmodules"):
        import vtkmodules.vtkFiltersCore  # imported once, for all processes
        import vtkmodules.vtkIOGeometry
        import vtkmodules.vtkIOLegacy
        import vtkmodules.vtkIOPLY
        import vtkmodules.vtkIOXML

        found["VTK"] = lambda path: apart(vtk, path)
    if cgal:
        formats = (".stl", ".obj", ".off", ".ply")
        found["CGAL"] = lambda path: told([cgal, str(path)])[0] if path.suffix in formats else NO_READER
    if is_installed("meshio"):
        import meshio as library  # noqa: F401

        found["meshio"] = lambda path: apart(meshio, path)
    return found


def rows_of(path, lamella, others):
    rows = [(name, answer(path)) for name, answer in others.items()]
    lines = told([lamella, str(path)])
    return rows + [("lamella", lines[0])] + [("warns", line) for line in lines[1:]]


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


def write_table(table):
    with open(TABLE, "w") as out:
        out.write(HEAD)
        for name in sorted(table):
            out.write("\n" + name + "\n")
            for reader, answer in table[name]:
                out.write("    %-8s %s\n" % (reader, answer))


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
    parser.add_argument("--lamella", required=True)
    parser.add_argument("--cgal")
    parser.add_argument("--update", action="store_true")
    options = parser.parse_args()

    others = readers(options.cgal)
    for name in OTHERS:
        if name not in others:
            print("skipped: %s is not installed" % name)
    old = read_table()
    table = {}
    for path in sorted(FILES.iterdir()):
        table[path.name] = merged(old.get(path.name, []), rows_of(path, options.lamella, others), others)
    if options.update:
        write_table(table)
        old = table
    problems = []
    for name in sorted(set(old) | set(table)):
        before, now = old.get(name, []), table.get(name, [])
        problems += ["%s: the table has '%s %s'" % (name, *row) for row in before if row not in now]
        problems += ["%s: now '%s %s'" % (name, *row) for row in now if row not in before]
        rule = broken_rule(now) if now else None
        problems += ["%s: %s" % (name, rule)] if rule else []
    print("\n".join(problems))
    print("%d files, %d readers beside lamella, %d problems" % (len(table), len(others), len(problems)))
    return 1 if problems or not table else 0


if __name__ == "__main__":
    sys.exit(main())
