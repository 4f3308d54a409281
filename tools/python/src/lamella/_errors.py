"""Errors that are raised, with the evidence, and warnings."""

from __future__ import annotations

import sys
import warnings
from types import FrameType
from typing import Optional, Union


class Error(Exception):
    """Base of all that this package raises.

    Attributes
    ----------
    code : str
        The kind of error, in one word of the engine's: "bad_coordinate", ...
    triangle : int or None
        Row of the triangle to blame in the faces or triangles that were given.
    vertex : int or None
        Row of the vertex to blame in the vertices that were given.
    layer : int or None
        Index of the height to blame among those that were given, or of the layer.
    path : str or None
        The file to blame.
    byte_offset : int or None
        Where in that file.
    """

    code: str = "error"
    triangle: Optional[int] = None
    vertex: Optional[int] = None
    layer: Optional[int] = None
    path: Optional[str] = None
    byte_offset: Optional[int] = None

    def __init_subclass__(cls, code: Optional[str] = None) -> None:
        super().__init_subclass__()
        cls.code = code or cls.code

    def __init__(self, message: str, **evidence: Union[None, int, str]) -> None:
        super().__init__(message)
        self.__dict__.update({name: value for name, value in evidence.items() if value != -1})  # -1: the engine knows none


class InvalidArgumentError(Error, ValueError, code="invalid_argument"):
    """An argument that contradicts itself or another, has the wrong shape or type, or lies outside its range."""


class MeshTypeError(Error, TypeError, code="no_mesh"):
    """Something that is no mesh."""


class UnreadableFileError(Error, OSError, code="unreadable_file"):
    """A file that is missing, a directory, without permission, or that changed while it was read."""


class MalformedMeshError(Error, ValueError, code="malformed_mesh"):
    """A file that is not a mesh in the format that it claims."""


class EmptyMeshError(Error, ValueError, code="empty_mesh"):
    """A mesh without a triangle, or without one that has three distinct corners on the grid."""


class CoordinateError(Error, ValueError, code="bad_coordinate"):
    """A coordinate that is not finite, or beyond 1e9 mm, or beyond the grid that was asked for."""


class PlanesError(Error, ValueError, code="bad_planes"):
    """A height that is not finite, a step below two units of the grid, or too many planes."""


class ResultTooLargeError(Error, MemoryError, code="result_too_large"):
    """A result that is known to exceed the memory limit. Nothing was allocated for it."""


class OutOfMemoryError(Error, MemoryError, code="out_of_memory"):
    """An allocation failed."""


class CancelledError(Error, code="cancelled"):
    """The caller ended the call."""


class UnwritableFileError(Error, OSError, code="unwritable_file"):
    """A file that could not be created or written."""


class MeshWarning(UserWarning):
    """A result stands, but the mesh or its file is not what it should be."""


BY_CODE = {error.code: error for error in Error.__subclasses__()}


def warn(message: str, category: type) -> None:
    """Warns in the name of the first caller outside this package."""
    depth = 2
    frame: Optional[FrameType] = sys._getframe(1)
    while frame is not None and frame.f_globals.get("__package__") == __package__:
        frame = frame.f_back
        depth += 1
    warnings.warn(message, category, stacklevel=depth)
