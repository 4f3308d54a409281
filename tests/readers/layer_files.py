#!/usr/bin/env python3
"""Files of layers, read by programs that nobody here wrote: layer_files.py LAMELLA. Ends with 77 where one of them is missing."""

import ctypes
import json
import math
import shutil
import subprocess

import support

ezdxf, geometry, xml, core = support.need("ezdxf", "shapely.geometry", "vtkmodules.vtkIOXML", "vtkmodules.util.numpy_support")


def tube():
    """A cube of 10 mm with a hole of 4 x 4 mm through it."""
    outer, inner = [(0, 0), (10, 0), (10, 10), (0, 10)], [(3, 3), (7, 3), (7, 7), (3, 7)]
    triangles = []
    for i in range(4):
        (a, b), (c, d) = ([ring[i], ring[(i + 1) % 4]] for ring in (outer, inner))
        for p, q, up, down in ((a, b, 10, 0), (d, c, 10, 0)):
            triangles += [[(*p, down), (*q, down), (*q, up)], [(*p, down), (*q, up), (*p, up)]]
        for p, q, r, s, z in ((a, b, d, c, 10), (b, a, c, d, 0)):
            triangles += [[(*p, z), (*q, z), (*r, z)], [(*p, z), (*r, z), (*s, z)]]
    return support.stl(triangles)


class ThreeMf:
    """lib3mf 1.8 by its C interface."""

    def __init__(self, path):
        try:
            self.library = ctypes.CDLL("lib3MF.so.1")
        except OSError as error:
            support.skip(error)
        self.model = self.get(ctypes.c_void_p, "createmodel")
        reader = self.get(ctypes.c_void_p, "model_queryreader", self.model, b"3mf")
        self.call("reader_readfromfileutf8", reader, str(path).encode())
        self.warnings = self.get(ctypes.c_uint32, "reader_getwarningcount", reader)

    def call(self, name, *words):
        assert getattr(self.library, "lib3mf_" + name)(*words) == 0, name

    def get(self, kind, name, *words):
        value = kind()
        self.call(name, *words, ctypes.byref(value))
        return value if kind is ctypes.c_void_p else value.value

    def objects(self):
        """(triangles, resolution, slices as (top, vertices, polygons)) of each."""
        each = self.get(ctypes.c_void_p, "model_getmeshobjects", self.model)
        while self.get(ctypes.c_int32, "resourceiterator_movenext", each):
            one = self.get(ctypes.c_void_p, "resourceiterator_getcurrent", each)
            assert self.get(ctypes.c_int32, "meshobject_ismanifoldandoriented", one)
            number = self.get(ctypes.c_uint32, "meshobject_getslicestackid", one)
            stack = self.get(ctypes.c_void_p, "model_getslicestackById", self.model, number)
            slices = [self.slice(stack, i) for i in range(self.get(ctypes.c_uint32, "slicestack_getslicecount", stack))]
            numbers = [self.get(ctypes.c_uint32, "meshobject_" + name, one) for name in ("gettrianglecount", "getslicesmeshresolution")]
            yield (*numbers, slices)

    def slice(self, stack, index):
        one = self.get(ctypes.c_void_p, "slicestack_getslice", stack, index)
        points = (ctypes.c_float * 2 * self.get(ctypes.c_uint32, "slice_getvertexcount", one))()
        self.call("slice_getvertices", one, points, len(points))
        polygons = []
        for polygon in range(self.get(ctypes.c_uint32, "slice_getpolygoncount", one)):
            ids = (ctypes.c_uint32 * self.get(ctypes.c_uint32, "slice_getpolygonindexcount", one, polygon))()
            self.call("slice_getpolygonindices", one, polygon, ids, len(ids))
            polygons.append(list(ids))
        return self.get(ctypes.c_float, "slice_gettopz", one), [tuple(point) for point in points], polygons


def by_lib3mf(run):
    run("slice", "cube.stl", *CUT, "-o", "c.3mf")
    model = ThreeMf(run.folder / "c.3mf")
    assert model.warnings == 0
    ((triangles, resolution, slices),) = model.objects()
    assert (triangles, resolution) == (12, 1), (triangles, resolution)  # lowres
    assert [top for top, _, _ in slices] == list(range(1, 11))
    for _, points, polygons in slices:
        assert sorted(points) == [(0, 0), (0, 10), (10, 0), (10, 10)] and polygons == [[0, 1, 2, 3, 0]]
    (run.folder / "two.obj").write_text("".join(f"g part<{i}>&\n{obj(10 * i, 4 * i)}" for i in (1, 2)))
    run("slice", "two.obj", "--split", "objects", *CUT, "-o", "two.3mf")
    model = ThreeMf(run.folder / "two.3mf")
    assert model.warnings == 0
    areas = [[abs(geometry.Polygon([points[i] for i in ids]).area) for ids in polygons] for _, _, s in model.objects() for _, points, polygons in s]
    assert areas == [[16]] * 4 + [[]] * 4 + [[64]] * 8, areas
    (run.folder / "gap.obj").write_text(obj(0, 4) + obj(0, 5, 5))  # z 0 to 4 and 5 to 10
    for heights, tops in (("--layer-height=1", list(range(1, 11))), ("--planes=0.5,1,3", [0.75, 2, 4])):
        run("slice", "gap.obj", heights, "-o", "gap.3mf")
        ((_, _, slices),) = ThreeMf(run.folder / "gap.3mf").objects()
        assert [top for top, _, _ in slices] == tops, slices
        assert [points == [] for _, points, _ in slices] == [top == 5 for top in tops]
    run("slice", "gyroid.stl", "--layer-height", "0.1", "-o", "g.3mf", "--to", "3mf-slices,geojson,vtp")
    ((_, _, slices),) = ThreeMf(run.folder / "g.3mf").objects()
    rings = [ring for polygons in solids(run.folder / "g.geojson") for polygon in polygons for ring in polygon]
    by_slices = [[points[i] for i in ids] for _, points, polygons in slices for ids in polygons]
    points, lines, _ = polylines(run.folder / "g.vtp")
    assert len(points) > 100000  # more than is kept in memory
    assert len(rings) == len(by_slices) == len(lines)
    for ring, own, ids in zip(rings, by_slices, lines):
        for other in (own, points[ids, :2]):
            assert len(ring) == len(other) and all(math.dist(a, b) < 1e-5 for a, b in zip(ring, other))  # 32-bit floats


def solids(path):
    return [feature["geometry"]["coordinates"] for feature in json.loads(path.read_text())["features"]]


def obj(x, side, z=0):
    triangles = support.box((x, 0, z), (x + side, side, z + side))
    return "".join("".join("v %g %g %g\n" % tuple(p) for p in t) + "f -3 -2 -1\n" for t in triangles)


def by_ezdxf(run):
    run("slice", "tube.stl", *CUT, "-o", "r.dxf")
    drawing = ezdxf.readfile(run.folder / "r.dxf")
    assert not drawing.audit().has_errors and drawing.dxfversion == "AC1009"
    lines = list(drawing.modelspace().query("POLYLINE"))
    assert [line.dxf.layer for line in lines] == [f"Z{i:05}{end}" for i in range(10) for end in ("", "_HOLE")]
    for i, line in enumerate(lines):
        assert line.is_closed and line.dxf.elevation.z == i // 2 + 0.5 and len(line) == 4
        area = geometry.Polygon([tuple(point)[:2] for point in line.points()]).area
        assert area == (16 if i % 2 else 100), area
    run("slice", "tube.stl", *CUT, "-o", "{layer:04}.dxf")
    singles = sorted(run.folder.glob("0*.dxf"))
    assert [path.name for path in singles] == [f"{i:04}.dxf" for i in range(10)]
    assert all(len(ezdxf.readfile(path).modelspace().query("POLYLINE")) == 2 for path in singles)


def by_shapely_and_gdal(run):
    run("slice", "tube.stl", *CUT, "-o", "r.geojson")
    read = json.loads((run.folder / "r.geojson").read_text())
    assert read["unit"] == "mm" and [f["properties"]["z"] for f in read["features"]] == [i + 0.5 for i in range(10)]
    for feature in read["features"]:
        solid = geometry.shape(feature["geometry"])
        (polygon,) = solid.geoms
        assert solid.is_valid and solid.area == 84 and polygon.exterior.is_ccw
        assert [hole.is_ccw for hole in polygon.interiors] == [False]
    run("slice", "open.stl", "--layer-height", "1", "-o", "o.geojson")
    lines = json.loads((run.folder / "o.geojson").read_text())["features"]
    assert [feature["geometry"]["type"] for feature in lines] == ["MultiLineString"] * 10
    ogr = shutil.which("ogrinfo") or support.skip("no ogrinfo")
    said = subprocess.run([ogr, "-al", "-so", "r.geojson"], cwd=run.folder, check=True, capture_output=True, text=True)
    assert "Feature Count: 10" in said.stdout and "Multi Polygon" in said.stdout and not said.stderr, said
    assert "Extent: (0.000000, 0.000000) - (10.000000, 10.000000)" in said.stdout


def by_vtk(run):
    run("slice", "tube.stl", "--drop-collinear", "--planes", ",".join(str(i + 0.5) for i in range(10)), "-o", "r.vtp")
    assert lengths(*polylines(run.folder / "r.vtp")) == [40, 16] * 10
    normal = (1, 2, 3)
    run("slice", "tube.stl", "--normal", ",".join(map(str, normal)), "--layer-height", "1", "-o", "t.vtp")
    points, lines, data = polylines(run.folder / "t.vtp")
    assert sorted(data) == ["layer", "part", "role", "z"] and set(data["role"]) == {0, 1} and set(data["part"]) == {0}
    size = math.sqrt(14)
    for line, z, layer, role in zip(lines, data["z"], data["layer"], data["role"]):
        assert line[0] == line[-1]
        for x, y, height in points[line]:
            assert abs((x + 2 * y + 3 * height) / size - z) < 4e-6, (x, y, height, z)
            on_faces = [abs(v - at) for v in (x, y) for at in (0, 3, 7, 10)] + [abs(height - at) for at in (0, 10)]
            assert min(on_faces) < 4e-6 and min(x, y, height) > -4e-6 and max(x, y, height) < 10 + 4e-6
    assert sorted(set(data["layer"])) == list(range(max(data["layer"]) + 1))


def polylines(path):
    reader = xml.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    mesh = reader.GetOutput()
    ends = core.vtk_to_numpy(mesh.GetLines().GetOffsetsArray())
    ids = core.vtk_to_numpy(mesh.GetLines().GetConnectivityArray())
    data = {mesh.GetCellData().GetArrayName(i): core.vtk_to_numpy(mesh.GetCellData().GetArray(i)) for i in range(mesh.GetCellData().GetNumberOfArrays())}
    return core.vtk_to_numpy(mesh.GetPoints().GetData()), [ids[a:b] for a, b in zip(ends[:-1], ends[1:])], data


def lengths(points, lines, _):
    assert all(len(line) == 5 for line in lines)
    return [round(sum(math.dist(points[a], points[b]) for a, b in zip(line[:-1], line[1:])), 4) for line in lines]


CUT = ("--layer-height", "1", "--drop-collinear")


def test(run):
    box = support.box((0, 0, 0), (10, 10, 10))
    (run.folder / "cube.stl").write_bytes(support.stl(box))
    (run.folder / "open.stl").write_bytes(support.stl(box[:4] + box[5:]))
    (run.folder / "tube.stl").write_bytes(tube())
    run("make", "gyroid", "--triangles", "60000", "-o", "gyroid.stl")
    for read in (by_lib3mf, by_ezdxf, by_shapely_and_gdal, by_vtk):
        read(run)
    return "3MF by lib3mf, DXF by ezdxf, GeoJSON by shapely and GDAL, VTP by VTK"


support.main(test)
