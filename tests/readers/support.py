"""What the tests of readers share."""

import importlib
import pathlib
import struct
import subprocess
import sys
import tempfile


def skip(why):
    print("not tested:", why)
    sys.exit(77)


def need(*names):
    """The modules; the test is skipped where one is missing."""
    try:
        modules = [importlib.import_module(name) for name in names]
    except ImportError as error:
        skip(error)
    return modules[0] if len(modules) == 1 else modules


class Run:
    """The tool, in a folder of its own."""

    def __init__(self, folder):
        self.folder = folder
        self.lamella = str(pathlib.Path(sys.argv[1]).resolve())

    def __call__(self, *words, status=0, says=""):
        done = subprocess.run([self.lamella, *words], cwd=self.folder, check=False, capture_output=True, text=True)
        if "without PNG" in done.stderr:
            skip(done.stderr.strip())
        assert done.returncode == status and says in done.stderr, (words, done.returncode, done.stdout + done.stderr)
        assert status == 0 or done.stderr.count("\n") == 1, done.stderr


def main(test):
    """test(run) with a Run in a folder that goes away afterwards; says what it returns."""
    with tempfile.TemporaryDirectory() as name:
        print("passed", test(Run(pathlib.Path(name))) or "")


def box(low, high, inward=False):
    """The triangles of a box."""
    corner = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    turn = (0, 2, 1) if inward else (0, 1, 2)
    return [[corner[t[i]] for i in turn] for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]


def stl(triangles):
    """A binary STL file."""
    data = b"".join(struct.pack("<12fH", 0, 0, 0, *[x for v in t for x in v], 0) for t in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + data


def box_stl(low, high):
    return stl(box(low, high))
