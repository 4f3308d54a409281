"""Masks, structure sets, tables, archives and pictures, read back by programs that nobody here wrote."""

import csv
import subprocess
import sys

import numpy as np
import pytest

import lamella
from support import needs_tool, write_stl


@pytest.fixture
def image():
    """An oblique one: shape and affine in RAS."""
    angle = np.radians(20)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    affine = np.eye(4)
    affine[:3, :3] = turn * [0.5, 0.75, 1.0]
    affine[:3, 3] = [-5.1, -5.2, 5.3] - affine[:3, :3] @ [25, 22, 8]
    return (51, 45, 17), affine


def inside_cube(shape, affine):
    """Of an image in RAS, which centres lie in the cube of 0 to 10 mm in LPS."""
    i, j, k = np.indices(shape)
    at = np.stack((i, j, k, np.ones(shape)), axis=-1) @ affine.T
    lps = at[..., :3] * [-1, -1, 1]
    return ((lps > 0) & (lps < 10)).all(axis=-1)


def test_a_mask_is_what_lies_inside_voxel_for_voxel(cube, image):
    mask = lamella.mask(cube, like=image, frame="lps")
    assert np.array_equal(mask.array, inside_cube(*image))
    assert mask.array.flags.f_contiguous and mask.array.dtype == np.uint8
    assert np.allclose(mask.affine, image[1], atol=1e-12) and mask.labels == {1: "mesh 1"}
    turned = (image[0], np.diag([-1, -1, 1, 1]) @ image[1])
    assert np.array_equal(lamella.mask(cube, like=turned, frame="ras").array, mask.array)
    lps = lamella.mask(cube, like=image, frame="lps", affine_frame="lps")
    assert np.allclose(lps.affine, np.diag([-1, -1, 1, 1]) @ image[1]) and np.array_equal(lps.array, mask.array)


def test_labels_shares_dtypes_and_out(cube, image, tmp_path):
    vertices, faces = cube
    both = {"a": cube, "b": (vertices + [5, 0, 0], faces)}
    mask = lamella.mask(both, like=image, frame="lps", dtype="i2")
    assert mask.array.dtype == np.int16 and mask.labels == {1: "a", 2: "b"}
    assert mask.overlaps == np.count_nonzero(lamella.mask(cube, like=image, frame="lps").array & (mask.array == 2)) > 0
    room = np.memmap(tmp_path / "voxels", dtype=np.uint8, shape=image[0], order="F", mode="w+")
    assert lamella.mask(both, like=image, frame="lps", out=room).array is room
    assert np.array_equal(room, mask.array)
    shares = lamella.mask(cube, like=image, frame="lps", coverage=True, subslices=4, dtype="f4").array
    voxel = 0.5 * 0.75 * 1.0
    assert shares.max() == 1 and abs(shares.sum() * voxel - 1000) < 1
    half = lamella.mask(cube, like=image, frame="lps", coverage=True, subslices=4)
    assert np.array_equal(half.array, np.round(255 * shares).astype(np.uint8)) and half.voxels[0] == np.count_nonzero(half.array)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({}, "one of like and spacing"),
        ({"spacing": 1}, "states no patient frame"),
        ({"spacing": 1, "frame": "up"}, "frame must be one of"),
        ({"spacing": 1, "frame": "lps", "dtype": "f4"}, "dtype must be an integer"),
        ({"spacing": 1, "frame": "lps", "out": np.zeros((10, 10, 10), np.uint8)}, "Fortran order"),
        ({"spacing": 1, "frame": "lps", "out": np.zeros((10, 10, 9), np.uint8, order="F")}, "shape"),
        ({"spacing": 1, "frame": "lps", "subslices": 0}, "subslices must be"),
        ({"spacing": 1, "frame": "lps", "layer_height": 1}, "exclude"),
        ({"like": ((4, 4), np.eye(4))}, "three sides"),
        ({"like": ((4, 4, 4), np.diag([1, 1, 0, 1]))}, "column of zeros"),
        ({"like": ((4, 4, 4), np.eye(4) + np.eye(4, k=1) * [[1], [0], [0], [0]])}, "sheared within"),
        ({"like": 3}, "like must be"),
    ],
)
def test_what_a_mask_cannot_be_is_refused(cube, options, why):
    with pytest.raises(lamella.InvalidArgumentError, match=why):
        lamella.mask(cube, **options)


def test_a_result_serves_only_at_the_slices_it_was_cut_at(cube, image):
    with pytest.raises(lamella.InvalidArgumentError, match="not cut at the slices"):
        lamella.mask(lamella.slice(*cube, layer_height=1), like=image)
    with pytest.raises(lamella.InvalidArgumentError, match="cut already"):
        lamella.mask(lamella.slice(*cube, layer_height=1), spacing=1)


def test_open_slices_are_told_or_refused(cube, image):
    holed = (cube[0], cube[1][:-1])
    with pytest.warns(lamella.MeshWarning, match="mesh 1: .*stitch="):
        lamella.mask(holed, like=image, frame="lps", stitch=0)
    with pytest.raises(lamella.InvalidArgumentError, match="stitch="):
        lamella.mask(holed, like=image, frame="lps", stitch=0, strict=True)


def test_masks_are_files_that_others_read(cube, image, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    expected = lamella.mask(cube, like=image, frame="lps")
    for name in ("a.nii", "a.nii.gz"):
        lamella.save_mask(tmp_path / name, cube, like=image, frame="lps")
        read = nibabel.load(tmp_path / name)
        assert np.array_equal(read.get_fdata(), expected.array)
        assert np.allclose(read.affine, expected.affine, atol=1e-5)
    again = lamella.mask(cube, like=read, frame="lps")  # an image of nibabel
    assert np.array_equal(again.array, expected.array)
    assert np.array_equal(lamella.mask(cube, like=tmp_path / "a.nii", frame="lps").array, expected.array)
    assert lamella.image(tmp_path / "a.nii").shape == image[0]
    with pytest.raises(lamella.InvalidArgumentError, match="nii"):
        lamella.save_mask(tmp_path / "a.png", cube, like=image, frame="lps")
    with pytest.raises(lamella.UnreadableFileError) as caught:
        lamella.image(tmp_path / "none.nii")
    assert caught.value.path == str(tmp_path / "none.nii")


@needs_tool
def test_masks_and_tables_are_those_of_the_tool(cube, tmp_path):
    from support import TOOL

    vertices, faces = cube
    mesh = tmp_path / "cube.stl"
    write_stl(mesh, vertices[faces])
    run = [TOOL, "slice", str(mesh), "--spacing", "0.7,0.8,0.9", "--frame", "lps"]
    subprocess.run([*run, "-o", str(tmp_path / "tool.nii"), "-o", str(tmp_path / "tool.seg.nrrd")], check=True)
    for end in (".nii", ".seg.nrrd"):
        lamella.save_mask(tmp_path / f"own{end}", mesh, spacing=[0.7, 0.8, 0.9], frame="lps")
        assert (tmp_path / f"own{end}").read_bytes() == (tmp_path / f"tool{end}").read_bytes()
    layers = lamella.slice(mesh, layer_height=0.5)
    subprocess.run([TOOL, "slice", str(mesh), "--layer-height", "0.5", "--islands", "-o", str(tmp_path / "tool.csv")], check=True)
    lamella.save_table(tmp_path / "own.csv", layers, islands=True)
    assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "tool.csv").read_bytes()
    version = subprocess.run([sys.executable, "-m", "lamella", "--version"], check=True, capture_output=True, text=True).stdout
    assert version == subprocess.run([TOOL, "--version"], check=True, capture_output=True, text=True).stdout


def test_a_mask_is_an_image_of_vtk_and_becomes_a_mesh_again(cube, image):
    pytest.importorskip("vtkmodules")
    measure = pytest.importorskip("skimage.measure")
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData

    m = lamella.mask(cube, like=image, frame="lps", affine_frame="lps")
    grid, spacing = vtkImageData(), np.linalg.norm(m.affine[:3, :3], axis=0)
    grid.SetDimensions(m.array.shape)
    grid.SetSpacing(spacing)
    grid.SetOrigin(m.affine[:3, 3])
    grid.SetDirectionMatrix((m.affine[:3, :3] / spacing).ravel())
    grid.GetPointData().SetScalars(numpy_to_vtk(m.array.ravel(order="F")))
    for voxel in ([0, 0, 0], [25, 22, 8], [3, 40, 11]):
        place = np.zeros(3)
        grid.TransformIndexToPhysicalPoint(voxel, place)
        assert np.allclose(place, (m.affine @ [*voxel, 1])[:3])
        assert grid.GetScalarComponentAsDouble(*voxel, 0) == m.array[tuple(voxel)]
    vertices, faces, _, _ = measure.marching_cubes(np.pad(m.array, 1).astype(float), 0.5, allow_degenerate=False)
    again = lamella.slice(vertices, faces, layer_height=0.5)
    assert abs(abs(again.volume) - m.voxels[0]) < 0.1 * m.voxels[0]


def test_a_mask_of_a_tilted_gantry_lies_on_shifted_slices(cube, image):
    tilted = image[1].copy()
    tilted[:3, 2] += 0.25 * image[1][:3, 1]  # a quarter of a voxel each slice
    mask = lamella.mask(cube, like=(image[0], tilted), frame="lps")
    assert np.allclose(mask.affine, tilted, atol=1e-9)
    assert np.array_equal(mask.array, inside_cube(image[0], tilted))


def test_structure_sets_are_read_by_pydicom(cube, image, tmp_path):
    pydicom = pytest.importorskip("pydicom")
    meshes = {"bone": cube, "Bone": cube}
    names = lamella.save_structure_set(tmp_path / "rs.dcm", meshes, like=image, frame="lps", without_ct=True)
    read = pydicom.dcmread(tmp_path / "rs.dcm")
    assert [roi.ROIName for roi in read.StructureSetROISequence] == names
    points = np.array(read.ROIContourSequence[0].ContourSequence[0].ContourData, dtype=float).reshape(-1, 3)
    assert (points >= -1e-4).all() and (points <= 10.0001).all()
    with pytest.raises(lamella.InvalidArgumentError, match="DICOM series"):
        lamella.save_structure_set(tmp_path / "no.dcm", meshes, like=image, frame="lps")
    assert not (tmp_path / "no.dcm").exists()


def test_segmentations_are_read_by_pydicom_with_their_labels(cube, image, tmp_path):
    pydicom = pytest.importorskip("pydicom")
    (tmp_path / "labels.csv").write_text("label,name,color,type\n2,right,#102030,SCT^71341001^Femur\n")
    meshes = {"left": cube, "other": (cube[0] + [3, 0, 0], cube[1])}
    mask = lamella.mask(meshes, like=image, frame="lps", labels=tmp_path / "labels.csv")
    assert mask.labels == {1: "left", 2: "right"}
    lamella.save_mask(tmp_path / "seg.dcm", meshes, like=image, frame="lps", labels=tmp_path / "labels.csv", without_ct=True)
    read = pydicom.dcmread(tmp_path / "seg.dcm")
    assert [segment.SegmentLabel for segment in read.SegmentSequence] == ["left", "right"]
    assert read.SegmentSequence[1].SegmentedPropertyTypeCodeSequence[0].CodeMeaning == "Femur"
    bits = np.unpackbits(np.frombuffer(read.PixelData, np.uint8), bitorder="little")[: read.NumberOfFrames * read.Rows * read.Columns]
    alone = [np.count_nonzero(lamella.mask(mesh, like=image, frame="lps").array) for mesh in meshes.values()]
    assert bits.sum() == sum(alone) > np.count_nonzero(mask.array)  # overlapping voxels are in both
    lamella.save_mask(tmp_path / "a.mha", meshes, like=image, frame="lps")
    assert np.allclose(lamella.image(tmp_path / "a.mha").affine(), image[1], atol=1e-6)
    (tmp_path / "labels.csv").write_text("label,name\n7,none\n")
    with pytest.raises(lamella.InvalidArgumentError, match="no mesh 7, only 2"):
        lamella.mask(meshes, like=image, frame="lps", labels=tmp_path / "labels.csv")
    (tmp_path / "labels.csv").write_text("label,name\nx,none\n")
    with pytest.raises(lamella.MalformedMeshError) as caught:
        lamella.mask(meshes, like=image, frame="lps", labels=tmp_path / "labels.csv")
    assert caught.value.path == str(tmp_path / "labels.csv")


def test_tables_hold_the_measures(box_with_cavity, tmp_path):
    layers = lamella.slice(*box_with_cavity, layer_height=0.5)
    lamella.save_table(tmp_path / "a.csv", {"box": layers})
    with open(tmp_path / "a.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(layers) and rows[0]["mesh"] == "box"
    units = {"area": "mm2", "imax": "mm4", "angle": "rad", "feret_max": "mm", "equivalent_diameter": "mm"}
    for name, unit in units.items():
        column = [float(row[f"{name}_{unit}"] or "nan") for row in rows]
        assert np.array_equal(column, layers.measures[name], equal_nan=True)
    assert np.array_equal([float(row["circularity"]) for row in rows], layers.measures["circularity"])


def test_an_archive_is_opened_again(cube, tmp_path):
    layers = lamella.slice(*cube, layer_height=1)
    lamella.save_archive(tmp_path / "a.h5", layers, name="cube")
    again = lamella.open(tmp_path / "a.h5")
    assert again.hash == layers.hash and again.layers_frame().equals(layers.layers_frame())
    with pytest.raises(lamella.InvalidArgumentError, match="needs the whole mesh"):
        _ = again.certificate
    with pytest.raises(lamella.UnreadableFileError):
        lamella.open(tmp_path / "none.h5")


def test_an_archive_has_the_measures_of_tables_on_request(torus, tmp_path):
    h5py = pytest.importorskip("h5py")
    with pytest.warns(lamella.MeshWarning, match="open contours"):
        layers = lamella.slice(torus[0], torus[1][:-40], layer_height=0.5, stitch=0)
    lamella.save_archive(tmp_path / "a.h5", layers, measures=True)
    lamella.save_table(tmp_path / "a.csv", layers)
    with h5py.File(tmp_path / "a.h5") as archive, open(tmp_path / "a.csv", newline="") as table:
        columns, rows = {name: column[...] for name, column in archive["measures"].items()}, list(csv.DictReader(table))
        assert archive["measures/imax_mm4"].attrs["unit"] == b"mm^4"
    assert np.isnan(columns["area_mm2"]).any() and np.nanmax(columns["feret_max_mm"]) > 40
    places = {name for name in rows[0] if name.startswith(("min_", "max_", "height", "cut", "bottom", "top"))}
    assert set(columns) == set(rows[0]) - places - {"mesh", "layer", "contours", "flat"}
    for name, column in columns.items():
        assert np.array_equal(column, [float(row[name] or "nan") for row in rows], equal_nan=True)
    assert lamella.open(tmp_path / "a.h5").hash == layers.hash
    lamella.save_archive(tmp_path / "a.h5", layers)
    assert "measures" not in h5py.File(tmp_path / "a.h5")


def test_a_picture_shows_the_layers(cube, tmp_path, matplotlib):
    lamella.save_picture(tmp_path / "a.png", lamella.slice(*cube, layer_height=1))
    import matplotlib.image

    assert matplotlib.image.imread(tmp_path / "a.png").std() > 0.05
