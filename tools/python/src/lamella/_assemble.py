"""assemble(): contours from segments that the caller brings."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import InvalidArgumentError
from ._layer import Layer
from ._options import number, whole_array
from ._result import Result


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
