"""Images: where their voxels lie. Pixels are not read."""

from __future__ import annotations

import os
from typing import Any, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import Error
from ._options import affine as affine_rows
from ._options import one_of, refuse, whole_array

ImageLike = Any
"""The path of an image or of a folder with a DICOM series, an `Image`, an image of nibabel, or (shape, affine) in RAS."""

FRAMES = ("lps", "ras")
_FLIP = np.diag([-1.0, -1.0, 1.0, 1.0])


class Image:
    """The voxel grid of an image: no pixels.

    Attributes
    ----------
    path : str or None
    shape : (int, int, int)
        Voxels along i, j, k.
    slices : ndarray of float
        Where each slice lies along the normal, from the first, mm. Uneven slices are no masks' own.
    series : str or None
        UID of the DICOM series.
    """

    def __init__(self, native: _native.Geometry, path: Optional[str] = None) -> None:
        self._native = native
        self.path = path
        i, j, k = native.size
        self.shape: Tuple[int, int, int] = (i, j, k)
        self.series = native.series
        uneven = native.uneven
        self.slices: npt.NDArray[np.float64] = uneven if len(uneven) > 0 else np.arange(self.shape[2]) * native.spacing[2]

    def affine(self, frame: str = "ras") -> npt.NDArray[np.float64]:
        """Affine map (4, 4) from (i, j, k, 1) to mm in "ras" or "lps"; its last column is the centre of voxel (0, 0, 0)."""
        one_of("frame", frame, FRAMES)
        matrix = np.eye(4)
        matrix[:3, :3] = np.transpose(self._native.axes) * self._native.spacing
        matrix[:3, 3] = self._native.origin
        return matrix if frame == "lps" else _FLIP @ matrix

    def __repr__(self) -> str:
        spacing = " x ".join(f"{mm:g}" for mm in self._native.spacing)
        return f"<lamella.Image: {' x '.join(map(str, self.shape))} voxels of {spacing} mm>"


def image(path: Union[str, bytes, os.PathLike[Any]]) -> Image:
    """The voxel grid of a NIfTI or NRRD file, or of a folder with a DICOM series.

    Examples
    --------
    >>> lamella.image("ct.nii.gz").shape  # doctest: +SKIP
    (512, 512, 120)
    """
    name = os.fsdecode(path)
    try:
        return Image(_native.read_geometry(os.fsencode(name)), name)
    except Error as error:
        error.path = name
        raise


def image_of(like: ImageLike) -> Image:
    """Whatever says where voxels lie."""
    if isinstance(like, Image):
        return like
    if isinstance(like, (str, bytes, os.PathLike)):
        return image(like)
    if hasattr(like, "affine") and hasattr(like, "shape"):
        return _from_affine(like.shape[:3], like.affine)
    if isinstance(like, tuple) and len(like) == 2:
        return _from_affine(*like)
    refuse(f"like must be the path of an image, an Image, an image of nibabel or (shape, affine), not {like!r}")


def around(low: npt.NDArray[np.float64], high: npt.NDArray[np.float64], spacing: Any) -> Image:
    """Voxels around a box in LPS."""
    mm = np.broadcast_to(whole_array(spacing, "spacing"), 3)
    return Image(_native.geometry_around(low.tolist(), high.tolist(), mm.tolist()))


def _from_affine(shape: Sequence[int], values: npt.ArrayLike) -> Image:
    if len(shape) != 3 or any(int(side) < 1 for side in shape):
        refuse(f"an image has three sides of at least one voxel, and this one's shape is {tuple(shape)}")
    matrix = _FLIP @ np.vstack((affine_rows("affine", values), (0, 0, 0, 1)))
    spacing = np.linalg.norm(matrix[:3, :3], axis=0)
    if not (spacing > 0).all():
        refuse("the affine map has a column of zeros")
    axes = (matrix[:3, :3] / spacing).T
    if np.abs(axes @ axes.T - np.eye(3)).max() > 1e-4:
        refuse("the affine map is sheared: masks are drawn on upright voxels")
    return Image(_native.Geometry([int(side) for side in shape], spacing.tolist(), matrix[:3, 3].tolist(), axes.tolist()))
