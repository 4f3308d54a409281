"""A mesh cut by VTK's filters from Python, contours joined by vtkStripper. Needs python3-vtk9."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints, vtkSMPTools, vtkVersion
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPlane, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkCleanPolyData, vtkCutter, vtkPlaneCutter, vtkStripper

VERSION = vtkVersion.GetVTKVersion()
LONGEST_POLYLINE = 100000  # VTK accepts no longer ones


def use_threads(count):
    vtkSMPTools.Initialize(count)


def poly_data(vertices, faces):
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices), deep=True))
    cells = vtkCellArray()
    offsets = numpy_to_vtkIdTypeArray(np.arange(0, 3 * len(faces) + 1, 3, dtype=np.int64), deep=True)
    cells.SetData(offsets, numpy_to_vtkIdTypeArray(faces.astype(np.int64).ravel(), deep=True))
    mesh = vtkPolyData()
    mesh.SetPoints(points)
    mesh.SetPolys(cells)
    return mesh


def _horizontal():
    plane = vtkPlane()
    plane.SetNormal(0, 0, 1)
    return plane


def _stripper():
    stripper = vtkStripper()
    stripper.SetMaximumLength(LONGEST_POLYLINE)
    stripper.JoinContiguousSegmentsOn()
    return stripper


class Cutter:
    """vtkCutter, by one plane or by several in one pass."""

    name = "vtkCutter"

    def __init__(self, mesh):
        self._cutter = vtkCutter()
        self._cutter.SetInputData(mesh)
        self._cutter.SetCutFunction(_horizontal())
        self._stripper = _stripper()
        self._stripper.SetInputConnection(self._cutter.GetOutputPort())

    def cut(self, heights):
        self._cutter.SetNumberOfContours(len(heights))
        for i, height in enumerate(heights):
            self._cutter.SetValue(i, height)
        self._cutter.Modified()  # else the same heights would not be cut again
        self._stripper.Update()
        return self._stripper.GetOutput()


class PlaneCutter:
    """vtkPlaneCutter, VTK's faster filter, by one plane. Each of its threads gives lines whose points are not merged."""

    name = "vtkPlaneCutter"

    def __init__(self, mesh):
        self._plane = _horizontal()
        self._cutter = vtkPlaneCutter()
        self._cutter.SetInputData(mesh)
        self._cutter.SetPlane(self._plane)
        self._cutter.ComputeNormalsOff()
        self._cutter.InterpolateAttributesOff()
        self._append = vtkAppendPolyData()
        self._clean = vtkCleanPolyData()
        self._clean.SetInputConnection(self._append.GetOutputPort())
        self._clean.ToleranceIsAbsoluteOn()
        self._clean.SetAbsoluteTolerance(0)
        self._stripper = _stripper()
        self._stripper.SetInputConnection(self._clean.GetOutputPort())

    def cut(self, heights):
        (height,) = heights
        self._plane.SetOrigin(0, 0, height)
        self._cutter.Modified()
        self._cutter.Update()
        pieces = self._cutter.GetOutputDataObject(0)
        self._append.RemoveAllInputs()
        for i in range(pieces.GetNumberOfPartitions()):
            self._append.AddInputData(pieces.GetPartition(i))
        self._stripper.Update()
        return self._stripper.GetOutput()


def polylines(output):
    """Polylines of what a cutter gave: arrays (n, 3), the first point of closed ones repeated."""
    if output.GetNumberOfLines() == 0:
        return []
    points = vtk_to_numpy(output.GetPoints().GetData())
    lines = output.GetLines()
    ends = vtk_to_numpy(lines.GetOffsetsArray())
    order = vtk_to_numpy(lines.GetConnectivityArray())
    return [points[order[a:b]] for a, b in zip(ends[:-1], ends[1:])]
