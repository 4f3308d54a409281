"""Contours of the caller's, on the grid."""

from __future__ import annotations

from typing import Any, Iterable, List

import numpy as np
import numpy.typing as npt

from ._errors import CoordinateError
from ._options import number, refuse, whole_array


def grid_step(grid: Any) -> float:
    step = number("grid", grid)
    if not 0 < step < float("inf"):
        refuse(f"grid must be finite and more than 0 mm, and is {step:g}")
    return step


def on_grid(rows: npt.NDArray[np.float64], name: str, step: float) -> npt.NDArray[np.int32]:
    with np.errstate(over="ignore"):
        units = np.rint(rows / step)
    wrong = np.argwhere(~(np.abs(units) <= 2**30))
    if len(wrong) > 0:
        raise CoordinateError(f"{name}[{wrong[0, 0]}] has a coordinate that is not finite or beyond 2^30 grid units")
    return np.ascontiguousarray(units.astype(np.int32))


def contours_on_grid(contours: Iterable[npt.ArrayLike], name: str, step: float) -> List[npt.NDArray[np.int32]]:
    """Of points (n, 2) in mm."""
    paths: List[npt.NDArray[np.int32]] = []
    for i, contour in enumerate(contours):
        own = f"{name}[{i}]"
        points = whole_array(contour, own)
        if points.ndim != 2 or points.shape[1] != 2:
            refuse(f"{own} must have shape (n, 2), and has {points.shape}")
        paths.append(on_grid(points, own, step))
    return paths
