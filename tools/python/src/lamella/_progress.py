"""What tells the user how far a call is."""

from __future__ import annotations

import sys
from typing import Any, Callable, Optional, Union

from . import _native
from ._errors import InvalidArgumentError

ProgressLike = Union[None, bool, Callable[[float], Any]]
"""True for a bar, or a callable that takes a fraction from 0 to 1."""


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


def reporter(progress: ProgressLike) -> Optional[Callable[[float], Any]]:
    """What the engine is to call."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return Bar()
    if not callable(progress):
        raise InvalidArgumentError(f"progress must be True or a callable that takes a fraction, not {progress!r}")
    return progress


def set_progress(options: _native.Options, progress: ProgressLike) -> None:
    report = reporter(progress)
    if report is not None:
        options.set_progress(report)
