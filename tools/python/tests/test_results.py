"""Results: arrays, layers, and how long they live."""

import gc
import json
import os
import pickle
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import lamella


@pytest.fixture
def s(box_with_cavity):
    return lamella.slice(*box_with_cavity, layer_height=1)


def test_arrays_hold_layers_contours_and_points(s):
    assert len(s) == 10
    assert s.layers["z"] == pytest.approx(np.arange(10) + 0.5)
    assert s.layers["bottom"] == pytest.approx(np.arange(10))
    assert s.layers["top"] == pytest.approx(np.arange(10) + 1)
    assert s.layers["contour_count"].tolist() == [1, 1, 1, 2, 2, 2, 2, 1, 1, 1]
    assert (s.layers["first_contour"][1:] == np.cumsum(s.layers["contour_count"])[:-1]).all()
    assert (s.contours["first_point"][1:] == np.cumsum(s.contours["point_count"])[:-1]).all()
    assert s.contours["role"].tolist() == [0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 0, 0]
    assert s.contours["parent"][4] == 3
    assert (s.points_grid.dtype, s.points.dtype) == (np.int32, np.float64)
    assert (s.points == s.points_grid * s.grid).all()
    assert (s.points.min(), s.points.max()) == (0, 10)
    assert (s.contours["first_point"] + 1).dtype == np.int64  # rows are signed so that sums stay whole
    assert (s.layers["first_contour"][0] + 1).dtype == np.int64
    for array in (s.layers, s.contours, s.points_grid):  # views without a copy
        assert not array.flags.owndata
        assert not array.flags.writeable
        assert array.base is s._native
    assert not s.points.flags.writeable
    assert s.points is s.points


def test_measures_are_those_of_the_mesh(s):
    assert s.areas == pytest.approx([100] * 3 + [84] * 4 + [100] * 3)
    assert s.perimeters == pytest.approx([40] * 3 + [56] * 4 + [40] * 3)
    assert s.contour_areas[3:5] == pytest.approx([100, -16])
    assert s.contour_lengths[3:5] == pytest.approx([40, 16])
    assert s.volume == pytest.approx(1000 - 64)
    exact = s.contours["twice_area_high"] * 2.0**64 + s.contours["twice_area_low"]
    assert exact[3] / 2 * s.grid**2 == s.contour_areas[3]


def test_views_outlive_their_result(box_with_cavity):
    s = lamella.slice(*box_with_cavity, layer_height=0.01)
    views = [s.layers, s.contours, s.points_grid, s.points, s.contours["role"], s[500].contours]
    copies = [view.copy() for view in views]
    del s
    gc.collect()
    rubbish = [np.full(views[2].shape, -1, dtype=np.int32) for _ in range(8)]
    for view, copy in zip(views, copies):
        assert (view == copy).all()
    del rubbish


def test_a_result_and_its_mesh_go_when_nothing_holds_them(box_with_cavity):
    vertices, faces = box_with_cavity
    before = sys.getrefcount(vertices), sys.getrefcount(faces)
    s = lamella.slice(vertices, faces)
    points = s.points_grid
    native = sys.getrefcount(s._native)
    held = sys.getrefcount(vertices)
    del points
    s.__dict__.pop("points_grid")
    without_view = sys.getrefcount(s._native)  # pytest's assert would hold it
    del s
    gc.collect()
    after = sys.getrefcount(vertices), sys.getrefcount(faces)
    assert held > before[0]
    assert (without_view, after) == (native - 1, before)


def test_a_layer_tells_of_itself(s):
    assert [layer.index for layer in [*s[2:8:3], *s[::-5]]] == [2, 5, 9, 4]
    layer = s[4]
    assert (layer.bottom, layer.z, layer.top) == (4, 4.5, 5)
    assert (layer.area, layer.perimeter, len(layer)) == (pytest.approx(84), pytest.approx(56), 2)
    assert layer.contours["role"].tolist() == [lamella.Role.OUTER, lamella.Role.HOLE]
    assert len(layer.points) == layer.contours["point_count"].sum()
    (polygon,) = layer.polygons()
    x, y = np.moveaxis([polygon.outer, *polygon.holes], -1, 0)
    assert (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) / 2 == pytest.approx([100, -16])
    assert layer.polylines() == []
    assert repr(layer) == "<lamella.Layer 4: z 4.5 mm, 2 contours, 84 mm²>"


def test_an_empty_layer_has_nothing(cube):
    layer = lamella.slice(*cube, heights=[20])[0]
    assert (layer.area, layer.perimeter, len(layer), layer.polygons()) == (0, 0, 0, [])
    assert layer.points.shape == layer.points_grid.shape == (0, 2)
    assert layer._repr_html_().startswith("<svg")


def test_open_polylines_warn_and_are_told_apart(cube):
    vertices, faces = cube[0], np.delete(cube[1], 4, axis=0)
    with pytest.warns(lamella.MeshWarning, match=r"1 of 1 layer \(100 % of the height\) has open .* is not known; stitch=5\.1 would close it") as caught:
        s = lamella.slice(vertices, faces, heights=[5])
    assert caught[0].filename == __file__
    assert np.isnan([*s.areas, *s.perimeters, s[0].area, s.volume, s.certificate.mesh_volume]).all()
    (line,) = s[0].polylines()
    assert len(line) == s.contours["point_count"][0]
    assert s[0].polygons() == []
    assert s.contour_lengths[0] > 30
    assert (s.info["open_layers"], s.info["crossed_layers"], s.info["open_height_share"]) == (1, 1, 1)
    closed = lamella.slice(vertices, faces, heights=[5], stitch=s.info["closing_stitch"])
    assert closed.areas == pytest.approx([100])
    assert closed.stitches["layer"].tolist() == [0]
    assert (closed.contours["flags"] & lamella.ContourFlag.STITCHED).all()
    with pytest.warns(lamella.MeshWarning, match="10 of 10 layers") as caught:
        chunks = list(lamella.stream(vertices, faces, layer_height=1, chunk=4))
    assert (len(chunks), len(caught)) == (3, 1)


def test_a_mesh_too_small_for_its_grid_warns(cube):
    with pytest.warns(lamella.MeshWarning, match="coarse for a mesh of .* grid='finest' takes"):
        lamella.slice(cube[0] / 1000, cube[1], layer_height=0.001)


def test_shapely_gets_the_polygons(s):
    pytest.importorskip("shapely")
    shape = s[5].to_shapely()
    assert (shape.is_valid, shape.area, len(shape.geoms[0].interiors)) == (True, pytest.approx(84), 1)


def test_pandas_gets_a_row_per_contour(s):
    pytest.importorskip("pandas")
    frame = s.contours_frame()
    assert len(frame) == len(s.contours)
    assert frame.groupby("layer")["area"].sum().to_numpy() == pytest.approx(s.areas)
    assert set(frame["role"]) == {"outer", "hole"}
    assert frame["z"].tolist() == s.layers["z"][frame["layer"]].tolist()


def test_the_certificate_holds_for_a_closed_mesh_and_not_for_another(s, cube):
    assert s.certificate.holds
    assert s.certificate.mesh_volume == pytest.approx(1000 - 64)
    assert s.certificate.slab_volumes.sum() == pytest.approx(1000 - 64)
    vertices, faces = cube
    with pytest.warns(lamella.MeshWarning):
        opened = lamella.slice(vertices, faces[1:-1])
    assert opened.certificate.verdict == "open mesh"
    changed = lamella.slice(vertices, faces)
    vertices *= 0.5
    assert not changed.certificate.holds


def test_results_are_saved(s, tmp_path):
    s.save(tmp_path / "box.svg")
    names = [element.get("id", "") for element in ElementTree.parse(tmp_path / "box.svg").iter()]
    assert [name for name in names if name.startswith("layer")] == [f"layer{i}" for i in range(10)]
    s.save(str(tmp_path / "box.JSON"))
    report = json.loads((tmp_path / "box.JSON").read_text())
    assert report["output_hash"] == s.hash
    assert report["volume"]["verdict"] == "holds"
    s.save(tmp_path / "{layer:02}.dxf")
    assert len(list(tmp_path.glob("*.dxf"))) == len(s)
    s.save(tmp_path / "box.cli")
    assert (tmp_path / "box.cli").read_bytes().startswith(b"$$HEADERSTART")
    with pytest.raises(lamella.InvalidArgumentError, match="ends as no layer file does"):
        s.save(tmp_path / "box.stl")
    with pytest.raises(lamella.UnwritableFileError, match="cannot write") as raised:
        s.save(tmp_path / "no_folder" / "box.svg")
    assert raised.value.path == str(tmp_path / "no_folder" / "box.svg")


@pytest.mark.parametrize("protocol", [2, 5])
def test_pickled_results_are_the_same(torus, protocol, tmp_path):
    s = lamella.slice(*torus, heights=[3, 1, 3], fill_rule="non-zero", origins=True, simplify=0.01)
    assert s.certificate.verdict == "contours not as walked"
    same = pickle.loads(pickle.dumps(s, protocol))
    for name in ("layers", "contours", "points", "origins", "stitches", "layer_of", "areas", "frame"):
        assert np.array_equal(getattr(same, name), getattr(s, name)), name
    assert (same.hash, same.info, same.certificate.verdict) == (s.hash, s.info, s.certificate.verdict)
    for result, name in ((same, "same.svg"), (s, "s.svg")):
        result.save(tmp_path / name)
    assert (tmp_path / "same.svg").read_bytes() == (tmp_path / "s.svg").read_bytes()
    assert pickle.loads(pickle.dumps(s[1])).z == 3
    with pytest.raises(lamella.InvalidArgumentError, match="needs the whole mesh"):
        same.save(tmp_path / "same.json")


def test_a_result_is_shown_by_its_counts_and_a_picture(s):
    assert repr(s) == f"<lamella.Result: 10 layers from z 0.5 to 9.5 mm, 14 contours, {len(s.points)} points>"
    text = s._repr_html_()
    root = ElementTree.fromstring(text)
    assert root.find(".//{http://www.w3.org/2000/svg}path").get("d").startswith("M")
    assert "layers" in text
    assert len(text) < 5000


def test_results_made_in_the_memory_of_earlier_ones_are_their_own(torus, cube):
    def values(result):
        return [array.tolist() for array in (result.layers, result.contours, result.points_grid)]

    calls = [(torus, 0.05), (cube, 1), (torus, 0.5), (cube, 0.1)]
    kept = [lamella.slice(*mesh, layer_height=height) for mesh, height in calls]  # none is over: all take fresh memory
    expected = [values(result) for result in kept]
    for _ in range(3):
        for (mesh, height), values_of_call in zip(calls, expected):
            assert values(lamella.slice(*mesh, layer_height=height)) == values_of_call
    assert [values(result) for result in kept] == expected


def test_a_small_result_does_not_keep_the_memory_of_a_large_one(torus, cube):
    def resident_bytes():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    small = []
    before = resident_bytes()
    for _ in range(20):
        large = lamella.slice(*torus, layer_height=0.005, threads=1)
        assert large.points_grid.nbytes > 5_000_000
        del large
        small.append(lamella.slice(*cube, layer_height=1, threads=1))
    assert resident_bytes() - before < 60_000_000


def test_measures_are_those_of_an_exact_annulus(box_with_cavity):
    layers = lamella.slice(*box_with_cavity, heights=[2, 5, 11])
    assert layers.measures["area"].round(5).tolist() == [100, 84, 0]
    assert layers.measures["outer_area"].round(5).tolist() == [100, 100, 0]
    assert abs(layers.measures["ix"][1] - (10**4 - 4**4) / 12) < 1e-3
    assert layers.measures["known"].all() and np.isnan(layers.measures["centroid_x"][2])
    assert layers.island_measures["holes"].tolist() == [0, 1]
    assert np.allclose(layers[1].centroid, 5, atol=1e-5) and np.allclose(layers[1].bounds, [[0, 0], [10, 10]], atol=1e-5)
    frame = layers.layers_frame(islands=True)
    assert list(frame["layer"]) == [0, 1] and "contour" in frame


def test_measures_agree_with_scikit_image(torus):
    measure = pytest.importorskip("skimage.measure")
    mask = lamella.mask(torus, spacing=0.25, frame="lps")
    layers = lamella.slice(*torus, heights=[1.0])
    slice_at = int(np.argmin(np.abs(mask.affine[2, 3] + mask.affine[2, 2] * np.arange(mask.array.shape[2]) - 1.0)))
    pixels = measure.regionprops(mask.array[:, :, slice_at].T.astype(int))[0]
    own = layers.measures[0]
    assert abs(own["area"] - pixels.area * 0.25**2) < 0.01 * own["area"]
    assert abs(own["imax"] - pixels.inertia_tensor_eigvals[0] * pixels.area * 0.25**4) < 0.02 * own["imax"]


def test_points_lie_in_the_frame_of_the_mesh(cube):
    layers = lamella.slice(*cube, normal=[1, 1, 1], layer_height=2)
    points = layers.points_in_mesh()
    assert (points > -1e-5).all() and (points < 10 + 1e-5).all()
    assert np.allclose((np.isclose(points, 0, atol=1e-5) | np.isclose(points, 10, atol=1e-5)).any(axis=1), True)
    assert np.array_equal(layers[1].points_in_mesh(), points[len(layers[0].points) :][: len(layers[1].points)])


def test_contours_are_polylines_of_vtk(box_with_cavity):
    pytest.importorskip("vtkmodules")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    layers = lamella.slice(*box_with_cavity, layer_height=1)
    data = layers.to_vtk()
    assert data.GetNumberOfLines() == len(layers.contours) and data.GetNumberOfPoints() == len(layers.points)
    offsets = vtk_to_numpy(data.GetLines().GetOffsetsArray())
    ids = vtk_to_numpy(data.GetLines().GetConnectivityArray())
    for n, contour in enumerate(layers.contours):
        line = ids[offsets[n] : offsets[n + 1]]
        first, count = int(contour["first_point"]), int(contour["point_count"])
        assert line.tolist() == [*range(first, first + count), first]
    assert vtk_to_numpy(data.GetCellData().GetArray("role")).tolist() == layers.contours["role"].tolist()


def test_a_poly_data_of_vtk_is_a_mesh(torus):
    pytest.importorskip("vtkmodules")
    from vtkmodules.vtkFiltersSources import vtkCubeSource, vtkSphereSource

    sphere = vtkSphereSource()
    sphere.SetRadius(10)
    sphere.Update()
    layers = lamella.slice(sphere.GetOutput(), layer_height=1)
    assert layers.certificate.holds and 3000 < layers.volume < 4189
    cube = vtkCubeSource()
    cube.Update()
    with pytest.raises(lamella.InvalidArgumentError, match="vtkTriangleFilter"):
        lamella.slice(cube.GetOutput(), layer_height=1)


def test_stand_ins_of_packages_get_lines_and_polygons(box_with_cavity, monkeypatch):
    """trimesh, pyvista and geopandas are not in Debian's archive of this version: what they are handed is looked at."""
    import sys
    import types

    handed = {}

    def stand_in(name, **members):
        module = types.ModuleType(name)
        module.__dict__.update(members)
        monkeypatch.setitem(sys.modules, name, module)

    for name in ("trimesh", "trimesh.path", "trimesh.path.exchange"):
        stand_in(name)
    stand_in("trimesh.path.exchange.misc", lines_to_path=lambda lines: {"lines": lines})
    stand_in("trimesh.path.path", Path3D=lambda **made: made)
    stand_in("geopandas", GeoDataFrame=lambda frame, geometry: handed.update(frame=frame, geometry=geometry) or handed)
    layers = lamella.slice(*box_with_cavity, layer_height=1)
    segments = layers.to_trimesh()["lines"]
    assert segments.shape == (len(layers.points), 2, 3)
    pytest.importorskip("shapely")
    frame = layers.to_geopandas()
    assert np.allclose([polygon.area for polygon in frame["geometry"]], frame["frame"]["area"])
    pytest.importorskip("vtkmodules")
    stand_in("pyvista", wrap=lambda data: data)
    assert layers.to_pyvista().GetNumberOfLines() == len(layers.contours)


def test_a_stack_is_drawn(box_with_cavity, matplotlib):
    layers = lamella.slice(*box_with_cavity, layer_height=0.1)
    axes = layers.plot_stack(most=10)
    assert len(axes.collections[0]._segments3d) in range(10, 21)
    assert axes.get_zlim()[1] <= 10


def test_meshes_tell_their_measures(cube, tmp_path):
    from support import write_stl

    vertices, faces = cube
    write_stl(tmp_path / "cube.stl", vertices[faces])
    mesh = lamella.read(tmp_path / "cube.stl", indexed=True)
    assert mesh.vertices.shape == (8, 3) and mesh.faces.shape == (12, 3)
    assert mesh.path == str(tmp_path / "cube.stl") and mesh.info["format"]
    assert mesh.bounds.tolist() == [[0, 0, 0], [10, 10, 10]]
    assert (mesh.volume, mesh.area) == (1000, 600)
    assert lamella.slice(mesh, layer_height=1).hash == lamella.slice(*cube, layer_height=1).hash
    unknown = lamella.read(tmp_path / "cube.stl", unit="cm")
    assert unknown.bounds.max() == 100


def test_scalars_are_carried_to_contour_points(torus):
    vertices, faces = torus
    layers = lamella.slice(vertices, faces, layer_height=1, normal=[1, 2, 0], origins=True)
    values = np.column_stack((vertices[:, 0], 2 * vertices[:, 1] - vertices[:, 2]))  # linear: exact everywhere on the surface
    points = layers.points_in_mesh()
    carried = layers.scalars(values)
    assert np.allclose(carried, np.column_stack((points[:, 0], 2 * points[:, 1] - points[:, 2])), atol=1e-4)
    cuts = lamella.sections(lamella.slice(vertices, faces, heights=[0])._view._meshes[0], [[20, 0, 0]], [0, 0, 1], origins=True)
    assert np.allclose(cuts.scalars(vertices[:, 0]), cuts.points_in_mesh()[:, 0], atol=1e-4)
    with pytest.raises(lamella.InvalidArgumentError, match="origins=True"):
        lamella.slice(vertices, faces, layer_height=1).scalars(values)
    with pytest.raises(lamella.InvalidArgumentError, match="a row for each"):
        layers.scalars(values[1:])
