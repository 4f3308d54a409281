"""check(): what is wrong with a mesh, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Optional

import numpy as np
import numpy.typing as npt

from . import _native
from ._mesh import MeshLike, as_view
from ._options import FrameKeywords, number, slice_options, whole_number

if TYPE_CHECKING:
    from typing_extensions import Unpack


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
    found: Dict[str, Any] = view.run(_native.check, slice_options(options, FrameKeywords), *limits)
    found["findings"] = {kind: _finding(*fault) for kind, fault in found["findings"].items()}
    return Check(**found)
