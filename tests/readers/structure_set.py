#!/usr/bin/env python3
"""DICOM as pydicom, plastimatch and dciodvfy read it: structure_set.py LAMELLA. Ends with 77 where pydicom is missing."""

import shutil
import subprocess

from support import box, main, need, stl

nibabel, numpy, pydicom = need("nibabel", "numpy", "pydicom")

COLUMNS, ROWS = 40, 30
SPACING = (1.5, 2.0)  # of columns, of rows

# A hollow box, two holes side by side in another one, and a marker: no symmetry maps it to itself. In LPS, mm.
BOXES = [((-20, -18, 12), (0, 4, 30), False), ((-15, -12, 14), (-6, -3, 28), True), ((4, -10, 12), (24, 14, 24), False),
         ((6, -8, 13), (12, 6, 23), True), ((15, -2, 13), (21, 6, 22), True), ((27, 16, 12), (31, 19, 18), False)]  # fmt: skip
HOLLOW = [triangle for low, high, inward in BOXES for triangle in box(low, high, inward)]


def inside(at):
    within = lambda low, high: all(l < x < h for l, x, h in zip(low, at, high))
    solid = sum(within(low, high) for low, high, inward in BOXES if not inward)
    return solid > 0 and not any(within(low, high) for low, high, inward in BOXES if inward)


def area_at(z):
    """Of the region at a height, for axial slices."""
    total = 0
    for low, high, inward in BOXES:
        if low[2] < z < high[2]:
            total += (-1 if inward else 1) * (high[0] - low[0]) * (high[1] - low[1])
    return total


def write_ct(folder, along_i, along_j, origin, heights, series="1.2.826.0.1.3680043.8.498.1", tilt=0):
    """A CT: slices at `heights` along the normal from `origin`, their files in the order of a shuffle. `tilt`: mm along j
    for each mm along the normal."""
    folder.mkdir(exist_ok=True)
    normal = numpy.cross(along_i, along_j)
    order = numpy.random.default_rng(3).permutation(len(heights))
    for name, k in enumerate(order):
        meta = pydicom.dataset.FileMetaDataset()
        meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
        meta.MediaStorageSOPInstanceUID = f"{series}.{k + 1}"
        meta.TransferSyntaxUID = pydicom.uid.ImplicitVRLittleEndian
        data = pydicom.dataset.FileDataset(None, {}, file_meta=meta, preamble=bytes(128))
        data.is_little_endian, data.is_implicit_VR = True, True
        data.SOPClassUID, data.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
        data.StudyDate, data.StudyTime, data.AccessionNumber, data.Modality = "20200102", "030405", "", "CT"
        data.Manufacturer, data.ReferringPhysicianName = "nobody", ""
        data.SeriesDescription = f"series {series[-1]}"
        data.PatientName, data.PatientID, data.PatientBirthDate, data.PatientSex = "Doe^Jane", "17", "", "F"
        data.SliceThickness, data.KVP, data.PatientPosition = "3", "120", "HFS"
        data.StudyInstanceUID, data.SeriesInstanceUID = "1.2.826.0.1.3680043.8.498.7", series
        data.StudyID, data.SeriesNumber, data.AcquisitionNumber, data.InstanceNumber = "1", "301", "1", str(k + 1)
        data.ImageOrientationPatient = [f"{x:.10g}" for x in (*along_i, *along_j)]
        place = numpy.array(origin) + heights[k] * (normal + tilt * numpy.array(along_j))
        data.ImagePositionPatient = [f"{x:.10g}" for x in place]
        data.FrameOfReferenceUID, data.PositionReferenceIndicator = "1.2.826.0.1.3680043.8.498.9", ""
        data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
        data.Rows, data.Columns, data.PixelSpacing = ROWS, COLUMNS, [str(SPACING[1]), str(SPACING[0])]
        data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 1
        data.RescaleIntercept, data.RescaleSlope = "0", "1"
        data.PixelData = bytes(2 * ROWS * COLUMNS)
        data.save_as(folder / f"{name}.dcm", write_like_original=False)


def item(**values):
    """A sequence of one item."""
    data = pydicom.Dataset()
    for keyword, value in values.items():
        setattr(data, keyword, value)
    return pydicom.Sequence([data])


def make_enhanced(folder):
    """Makes one file of a CT, with its slices as frames."""
    slices = [pydicom.dcmread(path) for path in folder.iterdir()]
    data = slices[0]
    measures = item(PixelSpacing=data.PixelSpacing, SliceThickness=data.SliceThickness)
    upright = item(ImageOrientationPatient=data.ImageOrientationPatient)
    data.SharedFunctionalGroupsSequence = item(PixelMeasuresSequence=measures, PlaneOrientationSequence=upright)
    data.PerFrameFunctionalGroupsSequence = pydicom.Sequence(
        item(PlanePositionSequence=item(ImagePositionPatient=one.ImagePositionPatient))[0] for one in slices)  # fmt: skip
    for keyword in ("PixelSpacing", "SliceThickness", "ImageOrientationPatient", "ImagePositionPatient"):
        delattr(data, keyword)
    data.SOPClassUID = data.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2.1"
    data.NumberOfFrames, data.PixelData = len(slices), len(slices) * data.PixelData
    for path in folder.iterdir():
        path.unlink()
    data.save_as(folder / "all.dcm")


def places_of_slices(folder):
    """Of each by its SOP instance and its frame, if it is one."""
    places = {}
    for path in folder.iterdir():
        data = pydicom.dcmread(path, stop_before_pixels=True)
        for frame, groups in enumerate(data.get("PerFrameFunctionalGroupsSequence", []), 1):
            place = groups.PlanePositionSequence[0].ImagePositionPatient
            places[data.SOPInstanceUID, frame] = numpy.array(place, float)
        if "ImagePositionPatient" in data:
            places[data.SOPInstanceUID, None] = numpy.array(data.ImagePositionPatient, float)
    return places


def contours_of(path):
    """Of each ROI by name: its contours as (points, type, SOP instance), and the data set."""
    data = pydicom.dcmread(path)
    names = {roi.ROINumber: roi.ROIName for roi in data.StructureSetROISequence}
    found = {}
    for roi in data.ROIContourSequence:
        contours = found[names[roi.ReferencedROINumber]] = []
        for contour in roi.ContourSequence:
            image = contour.get("ContourImageSequence", [None])[0]
            image = image and (image.ReferencedSOPInstanceUID, image.get("ReferencedFrameNumber"))
            contours.append((numpy.array(contour.ContourData, float).reshape(-1, 3), contour.ContourGeometricType, image))
            assert contour.NumberOfContourPoints * 3 == len(contour.ContourData)
            assert all(len(str(x.original_string).strip()) <= 16 for x in contour.ContourData)
    return data, found


def area(points, along_i, along_j):
    x, y = points @ along_i, points @ along_j
    return (x * numpy.roll(y, -1) - numpy.roll(x, -1) * y).sum() / 2


def even_odd(rings, at, along_i, along_j):
    crossings = 0
    px, py = at @ along_i, at @ along_j
    for ring in rings:
        x, y = ring @ along_i, ring @ along_j
        u, v = numpy.roll(x, -1), numpy.roll(y, -1)
        spans = (y <= py) != (v <= py)
        crossings += int((x[spans] + (py - y[spans]) / (v - y)[spans] * (u - x)[spans] > px).sum())
    return crossings % 2 == 1


def conforms(run, name):
    if program := shutil.which("dciodvfy"):
        said = subprocess.run([program, name], cwd=run.folder, capture_output=True, text=True)
        # Debian's does not know that value of PS3.3, C.8.8.6.
        unknown = "Unrecognized enumerated value <CLOSEDPLANAR_XOR>"
        lines = (said.stdout + said.stderr).splitlines()
        errors = [line for line in lines if line.startswith("Error") and unknown not in line]
        assert not errors, errors
    if program := shutil.which("dcmdump"):
        subprocess.run([program, "-q", name], cwd=run.folder, check=True, stdout=subprocess.DEVNULL)


def slices(run, ct, along_i, along_j):
    """Structure sets on a CT: places, images, areas."""
    normal = numpy.cross(along_i, along_j)
    instances = places_of_slices(run.folder / ct)
    areas = []
    for holes in ("xor", "keyhole"):
        run("slice", "body.stl", "--like", ct, "--frame", "lps", "--holes", holes, "-o", "a.dcm", "--threads", "1")
        run("slice", "body.stl", "--like", ct, "--frame", "lps", "--holes", holes, "-o", "b.dcm", "--threads", "2")
        assert (run.folder / "a.dcm").read_bytes() == (run.folder / "b.dcm").read_bytes(), "bytes depend on threads"
        run("slice", "body.stl", "--like", ct, "--frame", "lps", "-o", "body.h5")
        run("convert", "body.h5", "--like", ct, "--holes", holes, "-o", "b.dcm")
        assert (run.folder / "a.dcm").read_bytes() == (run.folder / "b.dcm").read_bytes(), "convert differs"
        conforms(run, "a.dcm")
        data, rois = contours_of(run.folder / "a.dcm")
        assert data.PatientName == "Doe^Jane" and data.SeriesNumber == 301 and data.StudyInstanceUID == "1.2.826.0.1.3680043.8.498.7"
        (contours,) = rois.values()
        rings = {}
        for points, kind, instance in contours:
            assert kind == ("CLOSEDPLANAR_XOR" if holes == "xor" else "CLOSED_PLANAR"), kind
            assert numpy.abs((points - instances[instance]) @ normal).max() < 1e-6, "a contour beside its slice"
            rings.setdefault(instance, []).append(points)
        areas.append({i: sum(area(ring, along_i, along_j) for ring in all) for i, all in rings.items()})
        # Every voxel's centre is inside the mesh if and only if it is inside the contours.
        for instance, base in instances.items():
            for row in range(0, ROWS, 3):
                for column in range(0, COLUMNS, 2):
                    at = base + along_i * SPACING[0] * column + along_j * SPACING[1] * row
                    assert even_odd(rings.get(instance, []), at, along_i, along_j) == inside(at), (holes, at)
    assert areas[0].keys() == areas[1].keys()
    assert all(abs(areas[0][i] - areas[1][i]) < 1e-4 for i in areas[0]), "keyholes have another area"
    return {instances[i] @ normal: found for i, found in areas[0].items()}


def places_of_voxels(path):
    """Centres of the voxels that are not 0, in LPS."""
    image = nibabel.load(path)
    centres = nibabel.affines.apply_affine(image.affine, numpy.argwhere(numpy.asarray(image.dataobj) != 0))
    return centres * [-1, -1, 1]


def masks(run, ct):
    run("slice", "body.stl", "--like", ct, "--frame", "lps", "-o", "m.nii.gz")
    mine = places_of_voxels(run.folder / "m.nii.gz")
    assert all(inside(at) for at in mine) and len(mine) > 500
    if (program := shutil.which("plastimatch")) and ct not in ("tilted", "enhanced"):  # which it cannot read
        command = [program, "convert", "--input", "a.dcm", "--referenced-ct", ct]
        command += ["--output-prefix", f"of-{ct}", "--prefix-format", "nii.gz"]
        subprocess.run(command, cwd=run.folder, check=True, stdout=subprocess.DEVNULL)
        theirs = places_of_voxels(run.folder / f"of-{ct}" / "body.nii.gz")
        assert all(inside(at) for at in theirs), "plastimatch has the contours elsewhere"
        assert len(theirs) == len(mine), (ct, len(theirs), len(mine))


def segmentation(run, ct):
    """Frames lie on the slices of the CT, and hold the voxels of the masks of each mesh alone, as pydicom and dcmtk read them."""
    for flags in ("", "--coverage"):
        words = ["body.stl", "other.stl", "--like", ct, "--frame", "lps", *flags.split(), "--label-table", "labels.csv"]
        for threads in ("1", "2"):
            run("slice", *words, "-o", f"s{threads}.seg.dcm", "--threads", threads)
        assert (run.folder / "s1.seg.dcm").read_bytes() == (run.folder / "s2.seg.dcm").read_bytes(), "bytes depend on threads"
        conforms(run, "s1.seg.dcm")
        data = pydicom.dcmread(run.folder / "s1.seg.dcm")
        shared = data.SharedFunctionalGroupsSequence[0]
        along = numpy.array(shared.PlaneOrientationSequence[0].ImageOrientationPatient, float).reshape(2, 3)
        rows, columns = shared.PixelMeasuresSequence[0].PixelSpacing
        assert [s.SegmentLabel for s in data.SegmentSequence] == ["Körper", "other"]
        frames = data.pixel_array.reshape(-1, ROWS, COLUMNS)
        instances = places_of_slices(run.folder / ct)
        found = [{}, {}]
        for frame, groups in zip(frames, data.PerFrameFunctionalGroupsSequence):
            place = numpy.array(groups.PlanePositionSequence[0].ImagePositionPatient, float)
            source = groups.DerivationImageSequence[0].SourceImageSequence[0]
            source = instances[source.ReferencedSOPInstanceUID, source.get("ReferencedFrameNumber")]
            assert numpy.abs(place - source).max() < 1e-5, (place, source)
            segment = groups.SegmentIdentificationSequence[0].ReferencedSegmentNumber - 1
            for row, column in numpy.argwhere(frame):
                at = place + along[0] * float(columns) * column + along[1] * float(rows) * row
                found[segment][tuple(numpy.round(at, 3) + 0.0)] = frame[row, column]
        for segment, mesh in enumerate(("body", "other")):
            if ct == "uneven":
                continue  # which no mask is drawn on
            run("slice", f"{mesh}.stl", "--like", ct, "--frame", "lps", *flags.split(), "-o", "m.nii")
            image = nibabel.load(run.folder / "m.nii")
            voxels = numpy.asarray(image.dataobj.get_unscaled())
            theirs = numpy.array(sorted(found[segment]))
            index = nibabel.affines.apply_affine(numpy.linalg.inv(image.affine), theirs * [-1, -1, 1])
            again = numpy.zeros_like(voxels)
            again[tuple(numpy.round(index).astype(int).T)] = [found[segment][tuple(at)] for at in theirs]
            assert numpy.abs(index - numpy.round(index)).max() < 0.01 and numpy.array_equal(again, voxels), (ct, mesh, flags)
        if program := shutil.which("dcm2pnm"):
            for i in (0, len(frames) // 2, len(frames) - 1):
                subprocess.run([program, "+F", str(i + 1), "+op", "s1.seg.dcm", "f.pgm"], cwd=run.folder, check=True)
                theirs = numpy.frombuffer((run.folder / "f.pgm").read_bytes()[-ROWS * COLUMNS :], numpy.uint8)
                assert numpy.array_equal(theirs.reshape(ROWS, COLUMNS) > 127, frames[i] > (127 if flags else 0)), "dcm2pnm"


def refusals(run):
    """Those that need a CT; others: tests/medical/test_dicom.cpp, tests/cli/transcripts/refusals.txt."""
    straight = (numpy.array([1.0, 0, 0]), numpy.array([0, 1.0, 0]), (-25, -25, 9))
    even = [3 * k for k in range(9)]
    write_ct(run.folder / "two", *straight, even)
    for path in (run.folder / "two").iterdir():
        path.rename(path.with_name("x" + path.name))
    write_ct(run.folder / "two", *straight, even[:4], series="1.2.826.0.1.3680043.8.498.2")
    write_ct(run.folder / "uneven", *straight, [0, 3, 6, 7.5, 9, 14])
    mesh = "slice body.stl --frame lps "
    for words, status, says in (
        (mesh + "--like two -o r.dcm", 3,
         "498.1 'series 1' (9 slices); 1.2.826.0.1.3680043.8.498.2 'series 2' (4 slices)"),
        (mesh + "--like two --series 1.2.3 -o r.dcm", 3, "no images of the series 1.2.3; there is 1.2.826"),
        (mesh + "--like two --series 1.2.826.0.1.3680043.8.498.2 -o s.csv", 0, ""),
        ("verify --inputs s.csv", 0, ""),
        (mesh + "--like uneven -o r.nii", 3, "not evenly spaced (5 mm from uneven/"),
        (mesh + "--like uneven --subslices 2 -o r.dcm", 2, "on the slices themselves"),
        # A structure set may lie in the folder of the CT, and replaces none of its slices.
        (mesh + "--like axial -o body.h5", 0, ""),
        (mesh + "--like axial -o axial/3.dcm", 2, "'axial/3.dcm' is a slice of --like itself"),
        ("convert body.h5 --like axial -o axial/3.dcm", 2, "'axial/3.dcm' is a slice of --like itself"),
        (mesh + "--like axial -o axial/body.dcm", 0, ""),
        (mesh + "--like axial -o axial/body.dcm", 0, ""),
        (mesh + "--like uneven -o u.csv", 0, ""),
    ):  # fmt: skip
        run(*words.split(), status=status, says=says)
    assert not list(run.folder.glob("r.*")), "something was written"
    assert pydicom.dcmread(run.folder / "axial" / "3.dcm").Modality == "CT"
    heights = [float(line.split(",")[2]) for line in (run.folder / "u.csv").read_text().splitlines()[1:]]
    assert numpy.allclose(heights, [9, 12, 15, 16.5, 18, 23]), heights


def test_all(run):
    folder = run.folder
    (folder / "body.stl").write_bytes(stl(HOLLOW))
    (folder / "other.stl").write_bytes(stl(box((-12.3, -9, 15), (9, 13, 21.7))))
    (folder / "labels.csv").write_text("label,name,color,type\n1,Körper,#80ff00,SCT^91723000^Anatomical structure\n")
    i, j, k = numpy.eye(3)
    even = [2.87 * n for n in range(10)]
    turn = numpy.linalg.qr(numpy.array([[1.0, 0.2, 0.1], [-0.1, 1, 0.3], [0.2, -0.4, 1]]))[0]
    turn *= numpy.sign(numpy.diag(turn))
    a, b = turn[:, 0], turn[:, 1]
    for name, along_i, along_j, origin, heights, *tilt in (
        ("axial", i, j, (-25.2, -25.3, 9.1), even),
        ("uneven", i, j, (-25.2, -25.3, 9.1), [0, 2.8, 5.8, 7.5, 9, 14.1]),
        ("feet", i, -j, (-25.2, 25.3, 35.1), even),  # the normal leads to the feet
        ("tilted", i, j, (-25.2, -29.3, 9.1), even, 0.27),
        ("enhanced", i, j, (-25.2, -25.3, 9.1), even),
        ("coronal", i, -k, (-26.3, -19.2, 40.4), [3.9 * n for n in range(11)]),
        ("sagittal", j, -k, (32.3, -28.4, 40.2), [4.1 * n for n in range(13)]),
        ("oblique", a, b, -25.3 * a - 25.4 * b + 3.3 * numpy.cross(a, b), [2.7 * n for n in range(14)]),
    ):
        write_ct(folder / name, along_i, along_j, origin, heights, tilt=sum(tilt))
        if name == "enhanced":
            make_enhanced(folder / name)
        areas = slices(run, name, along_i, along_j)
        if name in ("axial", "tilted", "enhanced"):
            assert all(abs(found - area_at(height)) < 1e-4 for height, found in areas.items()), areas
        if name != "uneven":
            masks(run, name)
        segmentation(run, name)
    refusals(run)
    run("slice", "body.stl", "--frame", "lps", "--spacing", "1,1,2", "--without-ct", "-o", "w.dcm")
    conforms(run, "w.dcm")
    data, _ = contours_of(folder / "w.dcm")
    assert data.StructureSetDate == "" and data.StudyInstanceUID.startswith("2.25.")


main(test_all)
