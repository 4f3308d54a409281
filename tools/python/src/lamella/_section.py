"""Planes by origin and normal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy.typing as npt

from ._errors import InvalidArgumentError
from ._mesh import MeshLike
from ._options import plane_frame
from ._slice import slice as slice_mesh

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._layer import Layer
    from ._options import SectionKeywords
    from ._result import Result


def section(mesh: MeshLike, origin: npt.ArrayLike, normal: npt.ArrayLike, **options: Unpack[SectionKeywords]) -> Layer:
    """Cut a mesh by one plane.

    Parameters
    ----------
    mesh : mesh
        As for `slice`; vertices and faces as a pair.
    origin : array_like of float, shape (3,)
        A point of the plane, mm.
    normal : array_like of float, shape (3,)
        What the plane is perpendicular to; any length but zero.
    **options
        As for `slice`, without heights, `normal` and `transform`.

    Returns
    -------
    Layer
        Its points are within the plane, from `origin`; `Layer.to_3d` leads back to the mesh's space.

    Examples
    --------
    >>> cut = lamella.section((corners, faces), origin=[0, 0, 20], normal=[0, 0, 1])
    >>> round(cut.area, 3)
    112.5
    """
    return section_multiplane(mesh, origin, normal, [0.0], **options)[0]


def section_multiplane(
    mesh: MeshLike,
    origin: npt.ArrayLike,
    normal: npt.ArrayLike,
    heights: npt.ArrayLike,
    **options: Unpack[SectionKeywords],
) -> Result:
    """Cut a mesh by parallel planes of any direction.

    Parameters
    ----------
    mesh, origin, normal
        As for `section`.
    heights : array_like of float
        Distances of the planes from `origin` along the normal, mm, in any order.
    **options
        As for `slice`, without heights, `normal` and `transform`.

    Returns
    -------
    Result
        A layer for each distinct height, ascending; `Result.layer_of` names the layer of each height.

    Examples
    --------
    >>> cuts = lamella.section_multiplane((corners, faces), [0, 0, 10], [0, 0, 1], [0, 10])
    >>> cuts.areas.round(3)
    array([253.125, 112.5  ])
    """
    for name in options:
        if name in ("normal", "transform", "layer_height", "first_height", "datum"):
            raise InvalidArgumentError(f"{name} is given by origin, normal and heights")
    return slice_mesh(mesh, transform=plane_frame(origin, normal), heights=heights, **options)
