"""Meshes: from files, and as views of whatever holds vertices and faces. check(): what is wrong with one, and where."""

from __future__ import annotations

import copy
import functools
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import CoordinateError, Error, InvalidArgumentError, MeshTypeError, MeshWarning, warn
from ._options import FrameKeywords, ProgressLike, affine, array_of, mm_per_unit, number, refuse, slice_options, truth, whole_number

if TYPE_CHECKING:
    from typing_extensions import Unpack

MeshLike = Any
"""Vertices, triangles, a path, a `Mesh`, or an object with ``.vertices`` and ``.faces`` or with ``.points``: see `slice`."""


class View:
    """One or more meshes under the engine's eyes. It keeps their arrays alive."""

    __slots__ = ("_meshes", "native", "of_parts")

    def __init__(self, meshes: List[Mesh], parts: Optional[Sequence[Tuple[Any, int, int, Any, Any]]] = None) -> None:
        """With placement, role, object, prepared mesh and places of each they are parts."""
        self._meshes = meshes
        self.of_parts = parts is not None
        alone = [(None, 0, 0, None, None)]
        rows = [(mesh._vertices, mesh._faces, mesh.unit, *part) for mesh, part in zip(meshes, parts or alone)]
        self.native: _native.View = _native.View(rows, parts is not None)

    def kept(self) -> View:
        """The same mesh, whatever is written to the arrays that were given."""
        given = self._meshes[0]
        mesh = copy.copy(given)
        mesh._given_faces = given._given_faces
        mesh._vertices, mesh._faces = _kept(given._vertices), None if given._faces is None else _kept(given._faces)
        return View([mesh])

    def run(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """``call(native view, *arguments)``. An error that blames a triangle names the row of what was given."""
        try:
            return call(self.native, *arguments)
        except Error as error:
            blame = self._blame(error)
            if blame is None:
                raise
        raise blame from None

    def _blame(self, error: Error) -> Optional[Error]:
        if len(self._meshes) != 1:
            return None
        mesh = self._meshes[0]
        error.path = mesh.path
        triangle = error.triangle
        if mesh._given_faces is None or triangle is None:
            return None
        face = mesh._given_faces[triangle]
        row = f"faces[{triangle}] = {face.tolist()}"
        if isinstance(error, InvalidArgumentError):
            return type(error)(f"{row}: there are {len(mesh._vertices)} vertices", triangle=triangle, path=mesh.path)
        if isinstance(error, CoordinateError):
            known = face[(face >= 0) & (face < len(mesh._vertices))]
            corners = mesh._vertices[known].astype(np.float64)
            worst = int(np.argmax(np.where(np.isfinite(corners), np.abs(corners), np.inf).max(axis=1)))
            vertex = int(known[worst])
            text = f"vertices[{vertex}] = {corners[worst].tolist()}: not finite, or beyond 1e9 mm"
            return type(error)(text, triangle=triangle, vertex=vertex, path=mesh.path)
        return None


def _kept(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return array.copy() if array.flags.writeable else array


class Mesh:
    """A mesh that was read or welded, with its memory. `slice` and the others take it as it is.

    Attributes
    ----------
    unit : float
        mm that a coordinate has.
    path : str or None
        The file that it was read from.
    info : Dict[str, Any]
        Of a file: ``format``, ``text``, ``compressed``, ``states_unit``, ``patient_frame`` ("LPS", "RAS" or ""),
        ``bytes``, and ``parts``: for each 3MF object, OBJ object or group, or solid of text STL a dictionary with ``name``,
        ``role`` ("solid", "negative volume", "modifier", "support blocker", "support enforcer", "support"),
        ``first_triangle`` and ``triangles``. Only solid parts are in the mesh. Of a welded mesh: ``joined`` vertices, ``largest_move`` and ``tolerance`` in mm.
    scalars : Dict[str, ndarray]
        By ``read(path, scalars=True)``: what the file has at vertices, a row for each of `vertices`, as float64 or int64.
    """

    def __init__(self, vertices: npt.NDArray[Any], faces: Optional[npt.NDArray[Any]], unit: float, path: Optional[str], info: Dict[str, Any]) -> None:
        self._vertices = vertices
        self._faces = faces
        self._given_faces: Optional[npt.NDArray[Any]] = None  # for messages, as they were given
        self.unit = unit
        self.path = path
        self.info = info
        self.scalars: Dict[str, npt.NDArray[Any]] = {}

    @property
    def triangles(self) -> npt.NDArray[Any]:
        """Corners (m, 3, 3). A view of what an STL file holds, a copy for meshes of vertices and faces."""
        corners: npt.NDArray[Any] = self._vertices if self._faces is None else self._vertices[self._faces]
        return corners.reshape(-1, 3, 3)

    @property
    def vertices(self) -> npt.NDArray[Any]:
        """Vertices (n, 3): a view, but for STL files, of which it copies three for each triangle."""
        return self._vertices.reshape(-1, 3) if self._faces is None else self._vertices

    @property
    def faces(self) -> npt.NDArray[Any]:
        """Rows of `vertices` (m, 3)."""
        return np.arange(3 * len(self), dtype=np.int64).reshape(-1, 3) if self._faces is None else self._faces

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """Least and largest corner of the box (2, 3), mm."""
        corners = self._vertices.reshape(-1, 3) if self._faces is None else self._vertices[np.unique(self._faces)]
        return np.array([corners.min(axis=0), corners.max(axis=0)], dtype=np.float64) * self.unit

    @property
    def volume(self) -> float:
        """Volume by the facets, mm³: negative where they look inwards. NaN, not known, of an open mesh."""
        info = self._counts
        return float(info["volume"]) if info["closed"] else float("nan")

    @property
    def area(self) -> float:
        """Area of the triangles, mm²."""
        return float(self._counts["area"])

    @functools.cached_property
    def _counts(self) -> Dict[str, Any]:
        found: Dict[str, Any] = as_view(self, None, unit=None).run(_native.check, slice_options({}), 0.0, 100.0, 0, True)
        return dict(found["info"])

    def orient_shells(self, *, threads: int = 0, progress: ProgressLike = None) -> Mesh:
        """The same mesh, each closed shell turned outwards, or inwards where it bounds a cavity: within an odd number of others.

        ``slice(mesh, orient_shells=True)`` does it for one call. Takes as long as `weld` and `check` together. Its ``info`` counts
        ``shells`` and those ``turned``; ``complete`` is False if a search was cut short, so that cavities may be turned outwards.
        """
        return oriented(as_view(self, None, unit=None), threads=threads, progress=progress)

    def __len__(self) -> int:
        return len(self._vertices if self._faces is None else self._faces)

    def __repr__(self) -> str:
        where = f" from {self.path!r}" if self.path is not None else ""
        unit = f", unit {self.unit:g} mm" if self.unit != 1 else ""
        return f"<lamella.Mesh: {len(self):,} triangles{where}{unit}>"

    def __reduce__(self) -> Tuple[Any, ...]:
        return (Mesh, (self._vertices, self._faces, self.unit, self.path, self.info), {"scalars": self.scalars})


def read(
    path: Union[str, bytes, os.PathLike[Any]], *, unit: Union[None, str, float] = None, indexed: bool = False, scalars: bool = False,
    threads: int = 0, progress: ProgressLike = None,
) -> Mesh:  # fmt: skip
    """Read a mesh file: STL, OBJ, OFF, PLY, VTK, VTP, 3MF, glTF, GIfTI or FreeSurfer, or gzip of any. The content decides, not the name.

    Parameters
    ----------
    path : path
    unit : {"mm", "um", "cm", "m", "in", "ft"} or float, optional
        Unit of a file that states none, and of glTF, which is in metres without it; else mm.
    indexed : bool
        Equal vertices of an STL file become one, so that `Mesh.faces` tells which triangles meet.
    scalars : bool
        Numbers at vertices of VTP, PLY and GIfTI are read too, for `Result.scalars`. What does not fit is left out with a warning.
    threads, progress
        As for `slice`.

    Raises
    ------
    UnreadableFileError, MalformedMeshError, EmptyMeshError

    Warns
    -----
    MeshWarning
        What the reader noticed.
    """
    name = os.fsdecode(path)
    try:
        call = slice_options({"threads": threads, "progress": progress})
        file = _native.read(os.fsencode(name), 0.0 if unit is None else mm_per_unit(unit), truth("scalars", scalars), call)
    except Error as error:
        error.path = name
        raise
    for text in file["warnings"]:
        warn(text, MeshWarning)
    mesh = _mesh_of(file, name)
    mesh.scalars = {key: values.astype(np.int64) if whole else values for key, values, whole in file["scalars"]}
    if not truth("indexed", indexed) or mesh._faces is not None:
        return mesh
    welded = weld(mesh, tolerance=0, threads=threads)
    return Mesh(welded._vertices, welded._faces, welded.unit, name, mesh.info)


def _mesh_of(made: Dict[str, Any], path: Optional[str] = None) -> Mesh:
    return Mesh(made["vertices"], made["faces"], made["unit"], path, made["info"])


def weld(
    mesh: MeshLike, faces: Optional[npt.ArrayLike] = None, *, tolerance: float = 0.01,
    unit: Union[None, str, float] = None, threads: int = 0, progress: ProgressLike = None,
) -> Mesh:  # fmt: skip
    """Join vertices that should be one, so that a cracked mesh closes. Slicing never does this by itself.

    Parameters
    ----------
    mesh, faces, unit, threads, progress
        As for `slice`.
    tolerance : float
        Vertices at most so many mm apart are joined.

    Returns
    -------
    Mesh
        The same triangles in the same order over fewer vertices.

    Examples
    --------
    >>> cracked = corners[faces]
    >>> cracked[0, 0] += 0.004
    >>> lamella.weld(cracked).info["joined"]
    1
    """
    options = slice_options({"threads": threads, "progress": progress})
    return _mesh_of(as_view(mesh, faces, unit=unit).run(_native.weld, number("tolerance", tolerance), options))


def oriented(view: View, *, threads: int = 0, progress: ProgressLike = None) -> Mesh:
    turned = view.run(_native.orient_shells, slice_options({"threads": threads, "progress": progress}))
    if not turned["info"]["complete"]:
        warn("not all shells could be looked at: some cavities may be turned outwards", MeshWarning)
    return _mesh_of(turned)


def as_view(mesh: MeshLike, faces: Optional[npt.ArrayLike], *, unit: Union[None, str, float]) -> View:
    """A mesh in any form that users may have."""
    return View([_mesh_from(mesh, faces, unit)])


_ROLES = ("solid", "negative", "modifier", "support blocker", "support enforcer", "support")


def as_views(
    meshes: Sequence[Any],
    transforms: Optional[Sequence[Any]],
    roles: Optional[Sequence[str]],
    objects: Optional[Sequence[Any]],
    at: Optional[Sequence[Any]],
    *,
    unit: Union[None, str, float],
) -> View:
    """Several of them, each with a transform, a role, an object and places of its own; prepared ones too."""
    if not isinstance(meshes, Iterable):
        refuse(f"meshes must be a sequence of them, not {meshes!r}")
    prepared = [getattr(mesh, "_native", None) if hasattr(mesh, "_view") else None for mesh in meshes]
    given = [mesh._view._meshes[0] if led else _mesh_from(mesh, None, unit) for mesh, led in zip(meshes, prepared)]

    def of_each(name: str, values: Optional[Sequence[Any]], default: Any) -> List[Any]:
        listed = [default] * len(given) if values is None else list(values)
        if len(listed) != len(given):
            refuse(f"there are {len(given)} meshes and {len(listed)} {name}")
        return listed

    moves = of_each("transforms", transforms, None)
    matrices = [None if move is None else affine(f"transforms[{i}]", move) for i, move in enumerate(moves)]
    words = [str(role).replace("-", " ").replace(" volume", "") for role in of_each("roles", roles, "solid")]
    for i, word in enumerate(words):
        if word not in _ROLES:
            refuse(f"roles[{i}] must be one of {', '.join(_ROLES)}, not {word!r}")
    known: Dict[Any, int] = {}
    numbers = [known.setdefault(name, len(known)) for name in of_each("objects", objects, 0)]
    places = [None if rows is None else np.ascontiguousarray(rows, dtype=np.float64) for rows in of_each("at", at, None)]
    for i, rows in enumerate(places):
        if rows is not None and (rows.ndim != 2 or rows.shape[1] != 3 or len(rows) == 0):
            refuse(f"at[{i}] must be an array of shape (copies, 3), not {rows.shape}")
    return View(given, list(zip(matrices, map(_ROLES.index, words), numbers, prepared, places)))


def _mesh_from(mesh: MeshLike, faces: Optional[npt.ArrayLike], unit: Union[None, str, float]) -> Mesh:
    """With arrays that the engine can read where they lie."""
    mm = mm_per_unit("mm" if unit is None else unit)
    if isinstance(mesh, (str, bytes, os.PathLike)):
        if faces is not None:
            refuse("faces are for arrays of vertices, not for files")
        mesh = read(mesh, unit=unit)
    if isinstance(mesh, Mesh) and faces is None:
        keeps_unit = unit is None or mesh.info.get("states_unit", False)
        made = _checked(mesh._vertices, mesh._faces, mesh.unit if keeps_unit else mm, mesh.path)
        made.info, made.scalars = mesh.info, mesh.scalars
        return made
    vertices, its_faces = (mesh, faces) if faces is not None else _parts_of(mesh)
    return _checked(vertices, its_faces, mm)


def _parts_of(mesh: MeshLike) -> Tuple[Any, ...]:
    """Vertices and faces, or triangles and None."""
    if isinstance(mesh, tuple) and len(mesh) == 2:
        return mesh
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return mesh.vertices, mesh.faces
    if hasattr(mesh, "GetPolys") and not hasattr(mesh, "faces"):
        return _parts_of_vtk(mesh)
    if hasattr(mesh, "points") and hasattr(mesh, "cells"):
        led = isinstance(mesh.cells, np.ndarray)
        return mesh.points, _faces_of_vtk(mesh.cells) if led else _faces_of_cells(mesh.cells)
    if hasattr(mesh, "points") and hasattr(mesh, "faces"):
        return mesh.points, _faces_of_vtk(mesh.faces)
    if isinstance(mesh, (np.ndarray, list, tuple)) or hasattr(mesh, "__array__"):
        return mesh, None
    raise MeshTypeError(
        f"{type(mesh).__name__} is no mesh: pass vertices and faces, triangles, a path, or an object that has .vertices "
        "and .faces, or .points and .cells"
    )


def _parts_of_vtk(mesh: Any) -> Tuple[Any, ...]:
    """Of a vtkPolyData: its own arrays."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    polys = mesh.GetPolys()
    if mesh.GetNumberOfStrips() > 0 or polys.GetNumberOfConnectivityIds() != 3 * polys.GetNumberOfCells() or polys.GetMaxCellSize() > 3:
        refuse("a vtkPolyData must consist of triangles: vtkTriangleFilter makes them of polygons and strips")
    return vtk_to_numpy(mesh.GetPoints().GetData()), vtk_to_numpy(polys.GetConnectivityArray()).reshape(-1, 3)


def _faces_of_cells(cells: Any) -> npt.NDArray[Any]:
    """As meshio has them: blocks of cells of one type, or a dict of them."""
    blocks = cells.items() if isinstance(cells, dict) else [(block.type, block.data) for block in cells]
    triangles = [np.asarray(data) for kind, data in blocks if kind == "triangle"]
    others = sorted({kind for kind, _ in blocks if kind not in ("triangle", "line", "vertex")})
    if others or not triangles:
        refuse(f"the cells must be triangles, and are {', '.join(others) or 'none'}")
    return triangles[0] if len(triangles) == 1 else np.concatenate(triangles)


def _faces_of_vtk(faces: Any) -> npt.NDArray[Any]:
    """As VTK has them: each face led by its number of corners, [3, a, b, c, 3, ...]."""
    flat = array_of(faces, "faces", "iu")
    if flat.ndim == 2 and flat.shape[1] == 3:
        return flat
    if flat.ndim != 1 and flat.shape[1:] != (4,):
        refuse(f"faces must be a flat array of integers, each face led by its number of corners; they have shape {flat.shape}")
    flat = flat.reshape(-1)
    whole = len(flat) // 4
    wrong = [*np.flatnonzero(flat[: 4 * whole : 4] != 3), *([whole] if 4 * whole < len(flat) else [])]
    if wrong:
        refuse(f"face {wrong[0]} does not have 3 corners: triangulate the mesh first")
    return flat.reshape(-1, 4)[:, 1:]


def _checked(vertices: Any, faces: Any, unit: float, path: Optional[str] = None) -> Mesh:
    if faces is None:
        return Mesh(_triangles(vertices), None, unit, path, {})
    given = array_of(faces, "faces", "iu")
    mesh = Mesh(_rows(_coordinates(vertices, "vertices"), "vertices", 3), _indices(given), unit, path, {})
    mesh._given_faces = given
    return mesh


def _triangles(values: Any) -> npt.NDArray[Any]:
    array = _coordinates(values, "triangles")
    if array.ndim == 3 and array.shape[1:] == (3, 3):
        array = array.reshape(len(array), 9)
    if array.ndim == 2 and array.shape[1] == 3:
        refuse(f"vertices of shape {array.shape} need faces")
    return _rows(array, "triangles", 9, "(m, 3, 3) or (m, 9)")


def _coordinates(values: Any, name: str) -> npt.NDArray[Any]:
    """As the engine reads numbers: float32, float64, int32 or int64."""
    array = array_of(values, name)
    kind, size = array.dtype.kind, array.itemsize
    if not array.dtype.isnative or (kind, size) not in (("f", 4), ("f", 8), ("i", 4), ("i", 8)):
        return array.astype(np.float32 if (kind, size) == ("f", 2) else np.int64 if size < 8 and kind in "iu" else np.float64)
    return array


def _indices(faces: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if faces.dtype.itemsize < 4 or not faces.dtype.isnative:
        faces = faces.astype(np.int32 if faces.dtype.itemsize < 4 else np.int64)
    return _rows(faces, "faces", 3)


def _rows(array: npt.NDArray[Any], name: str, width: int, shape: str = "(n, 3)") -> npt.NDArray[Any]:
    """Rows of packed numbers, any distance apart; a copy where they are not."""
    if array.ndim != 2 or array.shape[1] != width:
        refuse(f"{name} must have shape {shape}, and have {array.shape}")
    if array.strides[1] == array.itemsize and array.strides[0] >= width * array.itemsize:
        return array
    return np.ascontiguousarray(array)


@dataclass(frozen=True)
class Finding:
    """All faults of one kind. The arrays have a row for each place that is kept."""

    count: int
    at_least: bool
    """The search was cut short: there may be more."""
    points: npt.NDArray[np.float64]
    """(k, 3, 3), mm: a point, the ends of an edge or gap, or a face's corners; NaN in the rows beyond ``point_count``."""
    point_count: npt.NDArray[np.int32]
    triangles: npt.NDArray[np.int64]
    """(k, 2): triangles that are part of it, or -1."""
    parts: npt.NDArray[np.int64]
    """Faces at an edge, edges of a loop, fans at a vertex; else 0."""
    measure: npt.NDArray[np.float64]
    """A loop's length or a gap's width in mm, a sliver's ratio, a shell's volume in mm³; else 0."""
    closed: npt.NDArray[np.bool_]
    """True of loops that close."""


def _finding(count: int, at_least: bool, places: npt.NDArray[np.void]) -> Finding:
    points = places["points"].copy()
    points[np.arange(3) >= places["point_count"][:, None]] = np.nan
    others = {name: places[name] for name in ("point_count", "triangles", "parts", "measure", "closed")}
    return Finding(count, at_least, points, **others)


@dataclass(frozen=True, repr=False)
class Check:
    """What `check` found."""

    verdict: str
    """One line."""
    clean: bool
    """No fault was found but slivers, which slicing does not mind."""
    complete: bool
    """No search was cut short."""
    info: Dict[str, Any]
    """Counts of triangles and edges, box, volume and area."""
    shells: npt.NDArray[np.void]
    """A row for each set of connected triangles: ``triangles``, ``closed``, ``volume`` (mm³), ``orientation``, ``depth``,
    ``parent``, ``triangle`` and ``first``, a triangle and vertex of it."""
    findings: Dict[str, Finding]
    """By kind: "boundary_edges", "crossing_faces", ...; all kinds are there."""

    def __getitem__(self, fault: str) -> Finding:
        """The finding of that kind."""
        return self.findings[fault]

    def __repr__(self) -> str:
        return f"<lamella.Check: {self.verdict}>"


def check(
    mesh: MeshLike,
    faces: Optional[npt.ArrayLike] = None,
    *,
    tolerance: float = 0.01,
    sliver_ratio: float = 100,
    most_places: int = 1000,
    **options: Unpack[FrameKeywords],
) -> Check:
    """Find every departure of a mesh from a closed, oriented surface without self-intersections.

    Parameters
    ----------
    mesh, faces
        As for `slice`.
    tolerance : float
        For T-junctions and cracks, mm.
    sliver_ratio : float
        Longest side over the height on it, from which on a triangle is a sliver.
    most_places : int
        Kept of each kind; all are counted.
    **options
        As for `prepare`.

    Examples
    --------
    >>> found = lamella.check(corners, faces[:3])
    >>> found
    <lamella.Check: not clean: 3 boundary edges, 1 boundary loop>
    >>> found["boundary_edges"].points[0, :2]
    array([[ 0.,  0.,  0.],
           [ 0., 30.,  0.]])
    """
    view = as_view(mesh, faces, unit=options.pop("unit", None))
    limits = number("tolerance", tolerance), number("sliver_ratio", sliver_ratio), whole_number("most_places", most_places)
    found: Dict[str, Any] = view.run(_native.check, slice_options(options, FrameKeywords), *limits, False)
    found["findings"] = {kind: _finding(*fault) for kind, fault in found["findings"].items()}
    return Check(**found)
