"""Pictures of layers: inline SVG for notebooks, and matplotlib."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any, Dict, List, Tuple

import numpy as np

from ._layer import Role

if TYPE_CHECKING:
    from ._layer import Layer
    from ._result import Result

SIDE = 160
"""Width and height of a picture, pixels."""
MOST_POINTS = 4000
"""About so many are drawn."""
MOST_CONTOURS = 500
"""So many are drawn, those of most points."""


def layer_svg(layer: Layer) -> str:
    """A small picture, y upwards."""
    points = layer.points
    if len(points) == 0:
        return f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}"></svg>'
    low, high = points.min(axis=0), points.max(axis=0)
    scale = (SIDE - 4) / max(float((high - low).max()), 1e-300)
    step = -(-len(points) // MOST_POINTS)
    solid: List[str] = []
    lines: List[str] = []
    for role, path in _largest(layer):
        kept = path[::step] if len(path) > 3 * step else path
        drawn = np.column_stack((kept[:, 0] - low[0], high[1] - kept[:, 1])) * scale + 2
        text = "M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in drawn.tolist())
        (lines if role == Role.OPEN else solid).append(text if role == Role.OPEN else text + "z")
    width, height = (high - low) * scale + 4
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}">'
        f'<path d="{"".join(solid)}" fill="#9db8d2" fill-rule="evenodd" stroke="#20435f" stroke-width="0.7"/>'
        f'<path d="{"".join(lines)}" fill="none" stroke="#c03020"/></svg>'
    )


def _largest(layer: Layer) -> List[Tuple[Any, ...]]:
    """Role and points of the contours with most points, in their order."""
    paths = layer._paths()
    if len(paths) <= MOST_CONTOURS:
        return paths
    chosen = np.sort(np.argsort([-len(path) for _, path in paths], kind="stable")[:MOST_CONTOURS])
    return [paths[i] for i in chosen]


def result_html(result: Result) -> str:
    """A table of what there is, beside the layer of the largest area."""
    rows = {
        "layers": f"{len(result):,}",
        "contours": f"{len(result.contours):,}",
        "points": f"{len(result.points_grid):,}",
        "volume": f"{result.volume:,.6g} mm³",
    }
    picture = ""
    if len(result) > 0:
        largest = result[int(np.argmax(np.nan_to_num(result.areas)))]
        rows["z"] = f"{result[0].z:g} to {result[-1].z:g} mm"
        rows["shown"] = f"layer {largest.index}, z {largest.z:g} mm"
        picture = layer_svg(largest)
    cells = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in rows.items())
    return f'<div style="display:flex;gap:1em;align-items:center">{picture}<table>{cells}</table></div>'


def plot_layer(layer: Layer, ax: Any, style: Dict[str, Any]) -> Any:
    """Solid areas as one compound path, so that holes stay empty."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    if ax is None:
        import matplotlib.pyplot as plt

        axes = plt.gca()
    else:
        axes = ax
    closed = [path for role, path in layer._paths() if role in (Role.OUTER, Role.HOLE)]
    if closed:
        rings = [Path(np.vstack((path, path[:1])), closed=True) for path in closed]
        axes.add_patch(PathPatch(Path.make_compound_path(*rings), **{"linewidth": 0.8, "edgecolor": "black", **style}))
    for line in layer.polylines():
        axes.plot(line[:, 0], line[:, 1], color="red", linewidth=1)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    return axes
