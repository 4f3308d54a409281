"""compare(): how alike two stacks of layers are."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _native
from ._options import TrackKeywords, refuse, slice_options, truth
from ._result import Result

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Comparison(NamedTuple):
    """Of each layer, and of the whole stack. Not known is NaN, and so are two empty layers; where one is empty, Dice is 0 and
    distances are infinite."""

    layers: npt.NDArray[np.void]
    """``layer``, ``z``; areas ``first``, ``second`` and ``both`` in mm²; ``dice``, ``jaccard``; of contours ``mean_distance`` and
    ``hausdorff`` in mm."""
    dice: float
    """By volume."""
    jaccard: float
    mean_distance: float
    hausdorff: float


def compare(first: Result, second: Result, *, distances: bool = True, **options: Unpack[TrackKeywords]) -> Comparison:
    """How far the layers of two results overlap, and how far their contours lie apart.

    Parameters
    ----------
    first, second : Result
        Cut at the same planes, on the same grid. A mirrored or moved mesh is cut with its ``transform``.
    distances : bool
        Else only areas are compared.
    **options
        ``threads``, ``progress`` and ``memory_limit``, as for `slice`.

    Examples
    --------
    >>> z = [5, 15, 25]
    >>> c = lamella.compare(lamella.slice(corners, faces, heights=z), lamella.slice(corners * 0.9, faces, heights=z))
    >>> c.layers["dice"].round(3), round(c.dice, 3)
    (array([0.879, 0.827, 0.699]), 0.847)
    """
    for result in (first, second):
        if not isinstance(result, Result):
            refuse(f"two results are compared, and one is {result!r}")
    native = slice_options(options, TrackKeywords)
    return Comparison(*_native.compare(first._native, second._native, truth("distances", distances), native))
