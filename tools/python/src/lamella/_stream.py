"""stream(): layers chunk by chunk, in bounded memory."""

from __future__ import annotations

import os
import queue
import re
import threading
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, Optional, Union

import numpy.typing as npt

from . import _native
from ._errors import Error
from ._image import ImageLike
from ._medical import Mask, mask
from ._mesh import MeshLike, View, as_view
from ._options import OF_PREPARED, PreparedKeywords, RuleKeywords, mm_per_unit, progress_report, refuse, slice_options, truth, whole_number
from ._result import Result, warn_of_open

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import SliceKeywords

_BYTES = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}


class Stream:
    """Chunks of layers, from below: an iterator of `Result`, which `close` or the end of a ``with`` ends early.

    Made by `stream`. Of files in binary STL or PLY only what the budget holds is in memory.
    """

    def __init__(self, mesh: Any, faces: Any, chunk: int, memory: Union[None, str, int], keywords: Dict[str, Any], planes: int = 0) -> None:
        self._given = mesh, faces
        self._planes = planes  # of a slice of an image; chunks have whole ones
        self._report = progress_report(keywords.pop("progress", None))
        self._unit = keywords.pop("unit", None)
        self._chunk = whole_number("chunk", chunk)
        if self._chunk == 0:
            refuse("a chunk must have at least one layer")
        self._path = os.fsdecode(mesh) if isinstance(mesh, (str, bytes, os.PathLike)) and faces is None else None
        self._budget = _bytes_of(memory) if memory is not None else 0
        self._keywords = keywords
        slice_options(keywords)  # what is wrong is refused here, not in the loop
        if self._path is None:
            view = as_view(mesh, faces, unit=self._unit).kept()
            self._chunks: Iterator[Result] = self._of_view(view)
        else:
            self._chunks = self._of_file(self._path)

    def __iter__(self) -> Iterator[Result]:
        return self._chunks

    def __next__(self) -> Result:
        return next(self._chunks)

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """No more layers are wanted."""
        self._chunks.close()  # type: ignore[attr-defined]

    def save_table(self, path: Union[str, bytes, os.PathLike[Any]], *, islands: bool = False) -> None:
        """Write the measures of all layers, as `lamella.save_table` does, without ever holding them: of files only."""
        if self._path is None:
            refuse("a stream of a mesh in memory writes no table: lamella.save_table(path, lamella.slice(mesh)) does")
        name = os.path.basename(self._path).split(".")[0]
        options = slice_options({**self._keywords, "progress": self._report})
        to = os.fsencode(os.fsdecode(path))
        if not _native.stream_table(os.fsencode(self._path), self._mm, self._budget, to, os.fsencode(name), truth("islands", islands), options):
            refuse(f"{self._path}: only binary STL and PLY of triangles are read in pieces; lamella.save_table(path, lamella.slice(mesh)) takes others")

    def mask(self, *, like: ImageLike, **options: Any) -> Mask:
        """Draw the mask that `lamella.mask` draws, voxel for voxel, while layers come: in memory of the mask and the stream.

        Parameters are those of `lamella.mask`. The image says where planes lie, and the stream is made without any.
        """
        return mask(self, like=like, **options)

    def at_slices(self, place: Dict[str, Any], planes: int) -> Stream:
        """The same stream, at so many planes for each slice of an image. Open layers are told by who draws them."""
        slice_options(self._keywords, RuleKeywords)
        keywords = {**self._keywords, **place, "unit": self._unit, "progress": place.get("progress", self._report)}
        return Stream(*self._given, max(1, self._chunk // planes) * planes, self._budget or None, keywords, planes)

    @property
    def patient_frame(self) -> str:
        """What the file states: "LPS", "RAS" or ""."""
        stated = None if self._path is None else _native.stated_frame(os.fsencode(self._path))
        return str(as_view(*self._given, unit=None)._meshes[0].info.get("patient_frame", "")) if stated is None else stated

    @property
    def _mm(self) -> float:
        return mm_per_unit("mm" if self._unit is None else self._unit)

    def _of_file(self, path: str) -> Iterator[Result]:
        """Of a thread that reads the file, as long as it can be read in pieces."""
        ready: queue.Queue[Any] = queue.Queue(maxsize=1)
        unwanted = threading.Event()

        def put(item: Any) -> bool:
            while not unwanted.is_set():
                try:
                    ready.put(item, timeout=0.05)
                    return True
                except queue.Full:
                    pass
            return False

        def work() -> None:
            try:
                most_bytes = max(self._budget // 32, 1 << 16) if self._budget else 1 << 24
                budget = max(self._budget - 3 * most_bytes, self._budget // 2)  # being made, waiting, and in use
                options = slice_options({**self._keywords, "progress": self._report})
                led = _native.stream_file(os.fsencode(path), self._mm, budget, self._chunk, max(1, self._planes), most_bytes, options, put)
                put(None if led else path)
            except BaseException as error:  # for whoever waits
                put(error)

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        found = _native.OpenLayers()
        try:
            while isinstance(item := ready.get(), _native.Result):
                found.add(item.open_layers())
                yield Result(item, None)
        finally:
            unwanted.set()
            thread.join()
        if isinstance(item, str):
            yield from self._of_view(as_view(path, None, unit=self._unit))
            return
        if item is not None:
            if isinstance(item, Error):
                item.path = path
            raise item
        if self._planes == 0:
            warn_of_open(found)

    def _of_view(self, view: View) -> Iterator[Result]:
        """Of a prepared mesh, of which each chunk reads little more than it cuts."""
        keywords = dict(self._keywords)
        grid, first, count = view.run(_native.outline, slice_options(keywords))
        frame = {name: keywords.pop(name, None) for name in OF_PREPARED}
        # The grid with room for what offset and closing reach, which preparing does not know.
        prepared = view.run(_native.prepare, slice_options({**frame, "grid": grid, "threads": keywords.get("threads")}))
        found = _native.OpenLayers()
        for begin in range(first, first + count, self._chunk):
            end = min(begin + self._chunk, first + count)
            told = None if self._report is None else _share_of(self._report, (begin - first) / count, (end - begin) / count)
            options = slice_options({**keywords, "layers": (begin, end), "progress": told}, PreparedKeywords)
            layers = view.run(_native.slice_prepared, options, prepared)
            found.add(layers.open_layers())
            yield Result(layers, None)
        if self._report is not None and count == 0:
            self._report(1.0)
        if self._planes == 0:
            warn_of_open(found)


def _share_of(report: Callable[[float], Any], done: float, share: float) -> Callable[[float], Any]:
    return lambda fraction: report(done + fraction * share)


def _bytes_of(memory: Union[str, int]) -> int:
    """A number of bytes, or as the tool reads it: 900M, 4G."""
    if isinstance(memory, str):
        matched = re.fullmatch(r"(\d+(?:\.\d+)?)([KMGT]?)", memory)
        if matched is None:
            refuse(f"memory must be a number of bytes or as '900M', not {memory!r}")
        return int(float(matched[1]) * _BYTES[matched[2]])
    return whole_number("memory", memory)


def stream(
    mesh: MeshLike,
    faces: Optional[npt.ArrayLike] = None,
    *,
    chunk: int = 256,
    memory: Union[None, str, int] = None,
    **options: Unpack[SliceKeywords],
) -> Stream:
    """Cut a mesh chunk by chunk, from below. Memory does not grow with the number of layers.

    Parameters
    ----------
    mesh, faces
        As for `slice`. Of the path of a binary STL or PLY file no more than `memory` is held.
    chunk : int
        Layers in a chunk, at most. The last one may have fewer, and so have those of a file within a small budget.
    memory : str or int, optional
        What slicing a file may hold: bytes, or as "900M" or "4G". Without it half of the machine's memory.
    **options
        As for `slice`.

    Returns
    -------
    Stream
        An iterator of `Result`: the next layers. `Result.first_layer` counts those before them.

    Examples
    --------
    >>> for layers in lamella.stream(corners, faces, layer_height=1, chunk=16):
    ...     print(layers.first_layer, len(layers), layers.areas.sum().round(1))
    0 16 4703.6
    16 16 1247.6
    32 8 47.8
    """
    return Stream(mesh, faces, chunk, memory, dict(options))
