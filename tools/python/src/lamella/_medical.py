"""Masks, structure sets, tables, archives and pictures of meshes or results."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import InvalidArgumentError, MeshWarning, warn
from ._image import FRAMES, Image, ImageLike, around, image_of, of_file
from ._mesh import Mesh, MeshLike, as_view
from ._options import CallKeywords, RuleKeywords, number, one_of, refuse, slice_options, truth, whole_number
from ._result import Result
from ._slice import slice

if TYPE_CHECKING:
    from typing_extensions import Unpack

PathLike = Union[str, bytes, os.PathLike[Any]]
Meshes = Union[MeshLike, Result, Sequence[Union[MeshLike, Result]], Mapping[str, Union[MeshLike, Result]]]
"""A mesh or a result, several of them, or several by their names."""


class Mask(NamedTuple):
    """Voxels and where they lie: ``nibabel.Nifti1Image(mask.array, mask.affine)``, ``mask.array.T`` for scikit-image."""

    array: npt.NDArray[Any]
    """(i, j, k), i fastest: labels from 1 on, or shares."""
    affine: npt.NDArray[np.float64]
    """(4, 4), from (i, j, k, 1) to mm; its last column is the centre of voxel (0, 0, 0)."""
    frame: str
    """Of the affine map: "ras" or "lps"."""
    labels: Dict[int, str]
    """Names by label."""
    voxels: List[int]
    """Of each label; of shares those that are not 0."""
    overlaps: int
    """Voxels in several meshes: they have the later label."""


def mask(
    meshes: Meshes,
    *,
    like: Optional[ImageLike] = None,
    spacing: Optional[npt.ArrayLike] = None,
    frame: Optional[str] = None,
    coverage: bool = False,
    subslices: int = 1,
    labels: Optional[PathLike] = None,
    affine_frame: str = "ras",
    dtype: Optional[npt.DTypeLike] = None,
    out: Optional[npt.NDArray[Any]] = None,
    strict: bool = False,
    **options: Unpack[RuleKeywords],
) -> Mask:
    """Which voxels of an image lie inside which mesh.

    A voxel is in where its centre is, exactly. The array has the image's own voxel order and is never flipped.

    Parameters
    ----------
    meshes : mesh, Result, or several, or a mapping of names to them; or one Stream
        Label n + 1 is that of mesh n. Results must be cut at the image's slices, as by ``slice(mesh, **image options)`` of
        another mask.
    like : path, Image, image of nibabel or (shape, affine) in RAS
        Whose voxels.
    spacing : float or array_like, shape (3,)
        Instead: voxels of this size in mm around the meshes, along left, posterior, superior.
    frame : {"lps", "ras"}, optional
        Patient frame of meshes that do not state one.
    coverage : bool
        The share of each voxel's area that is inside, instead of a label. Of one mesh.
    subslices : int
        More than 1: the mean share over so many planes a slice.
    labels : path, optional
        A CSV table of ``label`` (1 is the first mesh), ``name``, ``color`` (#rrggbb), ``category``, ``type`` and ``region``
        (scheme^value^meaning).
    affine_frame : {"ras", "lps"}
        Of `Mask.affine`.
    dtype : dtype, optional
        Of the array: integers for labels; shares are 0 to 1 in floats and 0 to 255 in uint8, the default.
    out : ndarray, optional
        Where to: of the image's shape, Fortran order (``order="F"``), and the right dtype; a memory map, too.
    strict : bool
        Fail where a slice has open contours, which enclose nothing.
    **options
        Rules of `slice`: ``stitch``, ``fill_rule``, ``closing``, ``threads``, ``progress`` and so on.

    Examples
    --------
    >>> m = lamella.mask((corners, faces), spacing=1, frame="lps")
    >>> m.array.shape, m.voxels
    ((30, 30, 40), [5990])
    >>> shares = lamella.mask((corners, faces), spacing=1, frame="lps", coverage=True, subslices=4, dtype="f4")
    >>> round(float(shares.array.sum()))
    6000
    """
    job = _Cut.of(meshes, like, spacing, frame, subslices, labels, options)
    shares = job.shares(coverage, subslices)
    native_type = np.dtype(np.uint8 if shares or len(job.parts) <= 255 else np.uint16)
    wanted = np.dtype(dtype) if dtype is not None else native_type if out is None else out.dtype
    if wanted.kind not in ("uif" if shares else "ui") or wanted.itemsize < native_type.itemsize:
        refuse(f"dtype must be {'uint8 or a float' if shares else 'an integer that holds the labels'}, not {wanted}")
    if out is not None and (out.shape != job.image.shape or out.dtype != wanted or not out.flags.f_contiguous or not out.flags.writeable):
        refuse(f"out must be a writable array of shape {job.image.shape} and dtype {wanted} in Fortran order")
    in_place = wanted == native_type
    voxels = out if out is not None and in_place else np.empty(job.image.shape, native_type, order="F")
    summary = job.draw(voxels, truth("coverage", coverage), subslices)
    job.tell_of(summary, truth("strict", strict))
    if not in_place:
        made = np.empty(job.image.shape, wanted, order="F") if out is None else out
        made[...] = voxels
        if shares and wanted.kind == "f":
            made /= 255
        voxels = made
    names = {i + 1: name for i, (_, name, _) in enumerate(job.parts)}
    return Mask(voxels, job.image.affine(affine_frame), affine_frame, names, summary["voxels"], summary["overlaps"])


def save_mask(
    path: PathLike,
    meshes: Meshes,
    *,
    like: Optional[ImageLike] = None,
    spacing: Optional[npt.ArrayLike] = None,
    frame: Optional[str] = None,
    coverage: bool = False,
    subslices: int = 1,
    labels: Optional[PathLike] = None,
    strict: bool = False,
    without_ct: bool = False,
    **options: Unpack[RuleKeywords],
) -> None:
    """Write a mask, by the end of its name: NIfTI (.nii, .nii.gz), NRRD (.nrrd, .seg.nrrd for 3D Slicer), MetaImage (.mha) or a
    DICOM segmentation (.dcm).

    Parameters are those of `mask`. Voxels go slice by slice to the file, which appears whole or not at all. In .seg.nrrd and
    .dcm meshes may overlap. A .dcm refers to the series of `like`, or ``without_ct=True`` to none.
    """
    is_dicom = os.fsdecode(path).lower().endswith(".dcm")
    job = _Cut.of(meshes, like, spacing, frame, subslices, labels, options)
    if strict:
        job.tell_of_open(True)
    if is_dicom:
        summary = job.saved(path, _native.write_segmentation, truth("coverage", coverage), subslices, truth("without_ct", without_ct), _now())
    else:
        job.shares(coverage, subslices)
        summary = job.saved(path, _native.write_mask, truth("coverage", coverage), subslices)
    job.tell_of(summary, strict)


def save_structure_set(
    path: PathLike,
    meshes: Meshes,
    *,
    like: ImageLike,
    frame: Optional[str] = None,
    holes: str = "keyhole",
    labels: Optional[PathLike] = None,
    without_ct: bool = False,
    **options: Unpack[RuleKeywords],
) -> List[str]:
    """Write a DICOM RT Structure Set with one region of interest a mesh.

    Parameters
    ----------
    path : path
    meshes, frame, labels, **options
        As for `mask`.
    like : path of a folder
        The DICOM series that it refers to.
    holes : {"keyhole", "xor"}
        Holes are joined to their contour, or contours exclude one another.
    without_ct : bool
        Write one that refers to no CT.

    Returns
    -------
    list of str
        The names as written: cut to 64 characters, and told apart.
    """
    job = _Cut.of(meshes, like, None, frame, 1, labels, options)
    job.parts = [(*part, i) for i, part in enumerate(job.parts)]
    form = one_of("holes", holes, ("keyhole", "xor"))
    names: List[str] = job.saved(path, _native.write_structure_set, form, truth("without_ct", without_ct), _now())
    job.tell_of_open()
    return names


def _now() -> int:
    """What files say of their time: by SOURCE_DATE_EPOCH where it is set."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    return int(epoch) if epoch else int(time.time())


def save_table(path: PathLike, results: Meshes, *, islands: bool = False) -> None:
    """Write measures as .csv or .jsonl: a row a layer, or a row an island.

    Columns are those of `Result.measures` with their units. What is not known is an empty cell.
    """
    _saved(path, _native.write_table, _named(_results(results)), truth("islands", islands))


def save_archive(path: PathLike, result: Result, *, name: str = "", measures: bool = False) -> None:
    """Write a whole result as HDF5, which `lamella.open`, h5py, MATLAB and Julia read.

    With ``measures=True`` the group ``/measures`` has columns of a table: ``area_mm2``, ``imax_mm4``, ``feret_max_mm`` and so on.
    """
    if not isinstance(result, Result):
        refuse(f"an archive holds one Result, not {result!r}")
    own = truth("measures", measures)
    _called(path, lambda where, options: _native.write_archive(result._native, name, where, own, options))


def save_picture(path: PathLike, results: Meshes) -> None:
    """Write a contact sheet as PNG: evenly spaced layers side by side."""
    _saved(path, _native.write_contact_sheet, _named(_results(results)))


def open(path: PathLike) -> Result:  # noqa: A001: the word of the field
    """Read an archive: a `Result` without its mesh."""
    return Result(_called(path, _native.read_archive), None)


class _Cut:
    """Results at the slices of an image, and their names."""

    def __init__(self, image: Image, parts: List[Tuple[Any, ...]], call: CallKeywords) -> None:
        self.image = image
        self.parts = parts
        self._call = call

    @classmethod
    def of(cls, meshes: Meshes, like: Any, spacing: Any, frame: Optional[str], subslices: int, labels: Any, options: Any) -> _Cut:
        if (like is None) == (spacing is None):
            refuse("one of like and spacing says whose voxels")
        if frame is not None:
            one_of("frame", frame, FRAMES)
        if not 1 <= whole_number("subslices", subslices) <= 1000:
            refuse(f"subslices must be 1 to 1000, and are {subslices}")
        given = _named(meshes)
        image = image_of(like) if like is not None else _image_around([mesh for mesh, _ in given], frame, spacing)
        for warning in image._native.warnings:
            warn(warning, MeshWarning)
        heights = image._native.slice_heights(subslices)
        call: Any = {name: options[name] for name in CallKeywords.__annotations__ if name in options}
        table = {label: (name, terms) for label, name, terms in _called(labels, lambda where, _: _native.read_labels(where))} if labels is not None else {}
        parts: List[Tuple[Any, ...]] = []
        for i, (mesh, own_name) in enumerate(given):
            stated, terms = table.pop(i + 1, ("", _native.Terms()))
            name = stated or own_name
            if isinstance(mesh, Result):
                _require_cut_for(mesh, name, image, heights)
                parts.append((mesh, name, terms))
            else:
                read, own = _with_frame(mesh, name, frame)
                transform = image._native.slicing_frame(own == "ras")
                place = {**options, "transform": transform, "heights": heights}
                parts.append((mesh.at_slices(place, subslices) if _is_stream(mesh) else _quietly(read, place), name, terms))
        if table:
            refuse(f"labels: there is no mesh {min(table)}, only {len(given)}")
        return cls(image, parts, call)

    def shares(self, coverage: bool, subslices: int) -> bool:
        if (coverage or subslices > 1) and len(self.parts) > 1:
            refuse("coverage and subslices: one mesh a mask, not several")
        return coverage or subslices > 1

    def draw(self, voxels: npt.NDArray[Any], coverage: bool, subslices: int) -> Any:
        """What ``_native.draw_mask`` tells; of a stream summed over its chunks, which have whole slices."""
        chunks, *named = self.parts[0]
        if isinstance(chunks, Result) or len(self.parts) > 1:
            return self.run(_native.draw_mask, voxels, coverage, subslices, 0)
        found, count, area, beside = _native.OpenLayers(), 0, 0.0, 0.0
        for chunk in chunks:
            planes = chunk.layer_of.reshape(-1, subslices) - chunk.first_layer
            slices = np.flatnonzero(((planes >= 0) & (planes < len(chunk))).any(axis=1))
            slab, own = voxels[:, :, slices[0] : slices[-1] + 1], _Cut(self.image, [(chunk, *named)], self._call)
            drawn = own.run(_native.draw_mask, slab, coverage, subslices, int(slices[0]))
            found.add(chunk._native.open_layers())
            count, known = count + drawn["voxels"][0], float(np.nansum(chunk.areas))
            area, beside = area + known, beside + known * float(np.nan_to_num(drawn["cut_off"][0]))
        words = found.describe("stitch=") if found.layers > 0 else None
        return {"voxels": [count], "overlaps": 0, "open": [words], "cut_off": [beside / area if area > 0 else 0.0]}

    def run(self, call: Callable[..., Any], *arguments: Any) -> Any:
        if any(_is_stream(result) for result, *_ in self.parts):
            refuse("a stream is drawn by mask(), alone")
        rows = [(result._native, os.fsencode(name), *rest) for result, name, *rest in self.parts]
        return call(rows, self.image._native, *arguments, slice_options(self._call, CallKeywords))

    def saved(self, path: PathLike, call: Callable[..., Any], *arguments: Any) -> Any:
        return _called(path, lambda where, _: self.run(call, where, *arguments))

    def tell_of(self, summary: Any, strict: bool) -> None:
        self.tell_of_open(strict, summary["open"])
        for (_, name, *_), share in zip(self.parts, summary["cut_off"]):
            if share > 0:
                warn(f"{name}: {100 * share:.3g} % of its area in the slices lies beside the image", MeshWarning)

    def tell_of_open(self, strict: bool = False, told: Sequence[Optional[str]] = ()) -> None:
        opened = [result._native.open_layers() for result, *_ in self.parts] if not told else []
        for (_, name, *_), words in zip(self.parts, told or [found.describe("stitch=") if found.layers > 0 else None for found in opened]):
            if words is not None and strict:
                raise InvalidArgumentError(f"{name}: {words}")
            if words is not None:
                warn(f"{name}: {words}", MeshWarning)


def _is_stream(mesh: Any) -> bool:
    return hasattr(mesh, "at_slices")


def _quietly(mesh: Any, options: Any) -> Result:
    """Cut without the warnings of open layers, which are told with the mesh's name."""
    view = as_view(mesh, None, unit=None)
    return Result(view.run(_native.slice, slice_options(options)), view)


def _named(meshes: Any) -> List[Tuple[Any, str]]:
    """Each with its name: a key, that of its file, or a number."""
    if isinstance(meshes, Mapping):
        return [(mesh, str(name)) for name, mesh in meshes.items()]
    several = isinstance(meshes, list) and not (meshes and isinstance(meshes[0], (list, float, int)))
    listed = meshes if several else [meshes]
    return [(mesh, _name_of(mesh, i)) for i, mesh in enumerate(listed)]


def _name_of(mesh: Any, i: int) -> str:
    mesh = mesh._given[0] if _is_stream(mesh) else mesh
    path = mesh if isinstance(mesh, (str, bytes, os.PathLike)) else getattr(mesh, "path", None)
    if isinstance(mesh, Result) and mesh._view is not None and len(mesh._view._meshes) == 1:
        path = mesh._view._meshes[0].path
    if path is None:
        return f"mesh {i + 1}"
    name = os.path.basename(os.fsdecode(path))
    return name.split(".")[0] or name


def _results(results: Any) -> Any:
    for result, _ in _named(results):
        if not isinstance(result, Result):
            refuse(f"results are asked for, as of slice(), not {type(result).__name__}")
    return results


def _with_frame(mesh: Any, name: str, frame: Optional[str]) -> Tuple[Mesh, str]:
    """The mesh, and the patient frame that it states or that the caller says."""
    read: Any = mesh if _is_stream(mesh) else as_view(mesh, None, unit=None)._meshes[0]
    stated = str(read.patient_frame if _is_stream(mesh) else read.info.get("patient_frame", "")).lower()
    if stated not in FRAMES and frame is None:
        refuse(f"{name}: states no patient frame; frame='lps' or frame='ras' says it")
    return read, stated if stated in FRAMES else str(frame)


def _image_around(meshes: List[Any], frame: Optional[str], spacing: Any) -> Image:
    boxes = []
    for i, mesh in enumerate(meshes):
        if isinstance(mesh, Result):
            refuse("spacing: results have been cut already; like= says at which image's slices")
        if _is_stream(mesh):
            refuse("spacing: a stream has no box yet; like= says whose voxels")
        read, own = _with_frame(mesh, _name_of(mesh, i), frame)
        box = read.bounds * ([1, 1, 1] if own == "lps" else [-1, -1, 1])
        boxes += [box.min(axis=0), box.max(axis=0)]
    return around(np.min(boxes, axis=0), np.max(boxes, axis=0), spacing)


def _require_cut_for(result: Result, name: str, image: Image, heights: npt.NDArray[np.float64]) -> None:
    at = result.layers["z"][result.layer_of]
    frames = [image._native.slicing_frame(is_ras) for is_ras in (False, True)]
    placed = any(np.allclose(result.frame[:3], frame, atol=1e-9) for frame in frames)
    if not placed or at.shape != heights.shape or not np.allclose(at, heights, atol=1e-6):
        refuse(f"{name}: the result was not cut at the slices of the image; pass the mesh, or cut it as mask() does")


def _called(path: PathLike, call: Callable[..., Any]) -> Any:
    return of_file(path, lambda name: call(name, slice_options({}, CallKeywords)))


def _saved(path: PathLike, call: Callable[..., Any], parts: List[Tuple[Any, str]], *arguments: Any) -> None:
    rows = [(result._native, os.fsencode(name)) for result, name in parts]
    _called(path, lambda where, options: call(rows, where, *arguments, options))
