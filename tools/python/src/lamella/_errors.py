"""Errors that are raised, with the evidence, and warnings."""

from __future__ import annotations

import sys
import warnings
from types import FrameType
from typing import Optional


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

    def __init__(
        self,
        message: str,
        *,
        triangle: Optional[int] = None,
        vertex: Optional[int] = None,
        layer: Optional[int] = None,
        path: Optional[str] = None,
        byte_offset: Optional[int] = None,
    ) -> None:
        super().__init__(message)
        self.triangle = triangle
        self.vertex = vertex
        self.layer = layer
        self.path = path
        self.byte_offset = byte_offset


class InvalidArgumentError(Error, ValueError):
    """An argument that contradicts itself or another, has the wrong shape or type, or lies outside its range."""

    code = "invalid_argument"


class MeshTypeError(Error, TypeError):
    """Something that is no mesh."""

    code = "no_mesh"


class UnreadableFileError(Error, OSError):
    """A file that is missing, a directory, without permission, or that changed while it was read."""

    code = "unreadable_file"


class MalformedMeshError(Error, ValueError):
    """A file that is not a mesh in the format that it claims."""

    code = "malformed_mesh"


class EmptyMeshError(Error, ValueError):
    """A mesh without a triangle, or without one that has three distinct corners on the grid."""

    code = "empty_mesh"


class CoordinateError(Error, ValueError):
    """A coordinate that is not finite, or beyond 1e9 mm, or beyond the grid that was asked for."""

    code = "bad_coordinate"


class PlanesError(Error, ValueError):
    """A height that is not finite, a step below two units of the grid, or too many planes."""

    code = "bad_planes"


class ResultTooLargeError(Error, MemoryError):
    """A result that is known to exceed the memory limit. Nothing was allocated for it."""

    code = "result_too_large"


class OutOfMemoryError(Error, MemoryError):
    """An allocation failed."""

    code = "out_of_memory"


class CancelledError(Error):
    """The caller ended the call."""

    code = "cancelled"


class UnwritableFileError(Error, OSError):
    """A file that could not be created or written."""

    code = "unwritable_file"


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
