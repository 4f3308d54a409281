"""slice() and the other calls that give layers: parts, sections, streams, segments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, Iterator, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import InvalidArgumentError
from ._layer import Layer
from ._mesh import MeshLike, View, as_view, as_views, oriented
from ._options import ProgressLike, number, plane_frame, slice_options, truth, whole_array, whole_number
from ._result import Result, finish, result_of, warn_of_open

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import SectionKeywords, SliceKeywords


def slice(  # noqa: A001: the word of the field
    mesh: MeshLike,
    faces: Optional[npt.ArrayLike] = None,
    *,
    layer_height: Optional[float] = None,
    first_height: Optional[float] = None,
    datum: str = "mesh-min",
    heights: Optional[npt.ArrayLike] = None,
    side: str = "below",
    unit: Union[None, str, float] = None,
    grid: Union[None, str, float] = None,
    normal: Optional[npt.ArrayLike] = None,
    transform: Optional[npt.ArrayLike] = None,
    fill_rule: str = "non-zero",
    fill_from: Sequence[Tuple[int, str]] = (),
    close: float = 0,
    offset: float = 0,
    miter_limit: float = 3,
    largest_only: bool = False,
    drop_collinear: bool = False,
    simplify: float = 0,
    mark_near: float = 0,
    close_gaps: Union[str, float] = "auto",
    gap_sense: str = "kept",
    orient_shells: bool = False,
    origins: bool = False,
    allow_empty: bool = False,
    memory_limit: int = 0,
    threads: int = 0,
    progress: ProgressLike = None,
) -> Result:
    """Cut a mesh by parallel planes into closed, oriented, nested contours.

    Parameters
    ----------
    mesh : mesh
        Vertices (n, 3) with `faces`, triangles (m, 3, 3) or (m, 9), the path of a file, a `Mesh`, or a mesh of trimesh,
        meshio or pyvista. Arrays of float32, float64, int32 or int64 are read where they lie.
    faces : array_like of int, shape (m, 3), optional
        Three rows of the vertices for each triangle, counter-clockwise as seen from outside.
    layer_height : float, optional
        Height of uniform layers, mm. Without it and without `heights`: 0.2. The plane lies in the middle of its layer.
    first_height : float, optional
        Height of the first plane above the datum, mm, instead of half a layer.
    datum : {"mesh-min", "zero"}
        Where the heights of uniform layers count from: the mesh's lowest vertex, or z = 0.
    heights : array_like of float, optional
        Cut at these absolute heights in mm, in any order, instead of uniform layers. `Result.layer_of` names the layer of
        each.
    side : {"below", "above"}
        Where a plane passes a vertex of exactly its height.
    unit : {"mm", "um", "cm", "m", "in", "ft"} or float, optional
        Unit of the mesh's coordinates, or how many mm it has; mm without it. A file that states its unit keeps that.
    grid : float or "auto", optional
        Unit of the integer grid, mm. Without it 2**-20, or more if the mesh needs it. "auto": the finest that the mesh
        fits.
    normal : array_like of float, shape (3,), optional
        Cut perpendicular to this direction instead of z. Heights count along it.
    transform : array_like of float, shape (4, 4) or (3, 4), optional
        Affine map from the mesh (in mm) to the space of the planes, which are horizontal there.
    fill_rule : {"contours", "even-odd", "non-zero", "positive", "outermost"}
        What is solid where contours overlap. "non-zero": they are united. "contours": they stay as the mesh gives them.
    fill_from : sequence of (int, str)
        From this layer on, another fill rule.
    close : float
        Close gaps narrower than twice so many mm. Not by the fill rule "contours".
    offset : float
        Grow what is solid by so many mm, or shrink it by a negative number. Not by "contours".
    miter_limit : float
        Cut off corners that `close` or `offset` would move farther than so many times their length.
    largest_only : bool
        Keep the largest contour of a layer only, with its holes. Not by "contours".
    drop_collinear : bool
        Drop points exactly within straight lines. Not by "contours".
    simplify : float
        Drop points within so many mm of the lines that are left.
    mark_near : float
        Set the flag `ContourFlag.NEAR` on contours that ``close=mark_near`` would change.
    close_gaps : float or "auto"
        Join ends of open polylines at most so many mm apart, the nearest first, where nothing lies between them: see
        `Result.closed_gaps`. "auto" is a hundredth of the diagonal of the mesh's box; 0 joins none.
    gap_sense : {"kept", "any"}
        Which ends are joined: those that keep the orientation of both polylines, or any.
    orient_shells : bool
        Turn each closed shell outwards first, or inwards where it bounds a cavity: see `Mesh.orient_shells`.
    origins : bool
        Say which triangle each contour edge comes from: `Result.origins`.
    allow_empty : bool
        A mesh without triangles gives empty layers instead of an `EmptyMeshError`.
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
    keywords = dict(locals())
    del keywords["mesh"], keywords["faces"]
    view = as_view(mesh, faces, unit=keywords.pop("unit"))
    if truth("orient_shells", keywords.pop("orient_shells")):
        view = as_view(oriented(view, threads=threads), None, unit=None)
    return finish(view.run(_native.slice, slice_options(keywords)), view, keywords)


def slice_parts(
    meshes: Sequence[Any],
    *,
    united: bool = False,
    transforms: Optional[Sequence[Optional[npt.ArrayLike]]] = None,
    **options: Unpack[SliceKeywords],
) -> Result:
    """Cut several meshes by the same planes, as the parts of one print.

    Parameters
    ----------
    meshes : sequence of mesh
        Each as `slice` takes it; one of vertices and faces as a pair.
    united : bool
        False: rules of regions are done to each part by itself, and contours of parts may overlap. True: to all parts of a
        layer together, by a fill rule other than "contours".
    transforms : sequence of array_like, shape (4, 4), optional
        One for each part, or None for those that stay where they are.
    **options
        As for `slice`.

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
    """
    keywords: Dict[str, Any] = dict(options)
    view = as_views(meshes, transforms, unit=keywords.pop("unit", None))
    return finish(view.run(_native.slice_parts, slice_options(keywords), united), view, keywords)


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
    mesh: MeshLike,
    origin: npt.ArrayLike,
    normal: npt.ArrayLike,
    heights: npt.ArrayLike,
    **options: Unpack[SectionKeywords],
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
        if name in ("normal", "transform", "layer_height", "first_height", "datum"):
            raise InvalidArgumentError(f"{name} is given by origin, normal and heights")
    return slice(mesh, transform=plane_frame(origin, normal), heights=heights, **options)


def stream(
    mesh: MeshLike,
    faces: Optional[npt.ArrayLike] = None,
    *,
    chunk: int = 256,
    **options: Unpack[SliceKeywords],
) -> Iterator[Result]:
    """Cut a mesh and hand its layers over in chunks, from below, while the rest is still being cut.

    Memory does not grow with the number of layers. Leaving the loop early ends the slicing.

    Parameters
    ----------
    mesh, faces
        As for `slice`.
    chunk : int
        Layers in a chunk. The last one may have fewer.
    **options
        As for `slice`.

    Yields
    ------
    Result
        The next layers. `Result.first_layer` counts those before it.

    Examples
    --------
    >>> for layers in lamella.stream(corners, faces, layer_height=1, chunk=16):
    ...     print(layers.first_layer, len(layers), layers.areas.sum().round(1))
    0 16 4703.6
    16 16 1247.6
    32 8 47.8
    """
    keywords: Dict[str, Any] = dict(options)
    view = as_view(mesh, faces, unit=keywords.pop("unit", None))
    if whole_number("chunk", chunk) == 0:
        raise InvalidArgumentError("a chunk must have at least one layer")
    chunks = view.run(_native.Stream, slice_options(keywords), chunk)
    return _chunks(chunks, view, keywords)


def _chunks(chunks: _native.Stream, view: View, keywords: Dict[str, Any]) -> Iterator[Result]:
    found = _native.OpenLayers()
    try:
        while (layers := view.run(lambda _: chunks.next())) is not None:
            found.add(layers.open_layers())
            yield result_of(layers, None, keywords)
        warn_of_open(found)
    finally:
        chunks.close()


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
        Unit of the grid, mm.

    Returns
    -------
    Layer

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
        raise InvalidArgumentError(f"segments must have shape (n, 2, 2) or (n, 4), and have {rows.shape}")
    ends = None if keys is None else _checked_keys(keys, len(rows))
    unit = number("grid", grid)
    if not 0 < unit < float("inf"):
        raise InvalidArgumentError(f"grid must be finite and more than 0 mm, and is {unit:g}")
    return Result(_native.assemble(np.ascontiguousarray(rows), ends, unit), None, {})[0]


def _checked_keys(keys: npt.ArrayLike, count: int) -> npt.NDArray[Any]:
    ends = np.asarray(keys)
    if ends.dtype.kind not in "iu" or ends.shape != (count, 2):
        raise InvalidArgumentError(
            f"keys must be integers of shape ({count}, 2), and are {ends.dtype} of shape {ends.shape}"
        )
    return ends.astype(np.int64, copy=False)
