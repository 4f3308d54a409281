"""Files cut in pieces, in bounded memory."""

import csv
import subprocess
import sys
import threading

import numpy as np
import pytest

import lamella
from support import TOOL, needs_tool, write_off, write_stl

SHAPE = dict(layer_height=0.1, stitch="auto")


@pytest.fixture
def file(torus, tmp_path):
    vertices, faces = torus
    write_stl(tmp_path / "torus.stl", vertices[faces])
    return tmp_path / "torus.stl"


@pytest.mark.parametrize("memory", [None, "2M", 1_300_000])
def test_a_stream_of_a_file_has_the_layers_of_the_whole(file, memory):
    whole = lamella.slice(file, **SHAPE)
    chunks = list(lamella.stream(file, memory=memory, chunk=50, **SHAPE))
    assert [chunk.first_layer for chunk in chunks] == np.cumsum([0, *map(len, chunks[:-1])]).tolist()
    assert max(map(len, chunks)) <= 50
    assert np.array_equal(np.concatenate([chunk.points_grid for chunk in chunks]), whole.points_grid)
    assert np.array_equal(np.concatenate([chunk.areas for chunk in chunks]), whole.areas)
    for name in ("role", "orientation", "flags", "point_count"):
        assert np.array_equal(np.concatenate([chunk.contours[name] for chunk in chunks]), whole.contours[name])
    parents = [layer.contours["parent"] - layer.contours["first_point"] * 0 for layer in chunks[-1]]
    assert (np.concatenate(parents) < len(chunks[-1].contours)).all()


def test_files_that_cannot_be_read_in_pieces_are_read_whole(torus, tmp_path):
    write_off(tmp_path / "torus.off", *torus)
    whole = lamella.slice(tmp_path / "torus.off", **SHAPE)
    chunks = list(lamella.stream(tmp_path / "torus.off", memory="1M", chunk=100, **SHAPE))
    assert np.array_equal(np.concatenate([chunk.points_grid for chunk in chunks]), whole.points_grid)
    with pytest.raises(lamella.InvalidArgumentError, match="read in pieces"):
        lamella.stream(tmp_path / "torus.off").save_table(tmp_path / "a.csv")


def test_a_stream_ends_early(file):
    before = threading.active_count()
    with lamella.stream(file, chunk=3, **SHAPE) as layers:
        first = next(layers)
        assert len(first) == 3
    assert threading.active_count() == before
    assert list(layers) == []
    seen = []
    with pytest.raises(ZeroDivisionError):
        for chunk in lamella.stream(file, chunk=3, progress=lambda fraction: seen.append(fraction) or 1 / 0, layer_height=0.001):
            assert len(chunk) > 0
    assert threading.active_count() == before


def test_errors_of_a_stream_name_the_file(file, tmp_path):
    for path, kind in ((tmp_path / "none.stl", lamella.UnreadableFileError), (tmp_path / "cut.stl", lamella.MalformedMeshError)):
        (tmp_path / "cut.stl").write_bytes(file.read_bytes()[:-7])
        with pytest.raises(kind) as caught:
            list(lamella.stream(path, memory="1M", **SHAPE))
        assert caught.value.path == str(path)
    with pytest.raises(lamella.InvalidArgumentError, match="memory must be"):
        lamella.stream(file, memory="much")
    with pytest.raises(lamella.OutOfMemoryError):
        list(lamella.stream(file, memory=1000, **SHAPE))


def test_a_table_of_a_stream_is_that_of_the_whole(file, torus, tmp_path):
    lamella.stream(file, memory="1M", **SHAPE).save_table(tmp_path / "a.csv", islands=True)
    lamella.save_table(tmp_path / "b.csv", {"torus": lamella.slice(file, **SHAPE)}, islands=True)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    with open(tmp_path / "a.csv", newline="") as table:
        assert len(list(csv.DictReader(table))) > 100
    with pytest.raises(lamella.InvalidArgumentError, match="writes no table"):
        lamella.stream(*torus).save_table(tmp_path / "c.csv")


@pytest.mark.parametrize(("coverage", "subslices"), [(False, 1), (True, 1), (True, 3)])
@pytest.mark.parametrize("step", [1.25, -0.03])
@pytest.mark.parametrize("given", [str, lamella.read])
def test_a_mask_of_a_stream_is_that_of_the_whole(file, given, coverage, subslices, step):
    affine = np.array([[0.8, 0, 0.1, -25], [0, 1, 0, -7], [0.6, 0, step, -2], [0, 0, 0, 1]])  # oblique, sheared, of either hand
    how = dict(like=((60, 14, 40), affine), frame="ras", coverage=coverage, subslices=subslices)
    mesh, out = given(file), np.full((60, 14, 40), 7, np.uint8, order="F")
    with pytest.warns(lamella.MeshWarning, match="beside the image") as told:
        whole = lamella.mask(mesh, stitch=0, **how)
        drawn = lamella.stream(mesh, memory="2M", stitch=0, chunk=7).mask(out=out, **how)
    assert len(told) == 2 and str(told[0].message) == str(told[1].message)
    assert drawn.array is out and np.array_equal(out, whole.array) and 0 < np.count_nonzero(out) < out.size
    assert drawn.voxels == whole.voxels and drawn.labels == {1: "torus"} and np.array_equal(drawn.affine, whole.affine)


def test_what_a_mask_of_a_stream_cannot_be_is_refused(file, torus, tmp_path):
    image = (50, 50, 50), np.eye(4)
    with pytest.raises(lamella.InvalidArgumentError, match="layer_height is an option of slice"):
        lamella.stream(file, layer_height=1).mask(like=image, frame="ras")
    with pytest.raises(lamella.InvalidArgumentError, match="torus: states no patient frame"):
        lamella.stream(file).mask(like=image)
    with pytest.raises(lamella.InvalidArgumentError, match="by mask.., alone"):
        lamella.save_mask(tmp_path / "a.nii", lamella.stream(file), like=image, frame="ras")
    with pytest.raises(lamella.OutOfMemoryError):
        lamella.stream(file, memory=1000).mask(like=image, frame="ras")
    write_stl(tmp_path / "holed.stl", torus[0][torus[1]][:-40])
    with pytest.raises(lamella.InvalidArgumentError, match="holed: .*stitch="):
        lamella.stream(tmp_path / "holed.stl", stitch=0).mask(like=image, frame="ras", strict=True)


def test_open_layers_of_a_stream_are_told_once(torus, tmp_path):
    vertices, faces = torus
    write_stl(tmp_path / "holed.stl", vertices[faces][:-40])
    with pytest.warns(lamella.MeshWarning, match="open contours") as told:
        list(lamella.stream(tmp_path / "holed.stl", chunk=5, layer_height=0.1, stitch=0))
    assert len(told) == 1


@needs_tool
@pytest.mark.skipif(sys.platform != "linux", reason="the peak is read from /proc")
@pytest.mark.parametrize("call", ["(layer_height=0.05); found = sum(map(len, s))", "(); found = s.mask(like=((400, 400, 100), numpy.eye(4)), frame='ras').voxels[0]"])
def test_the_peak_of_a_stream_is_its_budget(tmp_path, call):
    """Of a file of 50 MB within 20 MB: what the process holds beyond the interpreter and its packages."""
    mesh = tmp_path / "bone.stl"
    subprocess.run([TOOL, "make", "bone", "--triangles", "1000000", "-o", str(mesh)], check=True)
    program = f"""
import functools, sys, lamella, numpy
def peak():
    return next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM")) / 1000
before = peak()
s = functools.partial(lamella.stream, sys.argv[1], memory="20M"){call}
print(found, peak() - before)
"""
    told = subprocess.run([sys.executable, "-c", program, str(mesh)], check=True, capture_output=True, text=True).stdout
    found, megabytes = told.split()
    assert int(found) > 300 and float(megabytes) < 1.1 * 20 + 60 + 16 * ("mask" in call)
