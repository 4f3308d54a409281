"""Sections where labs take them: along an axis, square to a curve, by planes of any direction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Tuple

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import MeshWarning, warn
from ._layer import Role
from ._mesh import MeshLike, View, as_view
from ._option_table import UniformOptions
from ._options import SectionKeywords, direction, one_of, refuse, rows_of, slice_options, truth, whole_array
from ._result import Result
from ._slice import Prepared

if TYPE_CHECKING:
    from typing_extensions import Unpack

Array = npt.NDArray[np.float64]
KEEP = ("all", "nearest")


class Axis(NamedTuple):
    """A line through a body."""

    origin: Array
    """Its lower end, mm: the least projection of a vertex."""
    direction: Array
    """Unit vector."""
    length: float
    """From the least to the greatest projection of a vertex, mm."""
    ratio: float
    """Largest to middle spread of the volume: near 1 there is no axis."""


class Sections(Result):
    """A `Result` of which each layer is a plane with a frame of its own.

    Attributes
    ----------
    frames : ndarray (n, 4, 4)
        Affine maps from (x, y, 0, 1) in each section to the mesh's space, mm.
    along : ndarray (n,)
        Places on the curve or axis, mm. NaN without one.
    fraction : ndarray (n,)
        The same as a share of its length.
    overlap : ndarray (n - 1,)
        Share of the points of neighbours that lies beyond the other's plane: above 0 the planes cross within the body.
    """

    def __init__(self, native: _native.Result, view: Optional[View], frames: Array, along: Array, fraction: Array) -> None:
        super().__init__(native, view)
        self.frames = frames
        self.along = along
        self.fraction = fraction

    def points_in_mesh(self) -> Array:
        layer = np.repeat(self._layer_of_contours, self.contours["point_count"])
        frames = self.frames[layer]
        placed: Array = np.einsum("nij,nj->ni", frames[:, :3, :2], self.points) + frames[:, :3, 3]
        return placed

    def layers_frame(self, *, islands: bool = False) -> Any:
        """`measures` as a pandas DataFrame, with ``along`` and ``fraction``."""
        frame = super().layers_frame(islands=islands)
        frame.insert(1, "along", self.along[frame["layer"]])
        frame.insert(2, "fraction", self.fraction[frame["layer"]])
        return frame

    @property
    def overlap(self) -> Array:
        points, layer = self.points_in_mesh(), np.repeat(self._layer_of_contours, self.contours["point_count"])

        def beyond(other: int, sign: float) -> Array:
            to = np.clip(layer + other, 0, len(self) - 1)
            ahead = np.einsum("ni,ni->n", points - self.frames[to, :3, 3], self.frames[to, :3, 2])
            counts = np.bincount(layer, minlength=len(self))
            shares: Array = np.bincount(layer, sign * ahead > self.grid, len(self)) / np.maximum(counts, 1)
            return shares[:-1] if other > 0 else shares[1:]

        return np.maximum(beyond(1, 1.0), beyond(-1, -1.0)) if len(self) > 1 else np.empty(0)

    def __reduce__(self) -> Tuple[Any, ...]:
        return (_restore, (self._native.state(), self.frames, self.along, self.fraction))


def _restore(state: Tuple[Any, ...], *frames: Array) -> Sections:
    return Sections(_native.restore(state), None, *frames)


def length_axis(mesh: MeshLike, faces: Optional[npt.ArrayLike] = None, *, towards: npt.ArrayLike = (0, 0, 1)) -> Axis:
    """The long axis of a closed mesh: of its volume, through the centroid.

    Parameters
    ----------
    mesh, faces
        As for `slice`.
    towards : array_like, shape (3,)
        The axis points to its side.

    Examples
    --------
    >>> axis = lamella.length_axis(corners * [0.1, 0.1, 1], faces)
    >>> axis.direction.round(2), round(axis.length, 1)
    (array([-0.03, -0.03,  1.  ]), 40.1)
    """
    read = _view_of(mesh, faces)._meshes[0]
    if np.isnan(read.volume):
        refuse("the mesh is open: it has no volume whose axis could be told")
    triangles = read.triangles.astype(np.float64) * read.unit
    middle = read.bounds.mean(axis=0)
    a, b, c = np.moveaxis(triangles - middle, 1, 0)
    six_volumes = np.einsum("ni,ni->n", a, np.cross(b, c))
    volume = six_volumes.sum() / 6
    if volume == 0:
        refuse("the mesh has no volume")
    total = a + b + c
    centroid = six_volumes @ total / 24 / volume
    spread = sum((np.einsum("n,ni,nj->ij", six_volumes, p, p) for p in (total, a, b, c)), np.zeros((3, 3))) / 120 / volume
    values, vectors = np.linalg.eigh(spread - np.outer(centroid, centroid))
    way = vectors[:, 2]
    if way @ direction("towards", towards) < 0:
        way = -way
    ratio = float(values[2] / values[1]) if values[1] > 0 else float("inf")
    if ratio < 1.05:
        warn(f"the mesh is as thick as long (ratio {ratio:.3g}): its axis is a matter of chance", MeshWarning)
    projections = (read.vertices * read.unit - middle - centroid) @ way
    low, high = float(projections.min()), float(projections.max())
    return Axis(middle + centroid + low * way, way, high - low, ratio)


def sections(
    mesh: MeshLike,
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    *,
    up: Optional[npt.ArrayLike] = None,
    keep: str = "all",
    **options: Unpack[SectionKeywords],
) -> Sections:
    """Cut a mesh by many planes of any direction, in one call and in parallel.

    Parameters
    ----------
    mesh : mesh
        As for `slice`; vertices and faces as a pair.
    points, normals : array_like, shape (n, 3)
        A point of each plane in mm, which becomes its (0, 0), and what it is perpendicular to. One normal serves all.
    up : array_like, shape (3,), optional
        Direction that the x axes follow as far as they can. Without it the axis of space that is most square to the normal.
    keep : {"all", "nearest"}
        "nearest": of each section the island that holds its origin, else the nearest, with its holes.
    **options
        As for `slice`, without heights, `normal` and `transform`.

    Examples
    --------
    >>> cuts = lamella.sections((corners, faces), points=[[0, 0, 10], [0, 0, 20]], normals=[0, 0, 1])
    >>> cuts.areas.round(3)
    array([253.125, 112.5  ])
    """
    origins = rows_of("points", 3, np.atleast_2d(whole_array(points, "points")))
    ways = np.broadcast_to(np.atleast_2d(whole_array(normals, "normals")), origins.shape)
    normal = np.array([direction(f"normals[{i}]", way) for i, way in enumerate(ways)]).reshape(origins.shape)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    across = np.array([_square_to(way, up) for way in normal]).reshape(origins.shape)
    nowhere = np.full(len(origins), np.nan)
    return _cut(mesh, origins, across, normal, nowhere, nowhere, keep, options)


def sections_along(
    mesh: MeshLike,
    curve: Optional[npt.ArrayLike] = None,
    *,
    axis: Optional[Axis] = None,
    at: Optional[npt.ArrayLike] = None,
    mm: Optional[npt.ArrayLike] = None,
    up: Optional[npt.ArrayLike] = None,
    closed: bool = False,
    keep: str = "all",
    **options: Unpack[SectionKeywords],
) -> Sections:
    """Cut a mesh square to a curve, or to an axis.

    The frames of neighbouring sections turn as little against one another as they can.

    Parameters
    ----------
    mesh : mesh
        As for `slice`; vertices and faces as a pair.
    curve : array_like, shape (n, 3)
        Points of a centreline, mm.
    axis : Axis
        Instead: a straight one, as of `length_axis`.
    at : array_like of float
        Fractions of the length, 0 to 1.
    mm : array_like of float
        Instead: lengths from the beginning. Without both a plane at each point of the curve.
    up : array_like, shape (3,), optional
        Direction of the first x axis, as far as it can.
    closed : bool
        The curve's last point leads to its first. The turn that is left over after a round is shared out.
    keep : {"all", "nearest"}
        "nearest": of each section the island that holds the curve's point, else the nearest, with its holes.
    **options
        As for `slice`, without heights, `normal` and `transform`.

    Examples
    --------
    >>> limb = (corners * [0.1, 0.1, 1], faces)
    >>> cuts = lamella.sections_along(limb, axis=lamella.length_axis(limb), at=[0.2, 0.5, 0.8])
    >>> cuts.layers_frame()[["fraction", "area"]].round(3).values.tolist()
    [[0.2, 2.882], [0.5, 1.126], [0.8, 0.18]]
    """
    if (curve is None) == (axis is None):
        refuse("one of curve and axis says where planes lie")
    if at is not None and mm is not None:
        refuse("at and mm exclude each other")
    if axis is not None:
        points = np.array([axis.origin, axis.origin + axis.length * axis.direction])
        if at is None and mm is None:
            refuse("at or mm says where along the axis planes lie")
    else:
        points = rows_of("curve", 3, curve)
    path = _Path(points, truth("closed", closed) and axis is None)
    given = at if at is not None else mm
    along = path.starts if given is None else np.atleast_1d(whole_array(given, "at" if at is not None else "mm")) * (path.length if at is not None else 1)
    if along.ndim != 1 or not ((along >= 0) & (along <= path.length * (1 + 1e-12))).all():
        refuse(f"places along the curve must lie between 0 and its length of {path.length:g} mm")
    origins, across, normal = path.frames(along, up)
    return _cut(mesh, origins, across, normal, along, along / path.length, keep, options)


class _Path:
    """A polyline by its length, with tangents at its points."""

    def __init__(self, points: Array, closed: bool) -> None:
        if not np.isfinite(points).all():
            refuse(f"curve[{np.argwhere(~np.isfinite(points))[0, 0]}] is not finite")
        repeated = np.r_[False, (np.diff(points, axis=0) == 0).all(axis=1)]
        points = points[~repeated]
        if closed and len(points) > 1 and (points[0] == points[-1]).all():
            points = points[:-1]
        if len(points) < (3 if closed else 2):
            refuse(f"a {'closed ' if closed else ''}curve has at least {3 if closed else 2} different points")
        self.closed = closed
        self.points = np.vstack((points, points[:1])) if closed else points
        steps = np.diff(self.points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        self.ends = np.concatenate(([0.0], np.cumsum(lengths)))
        self.starts = self.ends[:-1] if closed else self.ends
        self.length = float(self.ends[-1])
        self.tangents = self._tangents(steps / lengths[:, None], lengths)

    def _tangents(self, chords: Array, lengths: Array) -> Array:
        """Of the parabola through a point and its neighbours."""
        before, after = chords[:-1], chords[1:]
        turned = np.flatnonzero(np.einsum("ni,ni->n", before, after) < 1e-9 - 1)
        if len(turned) > 0:
            refuse(f"the curve turns back at point {turned[0] + 1}: no plane is square to it there")
        inner = lengths[:-1, None] * after + lengths[1:, None] * before
        first, last = chords[:1], chords[-1:]
        if self.closed:
            first = last = lengths[-1] * chords[:1] + lengths[0] * chords[-1:]
        tangents = np.vstack((first, inner, last))
        size = np.linalg.norm(tangents, axis=1)
        unit: Array = tangents / size[:, None]
        return unit

    def frames(self, along: Array, up: Optional[npt.ArrayLike]) -> Tuple[Array, Array, Array]:
        """Origins, x axes and normals: the x axes carried along by double reflection (Wang, Jüttler, Zheng and Liu 2008)."""
        every = np.union1d(self.ends, along)
        span = np.clip(np.searchsorted(self.ends, every, side="right") - 1, 0, len(self.ends) - 2)
        share = ((every - self.ends[span]) / (self.ends[span + 1] - self.ends[span]))[:, None]
        points = self.points[span] * (1 - share) + self.points[span + 1] * share
        normals = self.tangents[span] * (1 - share) + self.tangents[span + 1] * share
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        across = np.empty_like(normals)
        across[0] = _square_to(normals[0], up)
        for i in range(len(every) - 1):
            across[i + 1] = _carried(points[i], points[i + 1], normals[i], normals[i + 1], across[i])
        if self.closed:
            self._share_out(across, normals, every)
        chosen = np.searchsorted(every, along)
        return points[chosen], across[chosen], normals[chosen]

    def _share_out(self, across: Array, normals: Array, every: Array) -> None:
        left = np.arctan2(np.cross(across[-1], across[0]) @ normals[0], across[-1] @ across[0])
        turn = (left * every / self.length)[:, None]
        across[:] = np.cos(turn) * across + np.sin(turn) * np.cross(normals, across)


def _carried(x: Array, next_x: Array, t: Array, next_t: Array, r: Array) -> Array:
    step = next_x - x
    square = step @ step
    r_left, t_left = r - 2 / square * (step @ r) * step, t - 2 / square * (step @ t) * step
    turn = next_t - t_left
    square = turn @ turn
    made = r_left if square == 0 else r_left - 2 / square * (turn @ r_left) * turn
    made = made - (made @ next_t) * next_t
    unit: Array = made / np.linalg.norm(made)
    return unit


def _square_to(normal: Array, up: Optional[npt.ArrayLike]) -> Array:
    wanted = np.eye(3)[int(np.argmin(np.abs(normal)))] if up is None else direction("up", up)
    across = wanted - (wanted @ normal) * normal
    size = np.linalg.norm(across)
    if size < 1e-9 * np.linalg.norm(wanted):
        refuse("up runs along the normal of a plane")
    unit: Array = across / size
    return unit


def _view_of(mesh: MeshLike, faces: Any = None, unit: Any = None) -> View:
    return mesh._view if isinstance(mesh, Prepared) else as_view(mesh, faces, unit=unit)


def _cut(mesh: MeshLike, origins: Array, across: Array, normal: Array, along: Array, fraction: Array, keep: str, options: Any) -> Sections:
    for name in options:
        if name in ("normal", "transform", *UniformOptions.__annotations__):
            refuse(f"{name} is given by the planes")
    nearest = one_of("keep", keep, KEEP) == 1
    view = _view_of(mesh, None, options.pop("unit", None))
    frames = np.zeros((len(origins), 4, 4))
    frames[:, :3, :3] = np.stack((across, np.cross(normal, across), normal), axis=2)
    frames[:, :3, 3] = origins
    frames[:, 3, 3] = 1
    turned = np.swapaxes(frames[:, :3, :3], 1, 2)
    inverse = np.concatenate((turned, -turned @ origins[:, :, None]), axis=2)
    native = view.run(_native.sections, slice_options(options, SectionKeywords), np.ascontiguousarray(inverse), nearest)
    found = Sections(native, view, frames, along, fraction)
    unknown = len(np.unique(found._layer_of_contours[found.contours["role"] == Role.OPEN]))
    if unknown > 0:
        warn(f"{unknown:,} of {len(found):,} sections have open contours: their area is not known; stitch= joins their ends", MeshWarning)
    return found
