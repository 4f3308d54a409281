"""The options of a slice, by keyword. Written by engine/options/generate.py."""

from __future__ import annotations

from typing import Any, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple, TypedDict, Union

import numpy.typing as npt


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


# fmt: off
# begin options
OPTIONS: Dict[str, Option] = {
    "layer_height": Option(
        "Height of uniform layers.",
        kind="mm", fields=("layer_height_mm",), least=0, exclusive=True, default=0.2),
    "heights": Option(
        "Cut at these heights instead, in any order; an empty list cuts nothing.",
        kind="heights", fields=("heights_mm",), default=None),
    "stitch": Option(
        "Join ends of open polylines at most so far apart, the nearest first; 0 joins none. 'auto': a hundredth of the "
        "diagonal of the mesh's box.",
        kind="mm", fields=("stitch_mm",), special={"auto": -1}, least=0, default="auto"),
    "stitch_direction": Option(
        "Which ends of open polylines may be stitched. Pairs are joined by distance, the nearest first, and at most one "
        "to each end. 'oriented': An end to a start: every polyline keeps its orientation. 'any': Also two ends or two "
        "starts, for facets that disagree: one of the two polylines is turned round. Of equally near pairs those that "
        "keep the orientation come first.",
        kind="choice", fields=("stitch_direction",), words=("oriented", "any"), default="oriented"),
    "origins": Option(
        "Say which triangle each contour edge comes from.",
        kind="flag", fields=("origins",), default=False),
    "unite_parts": Option(
        "The rules of regions are done to all parts of a layer together, and not to each by itself.",
        kind="flag", fields=("unite_parts",), default=False),
    "allow_empty": Option(
        "A mesh without triangles, or of which none is left on the grid, is no error.",
        kind="flag", fields=("allow_empty",), default=False),
    "content": Option(
        "What a layer shows: the section at its plane, or what faces project onto it. 'section': The cross-section at the "
        "plane. 'upward-faces': The region that upward faces project down onto the plane: top surfaces. 'downward-faces': "
        "The region that downward faces project up onto the plane: bottom surfaces.",
        kind="choice", fields=("content",), words=("section", "upward-faces", "downward-faces"), default="section"),
    "first_height": Option(
        "Height of the first plane above the datum; not given, half a layer.",
        kind="optional_mm", fields=("first_height_mm",), default=None),
    "datum": Option(
        "Where heights of uniform layers count from: the mesh's lowest vertex, or z = 0.",
        kind="choice", fields=("datum",), words=("mesh-min", "zero"), default="mesh-min"),
    "side": Option(
        "Where a plane passes a vertex of exactly its height.",
        kind="choice", fields=("side",), words=("below", "above"), default="below"),
    "layers": Option(
        "Cut the layers of the plan from this one on only; they have the bytes that they have in the whole. One past the "
        "last layer that is cut; may lie beyond the plan's end.",
        kind="count", fields=("first_layer", "end_layer"), default=None),
    "transform": Option(
        "From the mesh in mm to the space of planes and points: planes are horizontal after it.",
        kind="transform", fields=("transform",), default=None),
    "grid": Option(
        "Step of the integer grid; 0: 2^-20 mm, doubled until the mesh fits. 'finest': the finest that the mesh fits.",
        kind="mm", fields=("grid_mm",), special={"finest": -1}, least=0, default=0),
    "coarser_if_needed": Option(
        "A grid that is too fine for the mesh is doubled until it fits, instead of refused.",
        kind="flag", fields=("coarser_if_needed",), default=False),
    "fill_rule": Option(
        "What is solid where contours overlap, nest in the same direction or run backwards. A point's winding number is "
        "how many times contours run counter-clockwise around it. 'contours': The contours as the mesh gives them: "
        "nothing is joined or cut. 'even-odd': Solid within an odd number of contours. 'non-zero': Solid where the "
        "winding number is not 0. 'positive': Solid where the winding number, by the facets' orientation, is more than 0. "
        "'outermost': As non-zero, without holes.",
        kind="choice", fields=("fill_rule",), words=("contours", "even-odd", "non-zero", "positive", "outermost"), default="non-zero"),
    "closing": Option(
        "Fill gaps narrower than twice this, between contours and within one.",
        kind="mm", fields=("closing_mm",), least=0, default=0),
    "offset": Option(
        "Grow what is solid by so much, or shrink it where negative.",
        kind="mm", fields=("offset_mm",), default=0),
    "miter_limit": Option(
        "Cut corners off that closing or offset would move farther than so many times its length.",
        kind="number", fields=("miter_limit",), least=1, default=3),
    "simplify": Option(
        "Drop points that lie within so much of the lines left, last of all.",
        kind="mm", fields=("simplify_mm",), least=0, default=0),
    "flag_closing": Option(
        "Flag contours that closing by so much would change, and change nothing.",
        kind="mm", fields=("flag_closing_mm",), least=0, default=0),
    "drop_collinear": Option(
        "Drop points exactly on the line between their neighbours.",
        kind="flag", fields=("drop_collinear",), default=False),
    "largest_only": Option(
        "Keep the outer contour of the largest area of a layer only, with its holes; of equal areas the one that starts "
        "first.",
        kind="flag", fields=("largest_only",), default=False),
    "fill_from": Option(
        "Other fill rules from these layers of the plan on, ascending.",
        kind="fill_from", fields=("fill_from",), default=None),
}
# end options
# fmt: on


# begin keywords


class UniformOptions(TypedDict, total=False):
    layer_height: Optional[float]
    first_height: Optional[float]
    datum: Optional[str]


class HeightOptions(TypedDict, total=False):
    heights: Optional[npt.ArrayLike]


class LayerOptions(TypedDict, total=False):
    stitch: Optional[Union[str, float]]
    stitch_direction: Optional[str]
    origins: Optional[bool]
    unite_parts: Optional[bool]
    allow_empty: Optional[bool]
    content: Optional[str]
    side: Optional[str]
    layers: Optional[Tuple[int, int]]


class TransformOptions(TypedDict, total=False):
    transform: Optional[npt.ArrayLike]


class FrameOptions(TypedDict, total=False):
    grid: Optional[Union[str, float]]
    coarser_if_needed: Optional[bool]


class RegionOptions(TypedDict, total=False):
    fill_rule: Optional[str]
    closing: Optional[float]
    offset: Optional[float]
    miter_limit: Optional[float]
    simplify: Optional[float]
    flag_closing: Optional[float]
    drop_collinear: Optional[bool]
    largest_only: Optional[bool]
    fill_from: Optional[Sequence[Tuple[int, str]]]
# end keywords
