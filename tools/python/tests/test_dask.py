"""Many meshes: what lamella.dask asks of a scheduler, and what it makes of answers. A real scheduler is in tests/cluster."""

import concurrent.futures
import json
import os
import subprocess

import numpy as np
import pytest
from support import TOOL, needs_tool, write_off

import lamella
import lamella.dask


class Client:
    """Runs what is submitted at once, and tries again what fails, as a scheduler with one worker does."""

    def __init__(self, **resources):
        self.workers = {"tcp://worker": {"resources": resources}} if resources else {}
        self.submitted = []

    def scheduler_info(self):
        return {"workers": self.workers}

    def submit(self, function, *arguments, key, retries=0, resources=None):
        self.submitted.append((key, resources))
        future = concurrent.futures.Future()
        for last in [False] * retries + [True]:
            try:
                future.set_result(function(*[self._value(argument) for argument in arguments]))
                break
            except Exception as error:
                if last:
                    future.set_exception(error)
        return future

    def _value(self, argument):
        if isinstance(argument, list):
            return [self._value(each) for each in argument]
        return argument.result() if isinstance(argument, concurrent.futures.Future) else argument


@pytest.fixture
def folder(torus, cube, tmp_path, monkeypatch):
    """Two meshes and a file that is none."""
    for name, (vertices, faces) in {"torus.off": torus, "cube.off": cube}.items():
        write_off(tmp_path / name, vertices, faces)
    (tmp_path / "bad.stl").write_bytes(b"solid\nfacet")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def listing(folder):
    return sorted(path.name for path in folder.iterdir())


@needs_tool
def test_a_row_and_an_output_for_each_mesh(folder):
    paths = ["torus.off", "bad.stl", "cube.off"]
    many = lamella.dask.slice_many(Client(), paths, "out/{stem}.svg", tool=TOOL, layer_height=0.5)
    rows = many.rows()
    assert [row["mesh"] for row in rows] == paths
    assert [row["status"] for row in rows] == ["done", "failed", "done"]
    assert rows[0]["layers"] == len(lamella.slice("torus.off", layer_height=0.5))
    assert rows[1]["reason"] != ""
    assert listing(folder / "out") == ["cube.svg", "results.jsonl", "torus.svg"]
    subprocess.run([TOOL, "batch", *paths, "-o", "alone/{stem}.svg", "--layer-height=0.5"], capture_output=True, check=False)
    for name in ("cube.svg", "torus.svg"):
        assert (folder / "out" / name).read_bytes() == (folder / "alone" / name).read_bytes()
    lines = (folder / "alone/results.jsonl").read_text().replace('"alone/', '"out/')
    assert (folder / "out/results.jsonl").read_text() == lines
    assert sorted(rows, key=lambda row: row["mesh"]) == [json.loads(line) for line in lines.splitlines()]
    assert repr(many) == "<lamella.dask.Many: 3 of 3 meshes>"
    pytest.importorskip("pandas")
    assert many.frame()["status"].tolist() == ["done", "failed", "done"]
    assert len(lamella.dask.slice_many(Client(), [], "out/{stem}.svg", tool=TOOL).frame()) == 0


@needs_tool
def test_what_is_done_is_not_done_again(folder):
    def inode_after(paths, **options):
        rows = lamella.dask.slice_many(Client(), paths, "{stem}.svg", tool=TOOL, **options).rows()
        assert all(row["status"] == "done" for row in rows)
        return (folder / "cube.svg").stat().st_ino

    first = inode_after(["cube.off"])
    assert inode_after(["torus.off", "cube.off"]) == first
    assert inode_after(["cube.off"], layer_height=1) != first
    # A leftover of an earlier run by another division, which did not come to its end.
    (folder / "results.0-of-7.jsonl").write_text("")
    name = os.fsdecode(b'a "b", gr\xfc\xdfe\n.off')  # any file name will do
    os.rename("torus.off", name)
    inode_after(["cube.off", name], force=True)


@needs_tool
def test_options_are_those_of_the_tool(folder):
    names = {"fill_rule": "non-zero", "planes": [-1, 2.5, 7], "largest_only": True, "strict": False, "normal": None, "offset": -1}
    lamella.dask.slice_many(Client(), ["torus.off"], "{stem}.csv", tool=TOOL, results=folder / "log", **names).rows()
    expected = lamella.slice("torus.off", fill_rule="non-zero", heights=[-1, 2.5, 7], largest_only=True, offset=-1)
    areas = np.genfromtxt("torus.csv", delimiter=",", names=True, dtype=None, encoding=None)["area_mm2"]
    assert (areas == pytest.approx(expected.areas), listing(folder / "log")) == (True, ["results.jsonl"])
    with pytest.raises(lamella.InvalidArgumentError, match="layer_height must be a number"):
        lamella.dask.slice_many(Client(), ["torus.off"], "t.csv", layer_height={})


WRONG = [
    (["torus.off"], "{stem}.csv", {"layer_hight": 1}, "--layer-hight"),
    (["torus.off"], "{stem}.nii", {"like": "none.nii", "frame": "lps"}, "none.nii"),
    (["torus.off", "sub/torus.off"], "{stem}.csv", {}, "'torus.csv' is written for 'torus.off' too"),
]


@needs_tool
@pytest.mark.parametrize("paths, output, options, words", WRONG)
def test_what_is_wrong_for_all_is_an_error_of_the_call(folder, paths, output, options, words):
    many = lamella.dask.slice_many(Client(), paths, output, tool=TOOL, **options)
    with pytest.raises(lamella.InvalidArgumentError, match=words):
        many.rows()


def test_what_is_lost_is_tried_again(folder):
    def begun(words, retries=0):
        """By a program of these words, where there are any."""
        path = folder / "program"
        if words:
            path.write_text(f"#!/bin/sh\n{words}\n")
            path.chmod(0o755)
        tool = str(path) if words else "no-such-program"
        return lamella.dask.slice_many(Client(), ["cube.off"], "{stem}.svg", tool=tool, retries=retries)

    many = begun("echo x >> tries; kill -9 $$", retries=2)
    assert many.rows() == [{"mesh": "cube.off", "status": "failed", "reason": "the batch was killed by signal 9"}]
    assert (folder / "tries").read_text() == "x\n" * 3
    with pytest.raises(lamella.dask.LostItemError):
        many.futures[0].result()
    with pytest.raises(lamella.InvalidArgumentError, match="^no such option$"):
        begun("echo lamella: no such option >&2; exit 2").rows()
    assert begun("echo lamella: no space left >&2; exit 4").rows()[0]["reason"] == "no space left"
    assert begun("").rows()[0]["reason"] == "the worker has no program 'no-such-program'"


def test_meshes_ask_for_the_memory_of_a_worker(folder):
    def asked(client, **keywords):
        lamella.dask.slice_many(client, ["torus.off", "none.stl"], "{stem}.svg", tool="no-such-program", retries=0, **keywords)
        return [resources for key, resources in client.submitted if key[-1].isdigit()]

    assert asked(Client()) == asked(Client(GPU=1)) == asked(Client(MEMORY=8e9), memory=None) == [None, None]
    estimate = 256 * 2**20 + 4 * (folder / "torus.off").stat().st_size
    assert asked(Client(MEMORY=8e9)) == [{"MEMORY": estimate}, {"MEMORY": 256 * 2**20}]
    assert asked(Client(MEMORY=1e6)) == [{"MEMORY": 1_000_000}] * 2
    assert asked(Client(MEMORY=8e9), memory=5_000) == [{"MEMORY": 5_000}] * 2
    assert asked(Client(MEMORY=8e9), memory=len) == [{"MEMORY": 9}, {"MEMORY": 8}]
    for client in (Client(MEMORY=1e6), Client(GPU=1)):
        with pytest.raises(lamella.InvalidArgumentError, match="no worker has MEMORY=2000000"):
            asked(client, memory=2_000_000)
    with pytest.raises(lamella.InvalidArgumentError, match="'all'"):
        asked(Client(), memory="all")
