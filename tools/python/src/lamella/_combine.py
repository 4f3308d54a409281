"""combine(), offset() and clip(): layers with layers, their edges moved, and polylines cut by layers."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any, Callable, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._contours import contours_on_grid, grid_step
from ._layer import Layer
from ._layer_set import LayerSet, as_set
from ._options import FILL_RULES, ClipKeywords, CombineKeywords, array_of, number, one_of, refuse, slice_options, whole_number
from ._result import Result

if TYPE_CHECKING:
    from typing_extensions import Unpack

SetLike = Union[Result, Layer, LayerSet, npt.NDArray[Any], Sequence[npt.ArrayLike]]
LinesLike = Union[Result, Layer, npt.NDArray[Any], Sequence[npt.ArrayLike]]
RuleLike = Union[str, npt.ArrayLike, Callable[..., Any]]

RULES = ("unite", "subtract", "intersect", "exclusive", "last")
MOST_FOR_FUNCTION = 16
JOINS = ("miter", "round", "square")
ENDS = ("region", "butt", "square", "round")


def combine(
    sets: Sequence[SetLike], rule: RuleLike = "unite", *, grid: Optional[float] = None, **options: Unpack[CombineKeywords]
) -> Result:
    """Combine layers with layers: unions, differences, intersections of whole stacks, or regions by label.

    Parameters
    ----------
    sets : sequence of Result, Layer, LayerSet or contours
        At most 63. All stacks have the same planes, and all sets the same grid. A `Layer`, and contours (a list of arrays
        (n, 2) in mm, or one such array), stand at every height. `Result.grown`, `Result.shifted` and `Result.of_part` say
        which layers of a stack are meant, and how far they grow first.
    rule : {"unite", "subtract", "intersect", "exclusive", "last"}, array_like of int, or callable
        What is solid: in any set; in the first and in no other; in all; in an odd number; or, for "last", in any, labelled
        by the last set that it is in. An array of 2^n labels: that of what is in sets i, j, ... is ``rule[2**i + 2**j + ...]``.
        A function of n flags, one for each of at most 16 sets, returns a label, or whether there is solid. Label 0 is
        empty, and label l becomes part l - 1; what is in no set has label 0.
    grid : float, optional
        Step of the grid of contours, mm; without it that of the first result or layer, or 2^-20.
    **options
        ``closing``, ``offset``, ``simplify`` and the other rules of regions but fill rules, done to the answer, and
        ``threads``, ``progress`` and ``memory_limit``, as for `slice`.

    Returns
    -------
    Result
        Layers at the planes of the stacks; without any stack one layer at 0. Parts share every point of the boundary between
        them. It depends neither on threads nor on the order of sets, but for what the rule makes of it.

    Examples
    --------
    >>> body = lamella.slice(corners, faces, layer_height=10)
    >>> tops = lamella.combine([body, body.shifted(1)], "subtract")
    >>> tops.areas.round(3)
    array([168.75 , 112.5  ,  56.25 ,   7.031])
    >>> bed = np.array([[0, 0], [10, 0], [10, 40], [0, 40]])
    >>> lamella.combine([body, bed], lambda body, bed: 0 if not body else 2 if bed else 1).contours["part"]
    array([0, 1, 0, 1, 0, 1, 1], dtype=uint32)
    """
    _refuse_fill("combine", options)
    asked = [as_set(each) for each in sets]
    if not 1 <= len(asked) <= _native.most_layer_sets:
        refuse(f"from 1 to {_native.most_layer_sets} sets of layers can be combined, not {len(asked)}")
    step = _step(asked, grid)
    native = [_native_set(each, f"sets[{i}]", step) for i, each in enumerate(asked)]
    return Result(_native.combine(native, _native_rule(rule, len(asked)), slice_options(options, CombineKeywords)), None)


def offset(
    layers: SetLike,
    steps: Union[float, Sequence[float]],
    *,
    join: str = "miter",
    end: str = "region",
    arc_tolerance: float = 0.005,
    keep: Union[str, Sequence[bool]] = "all", grid: Optional[float] = None,  # fmt: skip
    **options: Unpack[CombineKeywords],
) -> Result:
    """Move the edges of layers outwards, or inwards, in one step or several.

    Parameters
    ----------
    layers : Result, Layer, LayerSet or contours
        As for `combine`.
    steps : float or sequence of float
        How far edges move, mm, each from where the step before left them; negative: inwards.
    join : {"miter", "round", "square"}
        What corners become that the offset moves apart. Arcs lie between the distance and `arc_tolerance` mm more.
    end : {"region", "butt", "square", "round"}
        Other than "region": contours given as arrays, and open ones of layers, are lines with such ends, and closed ones of
        layers lines without ends. The first step is above 0 then.
    keep : {"all", "last"} or sequence of bool
        The steps whose regions are parts 0, 1, ... of the answer. An opening keeps the last of two steps.
    grid : float, optional
        As for `combine`.
    **options
        As for `combine`. A corner farther away than ``miter_limit`` distances, 3 without it, is cut.

    Examples
    --------
    >>> s = lamella.slice(corners, faces, layer_height=10)
    >>> walls = lamella.offset(s, [-0.2, -0.4, -0.4])
    >>> walls.contours["part"]
    array([0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2], dtype=uint32)
    >>> lamella.offset(s, [-1, 1], keep="last", join="round").contours.size
    4
    >>> line = [[0, 0], [10, 0], [10, 10]]
    >>> float(lamella.offset([line], 1, end="butt").areas[0])
    40.0
    """
    _refuse_fill("offset", options)
    asked = as_set(layers)
    step = _step([asked], grid)
    moves = [number("steps", mm) for mm in (steps if isinstance(steps, (Sequence, np.ndarray)) else [steps])]
    if keep == "all" or keep == "last":
        kept = [keep == "all" or i + 1 == len(moves) for i in range(len(moves))]
    else:
        kept = [bool(each) for each in keep]
        if len(kept) != len(moves):
            refuse(f"keep has {len(kept)} flags for {len(moves)} steps")
    how = (
        one_of("join", join, JOINS),
        one_of("end", end, ENDS),
        number("miter_limit", options.get("miter_limit", 3.0)),
        number("arc_tolerance", arc_tolerance),
    )
    native = [_native_set(asked, "layers", step)]
    return Result(_native.offset(native, list(zip(moves, kept)), how, slice_options(options, CombineKeywords)), None)


def _refuse_fill(call: str, options: Iterable[str]) -> None:
    for name in options:
        if name.startswith("fill_"):
            refuse(f"{name} is not for {call}(), but a set has a fill rule: lamella.LayerSet(layers, fill_rule=...)")


def clip(
    lines: LinesLike,
    layers: SetLike,
    *,
    inside: bool = True,
    boundary_inside: bool = True, grid: Optional[float] = None,  # fmt: skip
    **options: Unpack[ClipKeywords],
) -> Result:
    """Cut polylines, as infill, to what lies inside layers, or outside.

    Parameters
    ----------
    lines : Result, Layer or polylines
        Polylines are a list of arrays (n, 2) in mm, or one such array; they and a `Layer` stand at every height.
    layers : Result, Layer, LayerSet or contours
        As one of the sets of `combine`.
    inside, boundary_inside : bool
        Whether to keep what lies inside, or else what lies outside; and whether a boundary counts as inside.
    grid, **options
        As for `combine`, but that there are no rules of regions.

    Returns
    -------
    Result
        Layers of open contours, by polyline and in order along it; ``contours["part"]`` is the polyline's number.

    Examples
    --------
    >>> body = lamella.slice(corners, faces, layer_height=10)
    >>> hatch = [[[-30, y], [30, y]] for y in range(-20, 30, 5)]
    >>> infill = lamella.clip(hatch, body.grown(-1))
    >>> infill[0].contours["part"]
    array([5, 6, 7, 8], dtype=uint32)
    """
    if isinstance(lines, LayerSet):
        refuse("lines must be a Result, a Layer or polylines: a LayerSet is for layers")
    asked = [as_set(lines), as_set(layers)]
    step = _step(asked, grid)
    native = [_native_set(each, name, step) for each, name in zip(asked, ("lines", "layers"))]
    return Result(_native.clip(native, bool(inside), bool(boundary_inside), slice_options(options, ClipKeywords)), None)


def _step(sets: Sequence[LayerSet], grid: Optional[float]) -> float:
    if grid is not None:
        return grid_step(grid)
    for each in sets:
        if isinstance(each.layers, Result):
            return each.layers.grid
        if isinstance(each.layers, Layer):
            return each.layers.result.grid
    return 2.0**-20


def _native_set(each: LayerSet, name: str, step: float) -> Tuple[Any, ...]:
    layers: Any = each.layers
    what: Any
    if isinstance(layers, Result):
        what = layers._native
    elif isinstance(layers, Layer):
        what = (layers.result._native, layers.index)
    else:
        if isinstance(layers, (str, bytes)) or not hasattr(layers, "__iter__"):
            refuse(f"{name} must be a Result, a Layer, a LayerSet or contours, not {layers!r}")
        one = isinstance(layers, np.ndarray) and layers.ndim == 2
        what = (contours_on_grid([layers] if one else layers, name, step), step)
    part = None if each.part is None else whole_number(f"part of {name}", each.part)
    if part is not None and part >= 2**32:
        refuse(f"part of {name} must be below 2**32, and is {part}")
    fill_rule = one_of(f"fill_rule of {name}", each.fill_rule, FILL_RULES)
    first, last = (_distance(f"{end} of {name}", value) for end, value in (("first", each.first), ("last", each.last)))
    return what, first, last, number(f"grow of {name}", each.grow), fill_rule, part


def _distance(name: str, value: Any) -> int:
    """In layers, up or down."""
    try:
        layers = operator.index(value)
    except TypeError:
        refuse(f"{name} must be a whole number, not {value!r}")
    if not abs(layers) < 2**31:
        refuse(f"{name} must be within 2**31 layers, and is {layers}")
    return layers


def _native_rule(rule: RuleLike, sets: int) -> Union[int, npt.NDArray[np.uint32]]:
    if isinstance(rule, str):
        return one_of("rule", rule, RULES)
    if callable(rule):
        if sets > MOST_FOR_FUNCTION:
            refuse(f"a function as rule takes at most {MOST_FOR_FUNCTION} sets, and there are {sets}; a rule by name takes more")
        flags = [[membership >> i & 1 == 1 for i in range(sets)] for membership in range(1 << sets)]
        rule = [_label(rule, inside) for inside in flags]
    labels = array_of(rule, "rule", kinds="iub")
    if labels.shape != (1 << sets,):
        refuse(f"rule must have 2**{sets} labels for {sets} sets in one dimension, and has shape {labels.shape}")
    if not (0 <= labels.min() and labels.max() <= _native.most_labels):
        refuse(f"labels of rule must be from 0 to {_native.most_labels}, and reach from {labels.min()} to {labels.max()}")
    return np.ascontiguousarray(labels, dtype=np.uint32)


def _label(rule: Callable[..., Any], inside: List[bool]) -> int:
    label = rule(*inside)
    try:
        return int(label) if isinstance(label, np.bool_) else operator.index(label)
    except TypeError:
        refuse(f"rule must give a label or True or False, and gives {label!r} for {', '.join(map(str, inside))}")
