"""Results as objects of other packages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List

import numpy as np
import numpy.typing as npt

from ._layer import Role

if TYPE_CHECKING:
    from ._result import Result


def lines_of(result: Result) -> List[npt.NDArray[np.float64]]:
    """Points (n, 3) of each contour in the mesh's frame; closed ones end where they begin."""
    ends = np.cumsum(result.contours["point_count"])[:-1]
    paths = np.split(result.points_in_mesh(), ends) if len(result.contours) > 0 else []
    is_open = result.contours["role"] == Role.OPEN
    return [path if led else np.vstack((path, path[:1])) for path, led in zip(paths, is_open)]


def to_vtk(result: Result) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    contours = result.contours
    counts = contours["point_count"].astype(np.int64)
    closed = (contours["role"] != Role.OPEN).astype(np.int64)
    offsets = np.concatenate(([0], np.cumsum(counts + closed)))
    ids = np.arange(offsets[-1]) - np.repeat(np.cumsum(closed) - closed, counts + closed)
    last = offsets[1:][closed == 1] - 1  # the first point again
    ids[last] = contours["first_point"][closed == 1]
    points, lines, data = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(result.points_in_mesh(), deep=True))
    lines.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(ids, deep=True))
    data.SetPoints(points)
    data.SetLines(lines)
    cells: Dict[str, npt.NDArray[Any]] = {
        "layer": result._layer_of_contours + result.first_layer, "role": contours["role"].astype(np.int32), "part": contours["part"].astype(np.int64),
    }  # fmt: skip
    view = result._view
    known = view is not None and not view.of_parts and len(result.origins) == len(result.points_grid)
    carried = {name: result.scalars(name) for name in view._meshes[0].scalars} if view is not None and known else {}
    for attributes, columns in ((data.GetCellData(), cells), (data.GetPointData(), carried)):
        for name, values in columns.items():
            array = numpy_to_vtk(values, deep=True)
            array.SetName(name)
            attributes.AddArray(array)
    return data


def to_trimesh(result: Result) -> Any:
    from trimesh.path.exchange.misc import lines_to_path
    from trimesh.path.path import Path3D

    segments = [np.stack((line[:-1], line[1:]), axis=1) for line in lines_of(result)]
    return Path3D(**lines_to_path(np.concatenate(segments) if segments else np.empty((0, 2, 3))))


def to_geopandas(result: Result) -> Any:
    import geopandas
    from shapely.geometry import Polygon

    polygons = [Polygon(polygon.outer, polygon.holes) for layer in result for polygon in layer.polygons()]
    return geopandas.GeoDataFrame(result.layers_frame(islands=True), geometry=polygons)


def plot_stack(result: Result, ax: Any, most: int, style: Dict[str, Any]) -> Any:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    if ax is None:
        import matplotlib.pyplot as plt

        ax = plt.figure().add_subplot(projection="3d")
    step = max(1, -(-len(result) // max(most, 1)))
    shown = result._layer_of_contours % step == 0
    lines = [line for line, drawn in zip(lines_of(result), shown) if drawn]
    ax.add_collection3d(Line3DCollection(lines, **{"linewidths": 0.7, "colors": "#20435f", **style}))
    points = np.concatenate(lines) if lines else np.zeros((1, 3))
    low, high = points.min(axis=0), points.max(axis=0)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]), xlabel="x (mm)", ylabel="y (mm)", zlabel="z (mm)")
    ax.set_box_aspect(np.maximum(high - low, 1e-9))
    return ax
