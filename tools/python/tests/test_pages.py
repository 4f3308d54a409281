"""What README and the page on Python show runs."""

import pathlib
import re

import numpy as np
import pytest

import lamella

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture
def folder(torus, tmp_path, monkeypatch):
    """With the mesh that the pages cut."""
    triangles = torus[0][torus[1]].astype("<f4")
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows["corners"] = triangles
    (tmp_path / "bone.stl").write_bytes(b"\0" * 80 + np.uint32(len(rows)).tobytes() + rows.tobytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_page(path, least):
    blocks = re.findall(r"^```python\n(.*?)^```$", path.read_text(), flags=re.MULTILINE | re.DOTALL)
    assert len(blocks) >= least
    names = {}
    for block in blocks:
        exec(compile(block, str(path), "exec"), names)
    return names


def test_readme_plots_areas_over_height(folder, capsys):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    names = run_page(ROOT / "README.md", 1)
    assert (folder / "areas.png").stat().st_size > 1000
    assert capsys.readouterr().out.startswith("<lamella.Result: 540 layers")
    assert len(names["s"].areas) == 540


def test_the_page_on_python_is_true(folder, capsys):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    names = run_page(ROOT / "tools/docs/python.md", 5)
    assert "faces[0] = [" in capsys.readouterr().out
    assert names["holes_per_layer"].tolist() == [int((layer.contours["role"] == lamella.Role.HOLE).sum()) for layer in names["s"]]
    assert len(names["outline"]) == names["longest"]["point_count"]
    assert (folder / "bone.svg").exists()
    assert (folder / "bone.json").exists()


def test_the_gallery_shows_what_draws_its_pictures(torus, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    page = (ROOT / "tools/docs/gallery.md").read_text()
    path = ROOT / "tools/python/examples/gallery.py"
    program = path.read_text()
    names = {"__name__": "gallery"}
    exec(compile(program, str(path), "exec"), names)
    shown = re.findall(r"^```py\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)
    assert len(shown) == len(names["PICTURES"])
    assert all(block in program for block in shown)
    vertices, faces = torus
    rows = [" ".join(map(str, vertex)) for vertex in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    (tmp_path / "torus.off").write_text("\n".join(["OFF", f"{len(vertices)} {len(faces)} 0", *rows]) + "\n")
    names["main"](tmp_path / "torus.off", tmp_path)
    for draw in names["PICTURES"]:
        assert f"python_{draw.__name__}.png" in page
        assert (ROOT / f"tools/pictures/python_{draw.__name__}.png").exists()
        assert (tmp_path / f"python_{draw.__name__}.png").stat().st_size > 1000
