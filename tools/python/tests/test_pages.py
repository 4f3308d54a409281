"""README, the pages on Python, the notebook and the examples in docstrings run, and are true."""

import doctest
import importlib
import json
import pathlib
import pkgutil
import re

import pytest
from support import write_off, write_stl

import lamella

MODULES = ["lamella", *(f"lamella.{module.name}" for module in pkgutil.iter_modules(lamella.__path__) if module.name != "_native")]
NOTEBOOK = pathlib.Path(__file__).resolve().parents[1] / "examples/first_steps.ipynb"
ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture
def folder(torus, tmp_path, monkeypatch):
    """With the mesh that the pages cut."""
    write_stl(tmp_path / "bone.stl", torus[0][torus[1]])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_page(path, least):
    blocks = re.findall(r"^```python\n(.*?)^```$", path.read_text(), flags=re.MULTILINE | re.DOTALL)
    assert len(blocks) >= least
    names = {}
    for block in blocks:
        exec(compile(block, str(path), "exec"), names)
    return names


def test_readme_plots_areas_over_height(folder, capsys, matplotlib):
    names = run_page(ROOT / "README.md", 1)
    assert (folder / "areas.png").stat().st_size > 1000
    assert capsys.readouterr().out.startswith("<lamella.Result: 540 layers")
    assert len(names["s"].areas) == 540


def test_the_page_on_python_is_true(folder, capsys, matplotlib):
    names = run_page(ROOT / "tools/docs/python.md", 5)
    assert "faces[0] = [" in capsys.readouterr().out
    assert names["holes_per_layer"].tolist() == [int((layer.contours["role"] == lamella.Role.HOLE).sum()) for layer in names["s"]]
    assert len(names["outline"]) == names["longest"]["point_count"]
    assert (folder / "bone.svg").exists()
    assert (folder / "bone.json").exists()


def test_the_gallery_shows_what_draws_its_pictures(torus, tmp_path, matplotlib):
    page = (ROOT / "tools/docs/gallery.md").read_text()
    path = ROOT / "tools/python/examples/gallery.py"
    program = path.read_text()
    names = {"__name__": "gallery"}
    exec(compile(program, str(path), "exec"), names)
    shown = re.findall(r"^```py\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)
    assert len(shown) == len(names["PICTURES"])
    assert all(block in program for block in shown)
    write_off(tmp_path / "torus.off", *torus)
    names["main"](tmp_path / "torus.off", tmp_path)
    for draw in names["PICTURES"]:
        assert f"python_{draw.__name__}.png" in page
        assert (ROOT / f"tools/pictures/python_{draw.__name__}.png").exists()
        assert (tmp_path / f"python_{draw.__name__}.png").stat().st_size > 1000


def test_the_notebook_runs(capsys, matplotlib):
    cells = [cell for cell in json.loads(NOTEBOOK.read_text())["cells"] if cell["cell_type"] == "code"]
    names = {}
    for cell in cells:
        exec(compile("".join(cell["source"]), str(NOTEBOOK), "exec"), names)
    told = capsys.readouterr().out
    assert "certificate holds" in told
    assert "3 boundary edges" in told
    assert names["volume"] == pytest.approx(names["s"].volume, rel=1e-3)
    assert (names["difference"] > 0).all()
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)  # none are committed


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name, doctest_namespace):
    result = doctest.testmod(importlib.import_module(name), extraglobs=doctest_namespace)
    assert result.failed == 0


def test_there_are_examples(doctest_namespace):
    finder = doctest.DocTestFinder()
    examples = [test for name in MODULES for test in finder.find(importlib.import_module(name)) if test.examples]
    assert len(examples) >= 12
