"""The package's types, and what they say of programs that use it."""

import pathlib
import subprocess
import sys

import pytest

import lamella

pytest.importorskip("mypy")

PACKAGE = pathlib.Path(lamella.__file__).parent

RIGHT = """
import distributed
import numpy as np
import numpy.typing as npt
import lamella
import lamella.dask

result: lamella.Result = lamella.slice("liver.stl", layer_height=0.1, fill_rule="non-zero", progress=True)
areas: npt.NDArray[np.float64] = result.areas
first: float = result[0].z
layers: list[lamella.Layer] = result[2:5]
mesh: lamella.Mesh = lamella.read("liver.stl")
again: lamella.Result = lamella.prepare(mesh).slice([1.0, 2.0], threads=2)
joined: lamella.Layer = lamella.region_of([mesh.vertices[:, :2]], fill_rule="even-odd", offset=0.1)
for chunk in lamella.stream(mesh.vertices, mesh.faces, layer_height=0.01, chunk=64):
    total: float = chunk.volume
cut: lamella.Layer = lamella.section(mesh, origin=[0, 0, 1], normal=[0, 1, 1], stitch=0.1)
edges: int = lamella.check(mesh)["boundary_edges"].count

def table(client: distributed.Client) -> list[dict[str, object]]:
    return lamella.dask.slice_many(client, ["liver.stl"], "{stem}.svg", retries=1, layer_height=0.1).rows()
"""

# Each with what mypy must say of it.
WRONG = [
    ('lamella.slice("liver.stl", layer_hight=0.1)', 'Unexpected keyword argument "layer_hight"'),
    ('lamella.slice("liver.stl", layer_height="thin")', 'Argument "layer_height"'),
    ('lamella.section("liver.stl", origin=[0, 0, 0], normal=[0, 0, 1], layer_height=1)', '"layer_height"'),
    ('lamella.slice("liver.stl").area', '"Result" has no attribute "area"'),
    ('x: str = lamella.slice("liver.stl")[0].z', "Incompatible types in assignment"),
]


def test_types_of_the_package_and_programs(tmp_path):
    (tmp_path / "right.py").write_text(RIGHT)
    (tmp_path / "wrong.py").write_text("import lamella\n" + "\n".join(line for line, _ in WRONG) + "\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--enable-incomplete-feature=Unpack"]
    files = [PACKAGE.name, tmp_path / "right.py", tmp_path / "wrong.py"]
    run = subprocess.run([*command, "--cache-dir", tmp_path / "cache", *files], cwd=PACKAGE.parent, capture_output=True, text=True, check=False)
    said = [line for line in run.stdout.splitlines() if ": error: " in line]
    assert [line for line in said if "wrong.py" not in line] == []
    for row, (line, words) in enumerate(WRONG, start=2):
        assert any(f"wrong.py:{row}:" in told and words in told for told in said), (line, run.stdout + run.stderr)
