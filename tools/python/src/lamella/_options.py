"""Keyword options, checked and handed to the engine, and what tells the user how far a call is."""

from __future__ import annotations

import difflib
import inspect
import math
import operator
import sys
import textwrap
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, NoReturn, Optional, Sequence, Tuple, TypedDict, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _native, _option_table
from ._errors import InvalidArgumentError
from ._option_table import FrameOptions, HeightOptions, LayerOptions, RegionOptions, TransformOptions, UniformOptions

ProgressLike = Union[None, bool, Callable[[float], Any]]
"""True for a bar, or a callable that takes a fraction from 0 to 1."""


class Option(NamedTuple):
    text: str
    kind: str
    fields: Tuple[str, ...]
    """Of SliceOptions: one, or both ends of a range."""
    default: Any
    words: Tuple[str, ...] = ()
    special: Mapping[str, float] = {}
    """A word that stands for a number."""
    least: Optional[float] = None
    exclusive: bool = False
    """It must be more than `least`."""


OPTIONS = {name: Option(**row) for name, row in _option_table.OPTIONS.items()}


class CallKeywords(TypedDict, total=False):
    threads: int
    progress: ProgressLike


class PlaceKeywords(FrameOptions, TransformOptions, total=False):
    """Where a mesh lies on its grid."""

    unit: Union[None, str, float]
    normal: Optional[npt.ArrayLike]


class FrameKeywords(CallKeywords, PlaceKeywords, total=False):
    """Keyword options of `prepare` and `check`."""


class RuleKeywords(CallKeywords, LayerOptions, RegionOptions, total=False):
    """Those of every call that slices."""

    memory_limit: int


class RegionKeywords(CallKeywords, RegionOptions, total=False):
    """Those of `region_of`."""


class CombineKeywords(RegionKeywords, total=False):
    """Those of `combine`."""

    memory_limit: int


class ClipKeywords(CallKeywords, total=False):
    """Those of `clip`."""

    memory_limit: int


class TrackKeywords(CallKeywords, total=False):
    """Those of `tracks`."""

    memory_limit: int


class SectionKeywords(RuleKeywords, FrameOptions, total=False):
    """Those of `section`, which places the planes itself."""

    unit: Union[None, str, float]


class LayerKeywords(RuleKeywords, UniformOptions, total=False):
    """Those of a prepared mesh, which has its place."""


class PreparedKeywords(LayerKeywords, HeightOptions, total=False):
    """Those, and its heights."""


class SliceKeywords(PreparedKeywords, PlaceKeywords, total=False):
    """All of them."""


MM_PER_UNIT = {"mm": 1.0, "um": 1e-3, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
FILL_RULES = OPTIONS["fill_rule"].words
OF_PREPARED = PlaceKeywords.__annotations__


def refuse(message: str) -> NoReturn:
    raise InvalidArgumentError(message)


def number(name: str, value: Any) -> float:
    if isinstance(value, (str, bytes)):
        refuse(f"{name} must be a number, not {value!r}")
    try:
        return float(value)
    except (TypeError, ValueError):
        refuse(f"{name} must be a number, not {value!r}")
    except OverflowError:
        refuse(f"{name} must be a number that 64 bits hold, and is beyond")


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


def array_of(values: Any, name: str, kinds: str = "fiu") -> npt.NDArray[Any]:
    """Numbers of some kinds of numpy's, without a copy where they are in an array."""
    try:
        array = np.asarray(values)
    except ValueError:
        lengths = [np.size(row) for row in values]
        odd = next((row for row, length in enumerate(lengths) if length != lengths[0]), 0)
        refuse(f"{name}[{odd}] has {lengths[odd]} numbers, the rows before it {lengths[0]}")
    if array.dtype.kind not in kinds:
        refuse(f"{name} must be {'numbers' if 'f' in kinds else 'integers'}, and are of dtype {array.dtype}")
    return array


def whole_array(values: Any, name: str) -> npt.NDArray[np.float64]:
    return array_of(values, name).astype(np.float64, copy=False)


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


def _limited(name: str, option: Option, value: Any) -> float:
    if isinstance(value, str) and option.special:
        if value not in option.special:
            refuse(f"{name} must be a number or {' or '.join(map(repr, option.special))}, not {value!r}")
        return option.special[value]
    length = number(name, value)
    if option.least is not None and not (length > option.least if option.exclusive else length >= option.least):
        refuse(f"{name} must be {'more than' if option.exclusive else 'at least'} {option.least}, and is {length:g}")
    return length


def _range(name: str, _: Option, value: Any) -> Tuple[int, int]:
    try:
        first, end = value
    except (TypeError, ValueError):
        refuse(f"{name} must be the first one and one past the last, not {value!r}")
    return whole_number(f"the first of {name}", first), whole_number(f"the end of {name}", end)


def _fill_from(name: str, _: Option, value: Any) -> List[Any]:
    try:
        pairs = [(layer, rule) for layer, rule in value]
    except (TypeError, ValueError):
        refuse(f"{name} must be pairs of a layer and a fill rule, not {value!r}")
    return [(whole_number(f"a layer of {name}", layer), one_of(f"a rule of {name}", rule, FILL_RULES)) for layer, rule in pairs]


def _heights(name: str, _: Option, value: Any) -> npt.NDArray[np.float64]:
    heights = np.atleast_1d(whole_array(value, name))
    if heights.ndim != 1:
        refuse(f"{name} must have one dimension, and have shape {heights.shape}")
    return np.ascontiguousarray(heights)


def rows_of(name: str, width: int, value: Any) -> npt.NDArray[np.float64]:
    rows = whole_array(value, name)
    if rows.ndim != 2 or rows.shape[1] != width:
        refuse(f"{name} must have shape (n, {width}), and have {rows.shape}")
    return np.ascontiguousarray(rows)


_CHECKS: Dict[str, Callable[[str, Option, Any], Any]] = {
    "mm": _limited,
    "optional_mm": _limited,
    "number": _limited,
    "flag": lambda name, _, value: truth(name, value),
    "choice": lambda name, option, value: one_of(name, value, option.words),
    "count": _range,
    "heights": _heights,
    "slabs": lambda name, _, value: rows_of(name, 2, value),
    "transform": lambda name, _, value: affine(name, value),
    "fill_from": _fill_from,
}


def _checked(given: Mapping[str, Any]) -> Dict[str, Any]:
    """Values by the names of the engine's members."""
    fields: Dict[str, Any] = {}
    for name, value in given.items():
        option = OPTIONS[name]
        checked = _CHECKS[option.kind](name, option, value)
        fields.update(zip(option.fields, checked if len(option.fields) > 1 else (checked,)))
    return fields


_DEFAULTS = _checked({name: option.default for name, option in OPTIONS.items() if option.default is not None})


def slice_options(keywords: Mapping[str, Any], allowed: Any = SliceKeywords) -> _native.Options:
    """The engine's options, of those that a call allows. None stands for an option that is not given."""
    given = {name: value for name, value in keywords.items() if value is not None}
    known = sorted(allowed.__annotations__)
    for name in given:
        if name not in known:
            if allowed is PreparedKeywords and name in OF_PREPARED:
                refuse(f"{name} is for prepare(), which has put the mesh on its grid")
            if name in SliceKeywords.__annotations__:
                refuse(f"{name} is an option of slice() that this call does not use; allowed: {', '.join(known)}")
            near = difflib.get_close_matches(name, known, n=1)
            refuse(f"there is no option {name!r}; " + (f"is it {near[0]!r}?" if near else f"allowed: {', '.join(known)}"))
        for planes in ("heights", "slabs"):
            if planes in given and name in UniformOptions.__annotations__:
                refuse(f"{planes} and {name} exclude each other")
    normal = given.pop("normal", None)
    if normal is not None and "transform" in given:
        refuse("normal and transform exclude each other")
    progress = progress_report(given.pop("progress", None))
    threads = whole_number("threads", given.pop("threads", 0))
    if threads > 4096:
        refuse(f"threads must be at most 4096, and are {threads}")
    memory_limit = whole_number("memory_limit", given.pop("memory_limit", 0))
    fields = {**_DEFAULTS, **_checked(given)}
    if fields["content"] != 0 and "fill_rule" not in given:
        del fields["fill_rule"]  # what faces project is united by a rule of its own
    if normal is not None:
        fields["transform"] = _native.from_normal(*direction("normal", normal))
    return _native.Options(fields, threads, memory_limit, progress)


Call = TypeVar("Call", bound=Callable[..., Any])


def documented(call: Call) -> Call:
    """A call that takes all options as `**options`: its signature and docstring name each, as help() and editors show it."""
    kinds = {
        "flag": "bool",
        "count": "(int, int)",
        "heights": "array_like of float",
        "slabs": "array_like of float, shape (n, 2)",
        "transform": "array_like of float, shape (4, 4) or (3, 4)",
        "fill_from": "sequence of (int, str)",
    }
    entries = []
    for name, option in OPTIONS.items():
        words = ", ".join(f'"{word}"' for word in option.words)
        kind = f"{{{words}}}" if words else kinds.get(option.kind, " or ".join(["float", *map(repr, option.special)]))
        entries += [f"    {name} : {kind}", textwrap.indent(textwrap.fill(option.text, 117), "        ")]
    call.__doc__ = (call.__doc__ or "").replace("    **options", "\n".join(entries))
    signature = inspect.signature(call)
    own = [parameter for parameter in signature.parameters.values() if parameter.kind is not inspect.Parameter.VAR_KEYWORD]
    added = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=OPTIONS[name].default if name in OPTIONS else None)
        for name in SliceKeywords.__annotations__
    ]
    setattr(call, "__signature__", signature.replace(parameters=own + added))  # noqa: B010: mypy knows no such attribute
    return call


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

    __del__ = close


def progress_report(progress: ProgressLike) -> Optional[Callable[[float], Any]]:
    """What is told the progress, if anything is."""
    if progress is None or progress is False:
        return None
    report = Bar() if progress is True else progress
    if not callable(report):
        refuse(f"progress must be True or a callable that takes a fraction, not {progress!r}")
    return report
