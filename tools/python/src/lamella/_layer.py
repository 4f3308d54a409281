"""One layer of a result, and the numbers that stand in arrays, by name."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Any, List, NamedTuple, Tuple

import numpy as np
import numpy.typing as npt

from ._layer_set import SetMethods

if TYPE_CHECKING:
    import matplotlib.axes
    import shapely.geometry

    from ._result import Result


NO_TRIANGLE = 0xFFFFFFFF
"""In `Result.origins`: the edge comes from no triangle."""

SEVERAL_PARTS = 0xFFFFFFFF
"""In ``Result.contours["part"]``: its edges come from more than one part."""

SIDE = 160  # width and height of a picture, pixels
MOST_POINTS, MOST_CONTOURS = 4000, 500  # in a picture


class Role(enum.IntEnum):
    """The values of ``Result.contours["role"]``."""

    OUTER = 0
    """Closed, counter-clockwise, solid inside."""
    HOLE = 1
    """Closed, clockwise, solid outside."""
    FLAT = 2
    """Closed without area."""
    OPEN = 3
    """A polyline: the mesh lacks a face at both of its ends."""


class ContourFlag(enum.IntFlag):
    """The bits of ``Result.contours["flags"]``."""

    ORIENTATION_OVERRULED = 1
    """The facets' orientation contradicts the role, which was decided by the contours around."""
    ORIENTATION_MIXED = 2
    """Neighbouring facets disagree about which side is solid."""
    STITCHED = 4
    """Ends of open polylines were joined."""
    WOULD_CLOSE = 8
    """Closing by `flag_closing` would change it."""


class Polygon(NamedTuple):
    """An outer contour and what is cut out of it."""

    outer: npt.NDArray[np.float64]
    """Points (n, 2) in mm, counter-clockwise; the first is not repeated."""
    holes: List[npt.NDArray[np.float64]]
    """The same of each hole, clockwise."""


class Layer(SetMethods):
    """One layer of a `Result`: a view, of which nothing is computed until it is asked for.

    Attributes
    ----------
    result : Result
    index : int
        Of the layer in `result`.
    """

    __slots__ = ("index", "result")

    def __init__(self, result: Result, index: int) -> None:
        self.result = result
        self.index = index

    @property
    def z(self) -> float:
        """Height of the plane as it was asked for, mm."""
        return float(self.result.layers["z"][self.index])

    @property
    def bottom(self) -> float:
        """Lower end of what the layer stands for, mm."""
        return float(self.result.layers["bottom"][self.index])

    @property
    def top(self) -> float:
        """Upper end of what the layer stands for, mm."""
        return float(self.result.layers["top"][self.index])

    @property
    def area(self) -> float:
        """Solid area, mm²: outers minus holes. NaN, not known, where a contour is open."""
        return float(self.result.areas[self.index])

    @property
    def perimeter(self) -> float:
        """Length of all contours, mm. NaN, not known, where one is open."""
        return float(self.result.perimeters[self.index])

    @property
    def measures(self) -> np.void:
        """The row of `Result.measures`."""
        row: np.void = self.result.measures[self.index]
        return row

    @property
    def centroid(self) -> npt.NDArray[np.float64]:
        """Of the solid area, (2,), mm. NaN where there is none, or it is not known."""
        row = self.measures
        return np.array([row["centroid_x"], row["centroid_y"]])

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """Least and largest corner of the box around all points (2, 2), mm. NaN where there are none."""
        points = self.points
        return np.array([points.min(axis=0), points.max(axis=0)]) if len(points) > 0 else np.full((2, 2), np.nan)

    @property
    def contours(self) -> npt.NDArray[np.void]:
        """Rows of `Result.contours`: each outer followed by its holes. ``first_point`` and ``parent`` count within the result."""
        first, count = self._contour_range()
        return self.result.contours[first : first + count]

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """Points (n, 2) of all contours, mm."""
        return self.points_grid * self.result.grid

    @property
    def points_grid(self) -> npt.NDArray[np.int32]:
        """Points (n, 2) of all contours, grid units: a view."""
        contours = self.contours
        if len(contours) == 0:
            return self.result.points_grid[:0]
        last = contours[-1]
        return self.result.points_grid[contours["first_point"][0] : last["first_point"] + last["point_count"]]

    @property
    def to_3d(self) -> npt.NDArray[np.float64]:
        """Affine map (4, 4) from (x, y, 0) in the layer to the mesh's own space, mm."""
        lift = np.eye(4)
        lift[2, 3] = self.z
        return np.linalg.inv(self.result.frame) @ lift

    def points_in_mesh(self) -> npt.NDArray[np.float64]:
        """Points (n, 3) of all contours, mm, in the frame of the mesh."""
        to_3d = self.to_3d
        placed: npt.NDArray[np.float64] = self.points @ to_3d[:3, :2].T + to_3d[:3, 3]
        return placed

    def polygons(self) -> List[Polygon]:
        """The solid area, as outers with their holes.

        Examples
        --------
        >>> layer = lamella.slice(corners, faces, heights=[20])[0]
        >>> layer.polygons()[0].outer.round(3)
        array([[ 0.,  0.],
               [15.,  0.],
               [ 0., 15.]])
        """
        polygons: List[Polygon] = []
        for role, points in self._paths():
            if role == Role.OUTER:
                polygons.append(Polygon(points, []))
            elif role == Role.HOLE:
                polygons[-1].holes.append(points)
        return polygons

    def polylines(self) -> List[npt.NDArray[np.float64]]:
        """Open polylines, points (n, 2) in mm: the mesh lacks a face at both of their ends."""
        return [points for role, points in self._paths() if role == Role.OPEN]

    def to_shapely(self) -> shapely.geometry.MultiPolygon:
        """The solid area as a shapely MultiPolygon. Needs shapely.

        Contours that cross make it invalid for shapely; slicing with ``fill_rule="non-zero"`` leaves none that do.
        """
        from shapely.geometry import MultiPolygon

        return MultiPolygon([(polygon.outer, polygon.holes) for polygon in self.polygons()])

    def plot(self, ax: Any = None, **style: Any) -> matplotlib.axes.Axes:
        """Draw it with matplotlib: solid areas filled, open polylines as red lines.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to. Without it the current ones.
        **style
            For `matplotlib.patches.PathPatch`: ``facecolor``, ``linewidth``, ...
        """
        from matplotlib.patches import PathPatch
        from matplotlib.path import Path

        if ax is None:
            import matplotlib.pyplot as plt

            ax = plt.gca()
        axes: matplotlib.axes.Axes = ax
        closed = [path for role, path in self._paths() if role in (Role.OUTER, Role.HOLE)]
        if closed:  # as one compound path, so that holes stay empty
            rings = [Path(np.vstack((path, path[:1])), closed=True) for path in closed]
            axes.add_patch(PathPatch(Path.make_compound_path(*rings), **{"linewidth": 0.8, "edgecolor": "black", **style}))
        for line in self.polylines():
            axes.plot(line[:, 0], line[:, 1], color="red", linewidth=1)
        axes.autoscale_view()
        axes.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)")
        return axes

    def _contour_range(self) -> Tuple[int, int]:
        row = self.result.layers[self.index]
        return int(row["first_contour"]), int(row["contour_count"])

    def _paths(self) -> List[Tuple[Any, ...]]:
        """Role and points of each contour."""
        contours = self.contours
        if len(contours) == 0:
            return []
        points = self.points
        ends = np.cumsum(contours["point_count"])[:-1]
        return list(zip(contours["role"].tolist(), np.split(points, ends)))

    def __len__(self) -> int:
        return self._contour_range()[1]

    def __repr__(self) -> str:
        count = len(self)
        return f"<lamella.Layer {self.index}: z {self.z:g} mm, {count} contour{'s' if count != 1 else ''}, {self.area:.6g} mm²>"

    def _repr_html_(self) -> str:
        """A small picture for notebooks, y upwards: about MOST_POINTS points of the MOST_CONTOURS contours that have most."""
        points = self.points
        if len(points) == 0:
            return f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}"></svg>'
        low, high = points.min(axis=0), points.max(axis=0)
        scale = (SIDE - 4) / max(float((high - low).max()), 1e-300)
        step = -(-len(points) // MOST_POINTS)
        paths = self._paths()
        solid: List[str] = []
        lines: List[str] = []
        for i in np.sort(np.argsort([-len(path) for _, path in paths], kind="stable")[:MOST_CONTOURS]):
            role, path = paths[i]
            kept = path[::step] if len(path) > 3 * step else path
            drawn = np.column_stack((kept[:, 0] - low[0], high[1] - kept[:, 1])) * scale + 2
            text = "M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in drawn.tolist())
            (lines if role == Role.OPEN else solid).append(text if role == Role.OPEN else text + "z")
        width, height = (high - low) * scale + 4
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}">'
            f'<path d="{"".join(solid)}" fill="#9db8d2" fill-rule="evenodd" stroke="#20435f" stroke-width="0.7"/>'
            f'<path d="{"".join(lines)}" fill="none" stroke="#c03020"/></svg>'
        )

    def __reduce__(self) -> Tuple[Any, ...]:
        return (Layer, (self.result, self.index))
