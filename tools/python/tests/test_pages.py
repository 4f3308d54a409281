"""README, the pages on Python, the notebook and the examples in docstrings run, and are true; so are the types."""

import doctest
import importlib
import json
import pathlib
import pkgutil
import re
import subprocess
import sys

import numpy as np
import pytest
from support import needs_tool, write_off, write_stl

import lamella

MODULES = ["lamella", *(f"lamella.{module.name}" for module in pkgutil.iter_modules(lamella.__path__) if module.name != "_native")]
NOTEBOOKS = pathlib.Path(__file__).resolve().parents[1] / "examples"
ROOT = pathlib.Path(__file__).resolve().parents[3]


def run(text, path):
    """Runs a program in Python; its names."""
    names = {"__name__": "page", "__file__": str(path)}
    exec(compile(text, str(path), "exec"), names)
    return names


@pytest.fixture
def names_of(torus, tmp_path, monkeypatch, matplotlib):
    """Runs a page's blocks in Python, in a folder with the mesh that the pages cut."""
    for name in ("bone.stl", "part.stl"):
        write_stl(tmp_path / name, torus[0][torus[1]])
    monkeypatch.chdir(tmp_path)

    def names_of_page(name, least):
        blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / name).read_text(), flags=re.MULTILINE | re.DOTALL)
        assert len(blocks) >= least
        return run("".join(blocks), ROOT / name)

    return names_of_page


def test_readme_plots_areas_over_height(names_of, capsys, tmp_path):
    names = names_of("README.md", 1)
    assert (tmp_path / "areas.png").stat().st_size > 1000
    assert capsys.readouterr().out.startswith("<lamella.Result: 540 layers")
    assert len(names["s"].areas) == 540


def test_the_page_on_python_is_true(names_of, capsys, tmp_path):
    names = names_of("tools/docs/python.md", 5)
    assert "faces[0] = [" in capsys.readouterr().out
    assert names["holes_per_layer"].tolist() == [int((layer.contours["role"] == lamella.Role.HOLE).sum()) for layer in names["s"]]
    assert len(names["outline"]) == names["longest"]["point_count"]
    assert {"bone.svg", "bone.json"} <= {path.name for path in tmp_path.iterdir()}


def test_the_page_from_layers_to_walls_draws_its_pictures(names_of, capsys, tmp_path):
    names = names_of("tools/docs/walls.md", 6)
    shown = re.findall(r"\(../pictures/(walls_\w+.png)\)", (ROOT / "tools/docs/walls.md").read_text())
    assert len(shown) == 6
    for name in shown:
        assert (ROOT / "tools/pictures" / name).exists()
        assert (tmp_path / name).stat().st_size > 1000
    assert capsys.readouterr().out == "4 islands begin, 2 merge others\n"
    assert set(names["walls"].contours["part"]) == {0, 1, 2, 3}
    assert set(names["skins"].contours["part"]) >= {0, 1, 2}


def test_the_gallery_draws_its_pictures(torus, tmp_path, matplotlib):
    path = ROOT / "tools/python/examples/gallery.py"
    write_off(tmp_path / "torus.off", torus[0] * [1, 1, 1.5], torus[1])  # with a long axis
    drawn = run(path.read_text(), path)["main"](tmp_path / "torus.off", tmp_path)
    shown = re.findall(r"\(../pictures/(python_\w+.png)\)", (ROOT / "tools/docs/gallery.md").read_text())
    assert drawn == shown
    for name in shown:
        assert (ROOT / "tools/pictures" / name).exists()
        assert (tmp_path / name).stat().st_size > 1000


def run_notebook(name):
    """The names of its cells."""
    path = NOTEBOOKS / name
    cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)  # none are committed
    return run("\n".join("".join(cell["source"]) for cell in cells), path)


def test_the_notebook_of_first_steps_runs(capsys, matplotlib):
    names = run_notebook("first_steps.ipynb")
    told = capsys.readouterr().out
    assert "certificate holds" in told
    assert "3 boundary edges" in told
    assert names["volume"] == pytest.approx(names["s"].volume, rel=1e-3)
    assert (names["difference"] > 0).all()


@needs_tool
def test_the_notebook_of_bones_leads_to_figure_mask_and_structure_set(tmp_path, monkeypatch, capsys, matplotlib):
    pydicom = pytest.importorskip("pydicom")
    pytest.importorskip("pandas")
    monkeypatch.chdir(tmp_path)
    names = run_notebook("bones.ipynb")
    assert "Dice 0.9" in capsys.readouterr().out
    assert (tmp_path / "bones.png").stat().st_size > 1000 and (tmp_path / "bones.seg.nrrd").exists()
    for t in names["tables"].values():
        assert (t.imax >= t.imin).all() and (t.outer_area >= t.area).all() and t.known.all()
    solid = sum(bone.volume for bone in names["bones"].values()) - np.count_nonzero(names["mask"].array) - names["mask"].overlaps
    assert abs(solid) < 0.02 * sum(bone.volume for bone in names["bones"].values())
    slices = {pydicom.dcmread(path, stop_before_pixels=True).SOPInstanceUID for path in (tmp_path / "ct").iterdir()}
    (series,) = lamella.list_series("ct")
    assert (series.modality, series.files, series.refusal) == ("CT", len(slices), "")
    assert lamella.image("ct", series=series.uid).affine("lps").tolist() == names["lps"].tolist()
    with pytest.raises(lamella.MalformedMeshError, match="no series|series"):
        lamella.image("ct", series="1.2.3")
    for roi in names["read"].ROIContourSequence:
        assert all(contour.ContourImageSequence[0].ReferencedSOPInstanceUID in slices for contour in roi.ContourSequence)


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name, doctest_namespace):
    result = doctest.testmod(importlib.import_module(name), extraglobs=doctest_namespace)
    assert result.failed == 0


def test_there_are_examples():
    finder = doctest.DocTestFinder()
    assert sum(bool(test.examples) for name in MODULES for test in finder.find(importlib.import_module(name))) >= 12


# A program as mypy wants it, and lines with what it must say of each.
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
tops: lamella.Result = lamella.combine([result, result.shifted(1).grown(0.1), [mesh.vertices[:, :2]]], "subtract", offset=-0.1)
infill: lamella.Result = lamella.clip([mesh.vertices[:, :2]], result.grown(-0.1), inside=False, threads=1)
labelled: lamella.Result = lamella.combine([result, result[0]], lambda a, b: a + 2 * b, threads=1)
for chunk in lamella.stream(mesh.vertices, mesh.faces, layer_height=0.01, chunk=64):
    total: float = chunk.volume
cut: lamella.Layer = lamella.section(mesh, origin=[0, 0, 1], normal=[0, 1, 1], stitch=0.1)
edges: int = lamella.check(mesh)["boundary_edges"].count

def table(client: distributed.Client) -> list[dict[str, object]]:
    return lamella.dask.slice_many(client, ["liver.stl"], "{stem}.svg", retries=1, layer_height=0.1).rows()
"""

WRONG = [
    ('lamella.slice("liver.stl", layer_hight=0.1)', 'Unexpected keyword argument "layer_hight"'),
    ('lamella.slice("liver.stl", layer_height="thin")', 'Argument "layer_height"'),
    ('lamella.section("liver.stl", origin=[0, 0, 0], normal=[0, 0, 1], layer_height=1)', '"layer_height"'),
    ('lamella.combine([1])', 'List item 0 has incompatible type "int"'),
    ('lamella.slice("liver.stl").area', '"Result" has no attribute "area"'),
    ('x: str = lamella.slice("liver.stl")[0].z', "Incompatible types in assignment"),
]


def test_types_of_the_package_and_programs(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "right.py").write_text(RIGHT)
    (tmp_path / "wrong.py").write_text("import lamella\n" + "\n".join(line for line, _ in WRONG) + "\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--enable-incomplete-feature=Unpack"]
    files = ["lamella", tmp_path / "right.py", tmp_path / "wrong.py"]
    run = subprocess.run([*command, "--cache-dir", tmp_path / "cache", *files], cwd=pathlib.Path(lamella.__file__).parents[1], capture_output=True, text=True, check=False)
    said = [line for line in run.stdout.splitlines() if ": error: " in line]
    assert [line for line in said if "wrong.py" not in line] == []
    for row, (line, words) in enumerate(WRONG, start=2):
        assert any(f"wrong.py:{row}:" in told and words in told for told in said), (line, run.stdout + run.stderr)
