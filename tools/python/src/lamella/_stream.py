"""stream(): layers in chunks, while the mesh is being sliced."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, Iterator, Optional

import numpy.typing as npt

from . import _native
from ._errors import InvalidArgumentError
from ._mesh import MeshLike, View, as_view
from ._options import slice_options, whole_number
from ._result import Result, result_of, warn_of_open

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import SliceKeywords


def stream(
    mesh: MeshLike,
    faces: Optional[npt.ArrayLike] = None,
    *,
    chunk: int = 256,
    **options: Unpack[SliceKeywords],
) -> Iterator[Result]:
    """Cut a mesh and hand its layers over in chunks, from below, while the rest is still being cut.

    Memory does not grow with the number of layers. Leaving the loop early ends the slicing.

    Parameters
    ----------
    mesh, faces
        As for `slice`.
    chunk : int
        Layers in a chunk. The last one may have fewer.
    **options
        As for `slice`.

    Yields
    ------
    Result
        The next layers. `Result.first_layer` counts those before it.

    Examples
    --------
    >>> for layers in lamella.stream(corners, faces, layer_height=1, chunk=16):
    ...     print(layers.first_layer, len(layers), layers.areas.sum().round(1))
    0 16 4703.6
    16 16 1247.6
    32 8 47.8
    """
    keywords: Dict[str, Any] = dict(options)
    view = as_view(mesh, faces, unit=keywords.pop("unit", None))
    if whole_number("chunk", chunk) == 0:
        raise InvalidArgumentError("a chunk must have at least one layer")
    chunks = view.run(_native.Stream, slice_options(keywords), chunk)
    return _chunks(chunks, view, keywords)


def _chunks(chunks: _native.Stream, view: View, keywords: Dict[str, Any]) -> Iterator[Result]:
    found = _native.OpenLayers()
    try:
        while (layers := view.run(lambda _: chunks.next())) is not None:
            found.add(layers.open_layers())
            yield result_of(layers, None, keywords)
        warn_of_open(found)
    finally:
        chunks.close()
