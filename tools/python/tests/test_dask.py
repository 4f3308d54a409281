"""Many meshes: what lamella.dask asks of a scheduler, and what it makes of answers. A real scheduler is in tests/cluster."""

import concurrent.futures
import os
import stat

import numpy as np
import pytest

import lamella
import lamella.dask

TOOL = os.environ.get("LAMELLA_TOOL")
needs_tool = pytest.mark.skipif(TOOL is None, reason="LAMELLA_TOOL does not name the command line tool")


class Client:
    """Runs what is submitted at once, and tries again what fails, as a scheduler with one worker does."""

    def __init__(self, **resources):
        self.workers = {"tcp://worker": {"resources": resources}} if resources else {}
        self.submitted = []

    def scheduler_info(self):
        return {"workers": self.workers}

    def submit(self, function, *arguments, key, retries, resources):
        self.submitted.append({"key": key, "resources": resources})
        future = concurrent.futures.Future()
        for last in [False] * retries + [True]:
            try:
                future.set_result(function(*arguments))
                break
            except Exception as error:
                if last:
                    future.set_exception(error)
        return future


@pytest.fixture
def folder(torus, cube, tmp_path, monkeypatch):
    """Two meshes and a file that is none."""
    for name, (vertices, faces) in {"torus.off": torus, "cube.off": cube}.items():
        rows = [" ".join(map(str, vertex)) for vertex in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
        (tmp_path / name).write_text("\n".join(["OFF", f"{len(vertices)} {len(faces)} 0", *rows]) + "\n")
    (tmp_path / "bad.stl").write_bytes(b"solid\nfacet")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def program(path, text):
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@needs_tool
def test_a_row_and_an_output_for_each_mesh(folder):
    many = lamella.dask.slice_many(Client(), ["torus.off", "bad.stl", "cube.off"], "out/{stem}.csv", tool=TOOL, layer_height=0.5)
    rows = many.rows()
    assert [row["mesh"] for row in rows] == ["torus.off", "bad.stl", "cube.off"]
    assert rows[0]["hash"] == lamella.slice("torus.off", layer_height=0.5).hash
    assert rows[2]["volume_mm3"] == pytest.approx(1000)
    assert [row["reason"] == "" for row in rows] == [True, False, True]
    assert "bad.stl" in rows[1]["reason"]
    assert sorted(path.name for path in (folder / "out").glob("*.csv")) == ["cube.csv", "cube.meshes.csv", "torus.csv", "torus.meshes.csv"]
    frame = pytest.importorskip("pandas").DataFrame(rows)
    assert many.frame().equals(frame)
    assert repr(many) == "<lamella.dask.Many: 3 of 3 meshes>"


@needs_tool
def test_options_are_those_of_the_tool(folder):
    names = {"fill_rule": "non-zero", "planes": [-1, 2.5, 7], "largest_only": True, "strict": False, "normal": None, "offset": -0.25}
    lamella.dask.slice_many(Client(), ["torus.off"], "t.csv", tool=TOOL, **names).rows()
    expected = lamella.slice("torus.off", fill_rule="non-zero", heights=[-1, 2.5, 7], largest_only=True, offset=-0.25)
    areas = np.genfromtxt("t.csv", delimiter=",", names=True, dtype=None, encoding=None)["area_mm2"]
    assert areas == pytest.approx(expected.areas)
    (row,) = lamella.dask.slice_many(Client(), ["torus.off"], "t.csv", tool=TOOL, layer_hight=1).rows()
    assert "--layer-hight" in row["reason"]
    with pytest.raises(lamella.InvalidArgumentError, match="layer_height must be a number"):
        lamella.dask.slice_many(Client(), ["torus.off"], "t.csv", layer_height={})


def test_what_is_lost_is_tried_again(folder):
    killed = program(folder / "killed", "echo x >> tries; kill -9 $$\n")
    (row,) = lamella.dask.slice_many(Client(), ["cube.off"], "c.svg", tool=killed, retries=2).rows()
    assert row["reason"] == "killed by signal 9"
    assert (folder / "tries").read_text() == "x\n" * 3
    refused = program(folder / "refused", "echo y >> refusals; echo lamella: no mesh >&2; exit 3\n")
    (row,) = lamella.dask.slice_many(Client(), ["cube.off"], "c.svg", tool=refused, retries=2).rows()
    assert (row["reason"], (folder / "refusals").read_text()) == ("no mesh", "y\n")
    full = program(folder / "full", "test -e once && { echo '{}'; exit 0; }; touch once; exit 4\n")
    assert lamella.dask.slice_many(Client(), ["cube.off"], "c.svg", tool=full, retries=1).rows()[0]["reason"] == ""
    slow = program(folder / "slow", "exec sleep 60\n")
    many = lamella.dask.slice_many(Client(), ["cube.off"], "c.svg", tool=slow, timeout=0.1, retries=0)
    assert many.rows()[0]["reason"] == "not done after 0.1 s"
    with pytest.raises(lamella.dask.LostItemError):
        many.futures[0].result()
    many = lamella.dask.slice_many(Client(), ["cube.off"], "c.svg", tool="no-such-program", retries=0)
    assert many.rows()[0]["reason"] == "the worker has no program 'no-such-program'"


def test_meshes_ask_for_the_memory_of_a_worker(folder):
    def asked(client, **keywords):
        lamella.dask.slice_many(client, ["torus.off", "none.stl"], "{stem}.svg", tool="no-such-program", retries=0, **keywords)
        return [task["resources"] for task in client.submitted]

    assert asked(Client()) == asked(Client(GPU=1)) == asked(Client(MEMORY=8e9), memory=None) == [None, None]
    estimate = 256 * 2**20 + 4 * (folder / "torus.off").stat().st_size
    assert asked(Client(MEMORY=8e9)) == [{"MEMORY": estimate}, {"MEMORY": 256 * 2**20}]
    assert asked(Client(MEMORY=1e6)) == [{"MEMORY": 1_000_000}] * 2
    assert asked(Client(MEMORY=8e9), memory=5_000) == [{"MEMORY": 5_000}] * 2
    assert asked(Client(), memory=len) == [{"MEMORY": 9}, {"MEMORY": 8}]
    for client in (Client(MEMORY=1e6), Client(GPU=1)):
        with pytest.raises(lamella.InvalidArgumentError, match="no worker has MEMORY=2000000"):
            asked(client, memory=2_000_000)
    with pytest.raises(lamella.InvalidArgumentError, match="'all'"):
        asked(Client(), memory="all")


def test_two_meshes_may_not_share_an_output(folder):
    with pytest.raises(lamella.InvalidArgumentError, match=r"a/x.stl and b/x.STL.gz have one output: x.svg"):
        lamella.dask.slice_many(Client(), ["a/x.stl", "b/x.STL.gz"], "{stem}.svg")
    with pytest.raises(lamella.InvalidArgumentError, match="must contain {stem}"):
        lamella.dask.slice_many(Client(), ["a.stl", "b.stl"], "x.svg")
