"""Numbers that stand in arrays, by name."""

from __future__ import annotations

import enum

NO_TRIANGLE = 0xFFFFFFFF
"""In `Result.origins`: the edge comes from no triangle."""

SEVERAL_PARTS = 0xFFFFFFFF
"""In ``Result.contours["part"]``: its edges come from more than one part."""


class Role(enum.IntEnum):
    """What ``Result.contours["role"]`` says."""

    OUTER = 0
    """Closed, counter-clockwise, solid inside."""
    HOLE = 1
    """Closed, clockwise, solid outside."""
    FLAT = 2
    """Closed without area."""
    OPEN = 3
    """A polyline: the mesh lacks a face at both of its ends."""


class ContourFlag(enum.IntFlag):
    """The bits of ``Result.contours["flags"]``."""

    ORIENTATION_OVERRULED = 1
    """The facets' orientation contradicts the role, which was decided by the contours around."""
    ORIENTATION_MIXED = 2
    """Neighbouring facets disagree about which side is solid."""
    GAP_CLOSED = 4
    """Ends of open polylines were joined."""
    NEAR = 8
    """Closing by `mark_near` would change it."""
