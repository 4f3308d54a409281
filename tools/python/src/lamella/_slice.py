"""slice() and the other calls that give layers: prepared meshes, parts, sections, segments, regions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn, Optional, Sequence

import numpy as np
import numpy.typing as npt

from . import _native
from ._contours import contours_on_grid, grid_step, on_grid
from ._layer import Layer
from ._mesh import MeshLike, View, as_view, as_views, oriented
from ._option_table import UniformOptions
from ._options import (  # fmt: skip
    FrameKeywords, PreparedKeywords, RegionKeywords, documented, number, plane_frame, refuse, rows_of, slice_options, truth, whole_array,
)
from ._result import Result, finish

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import LayerKeywords, SectionKeywords, SliceKeywords


@documented
def slice(  # noqa: A001: the word of the field
    mesh: MeshLike, faces: Optional[npt.ArrayLike] = None, *, orient_shells: bool = False, **options: Unpack[SliceKeywords]
) -> Result:
    """Cut a mesh by parallel planes into closed, oriented, nested contours.

    Parameters
    ----------
    mesh : mesh
        Vertices (n, 3) with `faces`, triangles (m, 3, 3) or (m, 9), the path of a file, a `Mesh`, or a mesh of trimesh,
        meshio or pyvista. Arrays of float32, float64, int32 or int64 are read where they lie.
    faces : array_like of int, shape (m, 3), optional
        Three rows of the vertices for each triangle, counter-clockwise as seen from outside.
    unit : {"mm", "um", "cm", "m", "in", "ft"} or float, optional
        Unit of the mesh's coordinates, or how many mm it has; mm without it, and metres of glTF. A file that states its unit keeps that.
    normal : array_like of float, shape (3,), optional
        Cut perpendicular to this direction instead of z. Heights count along it.
    **options
    orient_shells : bool
        Turn each closed shell outwards first, or inwards where it bounds a cavity: see `Mesh.orient_shells`.
    memory_limit : int
        Results of more bytes are refused. 0: half of the machine's memory.
    threads : int
        Use at most so many threads. 0: all.
    progress : bool or callable, optional
        True shows a bar, by tqdm if it is installed. A callable is told the fraction that is done, on the calling thread and
        at most 20 times a second; the last one is 1. An exception that it raises ends the call.

    Returns
    -------
    Result
        All layers, contours and points, as arrays. It does not depend on threads or on the order of triangles.

    Raises
    ------
    Error
        Of the kind that fits: `CoordinateError` names the vertex, `PlanesError` the layer, `InvalidArgumentError` what is
        allowed.

    Warns
    -----
    MeshWarning
        Contours are open because the mesh has holes, or the mesh is too small for its grid.

    Examples
    --------
    >>> box = lamella.slice(corners, faces, layer_height=10)
    >>> box.layers["z"]
    array([ 5., 15., 25., 35.])
    >>> lamella.slice(corners, faces, heights=[20, 10]).areas.round(3)
    array([253.125, 112.5  ])
    """
    view = as_view(mesh, faces, unit=options.pop("unit", None))
    if truth("orient_shells", orient_shells):
        view = as_view(oriented(view, threads=options.get("threads", 0)), None, unit=None)
    return finish(view.run(_native.slice, slice_options(options)), view)


def adaptive_layers(
    mesh: MeshLike,
    faces: Optional[npt.ArrayLike] = None,
    *,
    cusp: float = 0,
    deviation: float = 0,
    slope_limit: float = 0,
    least: float = 0.05,
    most: float = 0.3,
    step: float = 0.005,
    most_change: float = 0,
    smoothing: float = 0,
    ranges: Optional[npt.ArrayLike] = None,
    **options: Unpack[FrameKeywords],
) -> npt.NDArray[np.float64]:
    """Layers as high as the surface allows: thick where walls stand upright, thin where they lean.

    Parameters
    ----------
    mesh, faces
        As for `slice`.
    cusp : float
        How far the corners of steps stand off the surface at most, mm; 0: any.
    deviation : float
        The surface deviation at most, mm, as slicers count it; 0: any.
    slope_limit : float
        How wide steps are at most, mm; 0: any.
    least, most : float
        Heights of layers, mm.
    step : float
        Heights are whole multiples of it, mm.
    most_change : float
        By how much a layer's height differs from that of the one below at most, mm; 0: any.
    smoothing : float
        The height that the surface allows is at most its mean over so much below and above, mm.
    ranges : array_like of float, shape (n, 3), optional
        From, to and a height that layers have which begin between, whatever the surface. Above the mesh's lowest vertex, mm.
    **options
        As for `prepare`.

    Returns
    -------
    ndarray of float, shape (n, 2)
        Bottom and top of each layer, for the option `slabs` of `slice`.

    Examples
    --------
    >>> slabs = lamella.adaptive_layers(corners, faces, cusp=0.2, most=2)
    >>> slabs[0]
    array([0.   , 0.425])
    >>> lamella.slice(corners, faces, slabs=slabs).layers["z"][:2]
    array([0.2125, 0.6375])
    """
    view = as_view(mesh, faces, unit=options.pop("unit", None))
    given = {"least": least, "most": most, "step": step, "cusp": cusp, "deviation": deviation, "slope_limit": slope_limit,
             "most_change": most_change, "smoothing": smoothing}  # fmt: skip
    lengths = tuple(number(name, value) for name, value in given.items())
    own = rows_of("ranges", 3, np.empty((0, 3)) if ranges is None else ranges)
    slabs: npt.NDArray[np.float64] = view.run(_native.adaptive_layers, slice_options(options, FrameKeywords), lengths, own)
    return slabs


class Prepared:
    """A mesh with the order of its triangles by height. Any number of threads may slice it at once.

    Made by `prepare`. It copies arrays that may be written to.
    """

    __slots__ = ("_native", "_view")

    def __init__(self, native: _native.Prepared, view: View) -> None:
        self._native = native
        self._view = view

    @property
    def nbytes(self) -> int:
        """Memory that it holds beside the mesh: about 12 bytes a triangle."""
        return self._native.nbytes

    @property
    def grid(self) -> float:
        """Step of the grid, mm."""
        return self._native.grid

    def slice(self, heights: Optional[npt.ArrayLike] = None, **options: Unpack[LayerKeywords]) -> Result:
        """Cut it. The result is that of `lamella.slice` of the mesh.

        Parameters
        ----------
        heights : array_like of float, optional
            As for `lamella.slice`.
        **options
            As for `lamella.slice`, without those that `prepare` takes.
        """
        native = slice_options({"heights": heights, **options}, PreparedKeywords)
        return finish(self._view.run(_native.slice_prepared, native, self._native), self._view)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a prepared mesh is not pickled: pickle the mesh, and prepare it where it is sliced")

    def __repr__(self) -> str:
        return f"<lamella.Prepared: {sum(map(len, self._view._meshes)):,} triangles, {self.nbytes:,} bytes>"


def prepare(mesh: MeshLike, faces: Optional[npt.ArrayLike] = None, **options: Unpack[FrameKeywords]) -> Prepared:
    """Prepare a mesh for many slices: one plane then reads little more than the triangles that it cuts.

    Parameters
    ----------
    mesh, faces
        As for `slice`.
    **options
        ``unit``, ``grid``, ``coarser_if_needed``, ``normal``, ``transform``, ``threads`` and ``progress``, as for `slice`.

    Examples
    --------
    >>> tetrahedron = lamella.prepare(corners, faces)
    >>> [tetrahedron.slice([z]).areas[0].round(3) for z in (10, 30)]
    [253.125, 28.125]
    """
    view = as_view(mesh, faces, unit=options.pop("unit", None)).kept()
    return Prepared(view.run(_native.prepare, slice_options(options, FrameKeywords)), view)


def slice_parts(
    meshes: Sequence[Any],
    *,
    transforms: Optional[Sequence[Optional[npt.ArrayLike]]] = None,
    roles: Optional[Sequence[str]] = None,
    objects: Optional[Sequence[Any]] = None,
    at: Optional[Sequence[Optional[npt.ArrayLike]]] = None,
    **options: Unpack[SliceKeywords],
) -> Result:
    """Cut several meshes by the same planes, as the parts of one print.

    Parameters
    ----------
    meshes : sequence of mesh
        Each as `slice` takes it; one of vertices and faces as a pair. Prepared ones too, on the grid of all.
    transforms : sequence of array_like, shape (4, 4), optional
        One for each part, or None for those that stay where they are.
    roles : sequence of str, optional
        What each part is for: "solid", "negative" (taken out of the solid parts), "modifier" (what it covers of them gets its
        number), "support blocker", "support enforcer" or "support" (cut beside them).
    objects : sequence, optional
        Numbers or names: roles act among parts of the same one; not given, among all.
    at : sequence of array_like, shape (copies, 3), optional
        Moves in mm, rounded to the grid, one for each copy of a part, or None for one that stays. Copies at one height are
        cut once, and are parts of their own; with ``share_copies=True`` they share contours: see `Result.copies`.
    **options
        As for `slice`. Without roles, contours of parts may overlap, unless ``unite_parts=True``.

    Returns
    -------
    Result
        ``contours["part"]`` is the index of the part that a contour comes from.

    Examples
    --------
    >>> lift = np.eye(4)
    >>> lift[2, 3] = 40
    >>> pair = lamella.slice_parts([(corners, faces), (corners, faces)], transforms=[None, lift], layer_height=20)
    >>> pair.contours["part"]
    array([0, 0, 1, 1], dtype=uint32)
    >>> half = np.diag([0.5, 0.5, 0.5, 1])
    >>> holed = lamella.slice_parts(
    ...     [(corners, faces), (corners, faces)], transforms=[None, half], roles=["solid", "negative"], heights=[10]
    ... )
    >>> holed.areas.round(3)
    array([225.])
    >>> plate = lamella.slice_parts([(corners, faces)], at=[[(0, 0, 0), (40, 0, 0), (0, 40, 0)]], heights=[10])
    >>> plate.contours["part"]
    array([0, 1, 2], dtype=uint32)
    """
    view = as_views(meshes, transforms, roles, objects, at, unit=options.pop("unit", None))
    return finish(view.run(_native.slice, slice_options(options)), view)


def section(mesh: MeshLike, origin: npt.ArrayLike, normal: npt.ArrayLike, **options: Unpack[SectionKeywords]) -> Layer:
    """Cut a mesh by one plane.

    Parameters
    ----------
    mesh : mesh
        As for `slice`; vertices and faces as a pair.
    origin : array_like of float, shape (3,)
        A point of the plane, mm.
    normal : array_like of float, shape (3,)
        What the plane is perpendicular to; any length but zero.
    **options
        As for `slice`, without heights, `normal` and `transform`.

    Returns
    -------
    Layer
        Its points are within the plane, from `origin`; `Layer.to_3d` leads back to the mesh's space.

    Examples
    --------
    >>> cut = lamella.section((corners, faces), origin=[0, 0, 20], normal=[0, 0, 1])
    >>> round(cut.area, 3)
    112.5
    """
    return section_multiplane(mesh, origin, normal, [0.0], **options)[0]


def section_multiplane(
    mesh: MeshLike, origin: npt.ArrayLike, normal: npt.ArrayLike, heights: npt.ArrayLike, **options: Unpack[SectionKeywords]
) -> Result:
    """Cut a mesh by parallel planes of any direction.

    Parameters
    ----------
    mesh, origin, normal
        As for `section`.
    heights : array_like of float
        Distances of the planes from `origin` along the normal, mm, in any order.
    **options
        As for `slice`, without heights, `normal` and `transform`.

    Returns
    -------
    Result
        A layer for each distinct height, ascending; `Result.layer_of` names the layer of each height.

    Examples
    --------
    >>> cuts = lamella.section_multiplane((corners, faces), [0, 0, 10], [0, 0, 1], [0, 10])
    >>> cuts.areas.round(3)
    array([253.125, 112.5  ])
    """
    for name in options:
        if name in ("normal", "transform", *UniformOptions.__annotations__):
            refuse(f"{name} is given by origin, normal and heights")
    return slice(mesh, transform=plane_frame(origin, normal), heights=heights, **options)


def assemble(segments: npt.ArrayLike, keys: Optional[npt.ArrayLike] = None, *, grid: float = 2.0**-20) -> Layer:
    """Link directed segments of one plane into closed, oriented, nested contours.

    Every segment is used exactly once. What does not close becomes an open polyline.

    Parameters
    ----------
    segments : array_like of float, shape (n, 2, 2) or (n, 4)
        From (x, y) to (x, y), mm, with the solid on the left. They are rounded to the grid.
    keys : array_like of int, shape (n, 2), optional
        A number for each end: ends with equal numbers meet. Without it those meet that are one point of the grid.
    grid : float
        Step of the grid, mm.

    Examples
    --------
    >>> square = [[0, 0, 4, 0], [4, 4, 0, 4], [4, 0, 4, 4], [0, 4, 0, 0]]
    >>> lamella.assemble(square).area
    16.0
    """
    rows = whole_array(segments, "segments")
    if rows.ndim == 3 and rows.shape[1:] == (2, 2):
        rows = rows.reshape(-1, 4)
    if rows.ndim != 2 or rows.shape[1] != 4:
        refuse(f"segments must have shape (n, 2, 2) or (n, 4), and have {rows.shape}")
    if keys is not None:
        keys = np.asarray(keys)
        if keys.dtype.kind not in "iu" or keys.shape != (len(rows), 2):
            refuse(f"keys must be integers of shape ({len(rows)}, 2), and are {keys.dtype} of shape {keys.shape}")
        keys = np.ascontiguousarray(keys, dtype=np.int64)
    step = grid_step(grid)
    return Result(_native.assemble(on_grid(rows, "segments", step), keys, step), None)[0]


def region_of(contours: Sequence[npt.ArrayLike], *, grid: float = 2.0**-20, **rules: Unpack[RegionKeywords]) -> Layer:
    """Make the region that closed contours of any program bound, with outers and holes, by the rules of `slice`.

    Parameters
    ----------
    contours : sequence of array_like of float, shape (n, 2)
        Points in mm; the last leads to the first. They are rounded to the grid.
    grid : float
        Step of the grid, mm.
    **rules
        ``fill_rule``, ``closing``, ``offset`` and the other rules of regions, as for `slice`.

    Examples
    --------
    >>> low = np.array([[0, 0], [4, 0], [4, 4], [0, 4]])
    >>> lamella.region_of([low, low + 2]).area
    28.0
    """
    step = grid_step(grid)
    paths = contours_on_grid(contours, "contours", step)
    return Result(_native.region_of(paths, slice_options(rules, RegionKeywords), step), None)[0]
