"""Keyword options, checked and handed to the engine, and what tells the user how far a call is."""

from __future__ import annotations

import difflib
import math
import operator
import sys
from typing import Any, Callable, Dict, List, Mapping, NoReturn, Optional, Sequence, Tuple, TypedDict, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import InvalidArgumentError

ProgressLike = Union[None, bool, Callable[[float], Any]]
"""True for a bar, or a callable that takes a fraction from 0 to 1."""


class RuleKeywords(TypedDict, total=False):
    """Keyword options of `slice`, where they are described: those of what is done to the contours."""

    side: str
    fill_rule: str
    fill_from: Sequence[Tuple[int, str]]
    close: float
    offset: float
    miter_limit: float
    largest_only: bool
    drop_collinear: bool
    simplify: float
    mark_near: float
    close_gaps: Union[str, float]
    gap_sense: str
    origins: bool
    allow_empty: bool
    memory_limit: int
    threads: int
    progress: ProgressLike


class SectionKeywords(RuleKeywords, total=False):
    """Those of `section`, which places the planes itself."""

    unit: Union[None, str, float]
    grid: Union[None, str, float]


class LayerKeywords(RuleKeywords, total=False):
    """Those of a prepared mesh, which has its place."""

    layer_height: Optional[float]
    first_height: Optional[float]
    datum: str


class SliceKeywords(LayerKeywords, total=False):
    """All of them."""

    heights: Optional[npt.ArrayLike]
    unit: Union[None, str, float]
    grid: Union[None, str, float]
    normal: Optional[npt.ArrayLike]
    transform: Optional[npt.ArrayLike]


MM_PER_UNIT = {"mm": 1.0, "um": 1e-3, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
FILL_RULES = ("contours", "even-odd", "non-zero", "positive", "outermost")
UNIFORM_ONLY = ("layer_height", "first_height")
OF_PREPARED = ("unit", "grid", "normal", "transform")


def refuse(message: str) -> NoReturn:
    raise InvalidArgumentError(message)


def number(name: str, value: Any) -> float:
    if isinstance(value, (str, bytes)):
        refuse(f"{name} must be a number, not {value!r}")
    try:
        return float(value)
    except (TypeError, ValueError):
        refuse(f"{name} must be a number, not {value!r}")


def whole_number(name: str, value: Any) -> int:
    try:
        whole = operator.index(value)
    except TypeError:
        refuse(f"{name} must be a whole number, not {value!r}")
    if not 0 <= whole < 2**63:
        refuse(f"{name} must not be negative or beyond 2**63, and is {whole}")
    return whole


def truth(name: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        refuse(f"{name} must be True or False, not {value!r}")
    return bool(value)


def one_of(name: str, value: Any, allowed: Sequence[str]) -> int:
    """The index among what is allowed."""
    if not isinstance(value, str) or value not in allowed:
        refuse(f"{name} must be one of {', '.join(map(repr, allowed))}, not {value!r}")
    return allowed.index(value)


def mm_per_unit(value: Any) -> float:
    if isinstance(value, str):
        if value not in MM_PER_UNIT:
            refuse(f"unit must be a number of mm or one of {', '.join(map(repr, MM_PER_UNIT))}, not {value!r}")
        return MM_PER_UNIT[value]
    mm = number("unit", value)
    if not (0 < mm < math.inf):
        refuse(f"unit must be finite and more than 0 mm, and is {mm:g}")
    return mm


def whole_array(values: Any, name: str) -> npt.NDArray[np.float64]:
    """Numbers as float64, without a copy where they are."""
    try:
        array = np.asarray(values)
    except ValueError:
        refuse(f"{name} must be an array of numbers: its rows differ in length")
    if array.dtype.kind not in "fiu":
        refuse(f"{name} must be numbers, and are of dtype {array.dtype}")
    return array.astype(np.float64, copy=False)


def heights_array(values: Any) -> npt.NDArray[np.float64]:
    heights = np.atleast_1d(whole_array(values, "heights"))
    if heights.ndim != 1:
        refuse(f"heights must have one dimension, and have shape {heights.shape}")
    return np.ascontiguousarray(heights)


def affine(name: str, values: Any) -> npt.NDArray[np.float64]:
    """The upper three rows of a map."""
    matrix = whole_array(values, name)
    if matrix.shape not in ((4, 4), (3, 4)):
        refuse(f"{name} must have shape (4, 4) or (3, 4), and has {matrix.shape}")
    if not np.isfinite(matrix).all():
        row, column = np.argwhere(~np.isfinite(matrix))[0]
        refuse(f"{name}[{row}, {column}] is {matrix[row, column]}")
    if len(matrix) == 4 and not np.array_equal(matrix[3], (0, 0, 0, 1)):
        refuse(f"the last row of {name} must be 0 0 0 1, and is {' '.join(f'{x:g}' for x in matrix[3])}")
    return np.ascontiguousarray(matrix[:3])


def direction(name: str, values: Any) -> npt.NDArray[np.float64]:
    vector = whole_array(values, name)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
        refuse(f"{name} must be three finite numbers, not all 0, and is {values!r}")
    return vector


def plane_frame(origin: Any, normal: Any) -> npt.NDArray[np.float64]:
    """The motion that turns `normal` into z and moves `origin` to zero."""
    point = whole_array(origin, "origin")
    if point.shape != (3,) or not np.isfinite(point).all():
        refuse(f"origin must be three finite numbers, and is {origin!r}")
    frame = np.eye(4)
    frame[:3, :3] = _native.from_normal(*direction("normal", normal))[:, :3]
    frame[:3, 3] = -frame[:3, :3] @ point
    return frame


def _grid(value: Any) -> float:
    if value == "auto":
        return _native.UNIT_BY_BOX
    unit = number("grid", value) if not isinstance(value, str) else refuse(f"grid must be mm or 'auto', not {value!r}")
    if not (0 < unit < math.inf):
        refuse(f"grid must be finite and more than 0 mm, and is {unit:g}")
    return unit


def _close_gaps(value: Any) -> float:
    if value == "auto":
        return _native.GAPS_BY_MESH
    if isinstance(value, str):
        refuse(f"close_gaps must be mm or 'auto', not {value!r}")
    if (length := number("close_gaps", value)) < 0:
        refuse(f"close_gaps must not be negative, and is {length:g}")
    return length


def _fill_from(value: Any) -> List[Any]:
    try:
        pairs = [(whole_number("a layer of fill_from", layer), rule) for layer, rule in value]
    except (TypeError, ValueError) as error:
        if isinstance(error, InvalidArgumentError):
            raise
        refuse(f"fill_from must be pairs of a layer and a fill rule, not {value!r}")
    return [(layer, one_of("a rule of fill_from", rule, FILL_RULES)) for layer, rule in pairs]


def _numeric(attribute: str) -> Tuple[str, Callable[[str, Any], Any]]:
    return attribute, number


def _choice(attribute: str, *allowed: str) -> Tuple[str, Callable[[str, Any], Any]]:
    return attribute, lambda name, value: one_of(name, value, allowed)


# Where each option but those of planes goes: an attribute of _native.Options, and what checks the value.
_ATTRIBUTES: Dict[str, Tuple[str, Callable[[str, Any], Any]]] = {
    "side": _choice("side", "below", "above"),
    "grid": ("unit_mm", lambda _, value: _grid(value)),
    "normal": ("transform", lambda name, value: _native.from_normal(*direction(name, value))),
    "transform": ("transform", affine),
    "fill_rule": _choice("fill_rule", *FILL_RULES),
    "fill_from": ("fill_from", lambda _, value: _fill_from(value)),
    "close": _numeric("close_mm"),
    "offset": _numeric("offset_mm"),
    "miter_limit": _numeric("miter_limit"),
    "largest_only": ("largest_only", truth),
    "drop_collinear": ("drop_collinear", truth),
    "simplify": _numeric("simplify_mm"),
    "mark_near": _numeric("mark_near_mm"),
    "close_gaps": ("close_gaps_mm", lambda _, value: _close_gaps(value)),
    "gap_sense": _choice("gap_sense", "kept", "any"),
    "origins": ("origins", truth),
    "allow_empty": ("allow_empty", truth),
    "memory_limit": ("memory_limit", whole_number),
    "threads": ("threads", whole_number),
}
_PLANES = ("layer_height", "first_height", "datum", "heights")


def slice_options(keywords: Mapping[str, Any], *, prepared: bool = False) -> _native.Options:
    """The engine's options. None stands for an option that is not given."""
    given = {name: value for name, value in keywords.items() if value is not None}
    options = _native.Options()
    options.close_gaps_mm = _native.GAPS_BY_MESH
    for name, value in given.items():
        if prepared and name in OF_PREPARED:
            refuse(f"{name} is for prepare(), which has put the mesh on its grid")
        if name in _ATTRIBUTES:
            attribute, convert = _ATTRIBUTES[name]
            setattr(options, attribute, convert(name, value))
        elif name not in _PLANES and name != "progress":
            _refuse_unknown(name)
    if "normal" in given and "transform" in given:
        refuse("normal and transform exclude each other")
    _set_planes(options, given)
    _set_progress(options, given.get("progress"))
    return options


class Bar:
    """A bar of tqdm where that is installed, else a line on stderr where that is a terminal."""

    def __init__(self) -> None:
        self._bar: Any = None
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return
        self._bar = tqdm(total=100, unit="%", bar_format="{l_bar}{bar}| {elapsed}<{remaining}")

    def __call__(self, fraction: float) -> None:
        percent = int(100 * fraction)
        if self._bar is not None:
            self._bar.update(percent - self._bar.n)
        elif sys.stderr.isatty():
            print(f"\rlamella: {percent} %", end="\n" if fraction == 1 else "", file=sys.stderr, flush=True)
        if fraction == 1:
            self.close()

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()

    def __del__(self) -> None:
        self.close()


def _set_progress(options: _native.Options, progress: ProgressLike) -> None:
    if progress is None or progress is False:
        return
    report = Bar() if progress is True else progress
    if not callable(report):
        refuse(f"progress must be True or a callable that takes a fraction, not {progress!r}")
    options.set_progress(report)


def _set_planes(options: _native.Options, given: Mapping[str, Any]) -> None:
    from_zero = one_of("datum", given.get("datum", "mesh-min"), ("mesh-min", "zero")) == 1
    if "heights" in given:
        for name in UNIFORM_ONLY:
            if name in given:
                refuse(f"heights and {name} exclude each other")
        if from_zero:
            refuse("heights and datum exclude each other: heights count from zero")
        options.set_heights(heights_array(given["heights"]))
    elif any(name in given for name in _PLANES):
        height = number("layer_height", given.get("layer_height", 0.2))
        first = given.get("first_height")
        options.set_layers(height, None if first is None else number("first_height", first), from_zero)


def _refuse_unknown(name: str) -> NoReturn:
    known = [*_PLANES, *_ATTRIBUTES, "progress", "unit"]
    near = difflib.get_close_matches(name, known, n=1)
    refuse(f"there is no option {name!r}; " + (f"is it {near[0]!r}?" if near else f"allowed: {', '.join(sorted(known))}"))
