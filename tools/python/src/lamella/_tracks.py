"""tracks(): islands from layer to layer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _native
from ._options import TrackKeywords, refuse, slice_options, truth
from ._result import Result

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Tracks(NamedTuple):
    """Islands and how they are linked. Islands are named by their index in `islands`."""

    islands: npt.NDArray[np.void]
    """By layer and contour: ``layer``, ``contour``, ``area`` and ``centroid`` in mm, how many islands it overlaps ``above`` and
    ``below``, and its ``body``. Links [first_above, first_above + above) lead up from it, and those down from it are
    ``links_by_upper[first_below : first_below + below]``."""
    links: npt.NDArray[np.uint32]
    """(n, 2): lower and upper island of each pair that shares area."""
    links_by_upper: npt.NDArray[np.uint32]
    """Indices of links, by the upper island."""
    pockets: npt.NDArray[np.void]
    """Cavities and cups: ``contour`` of the lowest hole, layers [``first_layer``, ``end_layer``), ``volume`` in mm3, ``is_cavity``."""
    bodies: int

    @property
    def births(self) -> npt.NDArray[np.intp]:
        """Islands with nothing below, but for those of the lowest layer: where supports are needed."""
        return np.flatnonzero((self.islands["below"] == 0) & (self.islands["layer"] > 0))

    @property
    def ends(self) -> npt.NDArray[np.intp]:
        """Islands with nothing above."""
        return np.flatnonzero(self.islands["above"] == 0)

    @property
    def merges(self) -> npt.NDArray[np.intp]:
        return np.flatnonzero(self.islands["below"] > 1)

    @property
    def splits(self) -> npt.NDArray[np.intp]:
        return np.flatnonzero(self.islands["above"] > 1)


def tracks(layers: Result, *, pockets: bool = False, **options: Unpack[TrackKeywords]) -> Tracks:
    """Islands of each layer, linked to those that they overlap below and above.

    Parameters
    ----------
    layers : Result
        Without open contours.
    pockets : bool
        Finds cavities and cups, too.
    **options
        ``threads``, ``progress`` and ``memory_limit``, as for `slice`.

    Returns
    -------
    Tracks
        A named tuple of arrays.

    Examples
    --------
    >>> tracks = lamella.tracks(lamella.slice(corners, faces, layer_height=10))
    >>> tracks.links.tolist()
    [[0, 1], [1, 2], [2, 3]]
    >>> len(tracks.births), tracks.bodies
    (0, 1)
    """
    if not isinstance(layers, Result):
        refuse(f"layers must be a Result, not {layers!r}")
    found: Any = _native.tracks(layers._native, truth("pockets", pockets), slice_options(options, TrackKeywords))
    return Tracks(**found)
