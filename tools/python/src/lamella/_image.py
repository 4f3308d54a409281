"""Images: where their voxels lie. Pixels are not read."""

from __future__ import annotations

import os
from typing import Any, Callable, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import Error
from ._options import CallKeywords, one_of, refuse, slice_options, whole_array
from ._options import affine as affine_rows

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
    sheared : bool
        The gantry was tilted: each slice is shifted against the one before.
    """

    def __init__(self, native: _native.Geometry, path: Optional[str] = None) -> None:
        self._native = native
        self.path = path
        i, j, k = native.size
        self.shape: Tuple[int, int, int] = (i, j, k)
        self.series = native.series
        self.sheared = native.sheared
        uneven = native.uneven
        self.slices: npt.NDArray[np.float64] = uneven if len(uneven) > 0 else np.arange(self.shape[2]) * native.spacing[2]

    def affine(self, frame: str = "ras") -> npt.NDArray[np.float64]:
        """Affine map (4, 4) from (i, j, k, 1) to mm in "ras" or "lps"; its last column is the centre of voxel (0, 0, 0)."""
        one_of("frame", frame, FRAMES)
        matrix = np.eye(4)
        matrix[:3, :3] = np.transpose(self._native.steps)
        matrix[:3, 3] = self._native.origin
        return matrix if frame == "lps" else _FLIP @ matrix

    def __repr__(self) -> str:
        spacing = " x ".join(f"{mm:g}" for mm in self._native.spacing)
        return f"<lamella.Image: {' x '.join(map(str, self.shape))} voxels of {spacing} mm>"


class Series(NamedTuple):
    """A DICOM series of a folder."""

    uid: str
    modality: str
    description: str
    files: int
    refusal: str
    """Why it does not serve as an image; empty where it does."""


def list_series(folder: Union[str, bytes, os.PathLike[Any]]) -> List[Series]:
    """The DICOM series of a folder."""
    return [Series(*row) for row in of_file(folder, lambda name: _native.list_series(name, slice_options({}, CallKeywords)))]


def image(path: Union[str, bytes, os.PathLike[Any]], *, series: Optional[str] = None) -> Image:
    """The voxel grid of a NIfTI, NRRD or MetaImage file, or of a folder with DICOM files.

    Parameters
    ----------
    path : path
    series : str, optional
        UID of the one that is meant, where the folder holds several: `list_series` tells them.

    Examples
    --------
    >>> lamella.image("ct.nii.gz").shape  # doctest: +SKIP
    (512, 512, 120)
    """
    return Image(of_file(path, lambda name: _native.read_geometry(name, series or "")), os.fsdecode(path))


def of_file(path: Union[str, bytes, os.PathLike[Any]], call: Callable[[bytes], Any]) -> Any:
    name = os.fsdecode(path)
    try:
        return call(os.fsencode(name))
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
    i, j, k = matrix[:3, :3].T
    sides = np.linalg.norm((i, j), axis=1)
    if not (sides > 0).all() or np.linalg.det(matrix[:3, :3]) == 0:
        refuse("the affine map has a column of zeros, or is flat")
    across = np.array((i / sides[0], j / sides[1]))
    if abs(across[0] @ across[1]) > 1e-4:
        refuse("the affine map is sheared within its slices: rows and columns of voxels are square to one another")
    shear = across @ k
    normal = k - shear @ across  # of the slices
    height = float(np.linalg.norm(normal))
    shear[np.abs(shear) < 1e-4 * height] = 0
    axes = np.vstack((across, normal / height))
    spacing = [*map(float, sides), height]
    return Image(_native.Geometry([int(side) for side in shape], spacing, matrix[:3, 3].tolist(), axes.tolist(), shear.tolist()))
