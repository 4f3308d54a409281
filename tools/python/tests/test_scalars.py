"""Values at vertices: read from files that VTK, nibabel and others write, and carried to contour points."""

import numpy as np
import pytest

import lamella


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
def test_point_data_of_vtk_is_carried_as_its_cutter_does(torus, tmp_path, mode):
    vtk = pytest.importorskip("vtkmodules.all")
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

    vertices, faces = torus
    heat = np.sin(vertices[:, 0]) * vertices[:, 1]
    given = {"heat": heat, "normal": vertices / 7, "label": np.int32(vertices[:, 0] > 0) - 1, "gaps": np.float32(np.where(heat > 0, heat, np.nan))}
    data, cells, path = vtk.vtkPolyData(), vtk.vtkCellArray(), tmp_path / "torus.vtp"
    for face in faces:
        cells.InsertNextCell(3, face)
    data.SetPoints(vtk.vtkPoints())
    data.GetPoints().SetData(numpy_to_vtk(vertices, deep=True))
    data.SetPolys(cells)
    for name, values in given.items():
        array = numpy_to_vtk(values, deep=True)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    data.GetPointData().AddArray(vtk.vtkBitArray())  # none of numbers

    def write(what):
        writer = vtk.vtkXMLPolyDataWriter()
        writer.SetFileName(str(path))
        writer.SetInputData(what)
        getattr(writer, f"SetDataModeTo{mode}")()
        assert writer.Write()

    write(data)
    mesh = lamella.read(path, scalars=True)
    assert lamella.read(path).scalars == {} and list(mesh.scalars) == list(given) and mesh.scalars["label"].dtype == np.int64
    for name, values in given.items():
        assert np.allclose(mesh.scalars[name], values, atol=1e-9, equal_nan=True)
    layers = lamella.slice(mesh, heights=[3.21], origins=True)
    plane, cutter = vtk.vtkPlane(), vtk.vtkCutter()
    plane.SetOrigin(0, 0, 3.21)
    cutter.SetCutFunction(plane)
    cutter.SetInputData(data)
    cutter.Update()
    places, cut = (vtk_to_numpy(array) for array in (cutter.GetOutput().GetPoints().GetData(), cutter.GetOutput().GetPointData().GetArray("heat")))
    near = np.linalg.norm(layers.points_in_mesh()[:, None] - places, axis=2).argmin(axis=1)
    assert np.allclose(layers.scalars("heat"), cut[near], atol=1e-4)
    assert set(layers.scalars("label")) == {-1, 0} and 0 < np.isnan(layers.scalars("gaps")).mean() < 1
    write(layers.to_vtk())
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    for name in given:
        assert np.allclose(vtk_to_numpy(reader.GetOutput().GetPointData().GetArray(name)), layers.scalars(name), equal_nan=True)
    with pytest.raises(lamella.InvalidArgumentError, match="no values 'cold', but 'heat'"):
        layers.scalars("cold")
    with pytest.raises(lamella.InvalidArgumentError, match="result of parts"):
        lamella.slice_parts([mesh], layer_height=1, origins=True).scalars("heat")


def test_arrays_of_gifti_are_read_by_name_and_those_that_do_not_fit_are_told(torus, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    array, thick, label = nibabel.gifti.GiftiDataArray, np.float32(torus[0][:, 1]), np.int32(torus[0][:, 0] > 0)
    arrays = [array(np.float32(torus[0]), "NIFTI_INTENT_POINTSET"), array(np.int32(torus[1]), "NIFTI_INTENT_TRIANGLE")]
    arrays += [array(thick, "NIFTI_INTENT_SHAPE", meta={"Name": "thick"}), array(label, "NIFTI_INTENT_LABEL")]
    arrays += [array(-thick, "NIFTI_INTENT_SHAPE"), array(2 * thick, "NIFTI_INTENT_SHAPE"), array(thick[:7], "NIFTI_INTENT_NONE")]
    nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays), tmp_path / "torus.gii")
    with pytest.warns(lamella.MeshWarning, match="line .* expected 2304 rows, one a point, found 7; the values 'none'"):
        mesh = lamella.read(tmp_path / "torus.gii", scalars=True)
    for name, values in {"thick": thick, "label": label, "shape": -thick, "shape (2)": 2 * thick}.items():
        assert np.array_equal(mesh.scalars.pop(name), values)
    assert mesh.scalars == {}


def test_properties_of_ply_are_read_but_for_lists(tmp_path):
    rows = ["0 0 0 nan 1 2 5 5", "9 0 0 0.5 2 0", "0 9 0 -inf 3 1 7", "0 0 9 2.5 -4 0", "3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3", ""]
    head = "ply,format ascii 1.0,comment SPACE=RAS,element vertex 4,property float x,property float y,property float z,property double warm,property int id"
    head += ",property list uchar int all,element face 4,property list uchar int vertex_indices,end_header"
    (tmp_path / "a.ply").write_text("\n".join([*head.split(","), *rows]))
    mesh = lamella.read(tmp_path / "a.ply", scalars=True)
    assert mesh.scalars["id"].tolist() == [1, 2, 3, -4] and list(mesh.scalars) == ["warm", "id"]
    assert np.array_equal(mesh.scalars["warm"], [np.nan, 0.5, -np.inf, 2.5], equal_nan=True)
    mask = lamella.mask(mesh, spacing=1)  # in the frame that the file states
    assert np.array_equal(lamella.stream(tmp_path / "a.ply").mask(like=(mask.array.shape, mask.affine)).array, mask.array)
    (tmp_path / "b.ply").write_text("\n".join([*head.split(","), *rows]).replace("0.5", "much"))
    with pytest.raises(lamella.MalformedMeshError, match="b.ply: line 15.*'warm' of 'vertex' 1: expected a number, found 'much'"):
        lamella.read(tmp_path / "b.ply", scalars=True)
