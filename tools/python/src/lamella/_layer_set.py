"""Sets of layers, which combine() combines."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Optional, Sequence, Union

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._layer import Layer
    from ._result import Result


class SetMethods:
    """Makes a `LayerSet` of what has it. Of several calls of one method the last one counts."""

    __slots__ = ()

    def grown(self, mm: float) -> LayerSet:
        """The same, its edges moved outwards so far, or inwards where `mm` is negative."""
        return replace(as_set(self), grow=mm)

    def shifted(self, first: int, last: Optional[int] = None) -> LayerSet:
        """For layer n of the answer its layers n + first to n + last as one; without `last` layer n + first alone."""
        return replace(as_set(self), first=first, last=first if last is None else last)

    def of_part(self, part: int) -> LayerSet:
        """Contours of this part alone, as ``contours["part"]`` names it."""
        return replace(as_set(self), part=part)


@dataclass(frozen=True)
class LayerSet(SetMethods):
    """One of the sets that `combine` combines. `Result` and `Layer` make it by the same methods.

    Examples
    --------
    >>> s = lamella.slice(corners, faces, layer_height=10)
    >>> above = s.shifted(1).grown(0.5)
    >>> above.first, above.last, above.grow
    (1, 1, 0.5)
    """

    layers: Union[Result, Layer, Sequence[npt.ArrayLike]]
    """A stack; or one layer, or contours (n, 2) in mm, which then stand at every height."""
    first: int = 0
    last: int = 0
    """For layer n of the answer the union of its layers n + first to n + last; beyond the ends there are none."""
    grow: float = 0.0
    """That union's edges move outwards so far first, mm, with mitred corners; negative: inwards."""
    fill_rule: str = "non-zero"
    """Of contours that bound no region yet: "even-odd", "non-zero" or "positive"."""
    part: Optional[int] = None
    """Contours of this part only."""


def as_set(layers: Any) -> LayerSet:
    return layers if isinstance(layers, LayerSet) else LayerSet(layers)
