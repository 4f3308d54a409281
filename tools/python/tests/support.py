"""Helpers of several tests and their child processes, which import this module when they are spawned."""

import os

import numpy as np
import pytest

import lamella

TOOL = os.environ.get("LAMELLA_TOOL")
needs_tool = pytest.mark.skipif(TOOL is None, reason="LAMELLA_TOOL does not name the command line tool")


def hash_of(mesh):
    return lamella.slice(*mesh, layer_height=0.05).hash


def answer(mesh, answers):
    try:
        answers.put(hash_of(mesh))
    except BaseException as error:  # so that the parent need not wait in vain
        answers.put(repr(error))


def led(faces, row=0, corners=3):
    """Faces as VTK has them; that one says that it has so many corners."""
    flat = np.insert(faces, 0, 3, axis=1)
    flat[row, 0] = corners
    return flat


def write_off(path, vertices, faces):
    rows = [" ".join(map(repr, vertex)) for vertex in vertices.tolist()] + [f"3 {a} {b} {c}" for a, b, c in faces.tolist()]
    path.write_text("\n".join(["OFF", f"{len(vertices)} {len(faces)} 0", *rows]) + "\n")


def write_stl(path, triangles):
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows["corners"] = triangles
    with open(path, "wb") as file:
        file.write(b"\0" * 80 + np.uint32(len(rows)).tobytes() + rows.tobytes())
