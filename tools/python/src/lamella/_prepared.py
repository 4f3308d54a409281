"""prepare(): a mesh that is sliced again and again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, NoReturn, Optional, Union

import numpy.typing as npt

from . import _native
from ._mesh import MeshLike, as_view
from ._options import ProgressLike, slice_options
from ._result import Result, finish

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._mesh import View
    from ._options import LayerKeywords


class Prepared:
    """A mesh on the grid, ordered by height. Any number of threads may slice it at once.

    Made by `prepare`.
    """

    __slots__ = ("_native", "_view")

    def __init__(self, native: _native.Prepared, view: View) -> None:
        self._native = native
        self._view = view

    @property
    def nbytes(self) -> int:
        """Memory that it holds: 48 bytes a triangle."""
        return self._native.nbytes

    @property
    def grid(self) -> float:
        """Unit of the grid, mm."""
        return self._native.unit_mm

    def slice(self, heights: Optional[npt.ArrayLike] = None, **options: Unpack[LayerKeywords]) -> Result:
        """Cut it. The result is that of `lamella.slice` of the mesh.

        Parameters
        ----------
        heights : array_like of float, optional
            As for `lamella.slice`.
        **options
            As for `lamella.slice`, without `unit`, `grid`, `normal` and `transform`, which `prepare` takes.

        Returns
        -------
        Result
        """
        keywords: Dict[str, Any] = {"heights": heights, **options}
        native = slice_options(keywords, prepared=True)
        return finish(self._view.run(_native.slice_prepared, native, self._native), self._view, keywords)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a prepared mesh is not pickled: pickle the mesh, and prepare it where it is sliced")

    def __repr__(self) -> str:
        return f"<lamella.Prepared: {self._view.triangle_count:,} triangles, {self.nbytes:,} bytes>"


def prepare(
    mesh: MeshLike,
    faces: Optional[npt.ArrayLike] = None,
    *,
    unit: Union[None, str, float] = None,
    grid: Union[None, str, float] = None,
    normal: Optional[npt.ArrayLike] = None,
    transform: Optional[npt.ArrayLike] = None,
    threads: int = 0,
    progress: ProgressLike = None,
) -> Prepared:
    """Prepare a mesh for many slices: one plane then reads little more than the triangles that it cuts.

    Parameters
    ----------
    mesh, faces, unit, grid, normal, transform, threads, progress
        As for `slice`.

    Returns
    -------
    Prepared

    Examples
    --------
    >>> tetrahedron = lamella.prepare(corners, faces)
    >>> [tetrahedron.slice([z]).areas[0].round(3) for z in (10, 30)]
    [253.125, 28.125]
    """
    view = as_view(mesh, faces, unit=unit)
    options = slice_options({"grid": grid, "normal": normal, "transform": transform, "threads": threads, "progress": progress})
    return Prepared(view.run(_native.prepare, options), view)
