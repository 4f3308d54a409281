"""A mesh cut by VTK's filters from Python, contours joined by vtkStripper. Needs python3-vtk9."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints, vtkSMPTools, vtkVersion
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPlane, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkCutter, vtkStripper

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


class Cutter:
    """vtkCutter, by one plane or by several in one pass."""

    def __init__(self, mesh):
        self._cutter = vtkCutter()
        self._cutter.SetInputData(mesh)
        horizontal = vtkPlane()
        horizontal.SetNormal(0, 0, 1)
        self._cutter.SetCutFunction(horizontal)
        self._stripper = vtkStripper()
        self._stripper.SetMaximumLength(LONGEST_POLYLINE)
        self._stripper.JoinContiguousSegmentsOn()
        self._stripper.SetInputConnection(self._cutter.GetOutputPort())

    def cut(self, heights):
        self._cutter.SetNumberOfContours(len(heights))
        for i, height in enumerate(heights):
            self._cutter.SetValue(i, height)
        self._cutter.Modified()  # else the same heights would not be cut again
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
