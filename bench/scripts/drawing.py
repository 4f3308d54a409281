"""Charts as SVG, by matplotlib."""
from typing import NamedTuple

import matplotlib
from matplotlib import pyplot
from matplotlib.ticker import MaxNLocator

matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "lamella", "font.size": 9, "axes.grid": True, "grid.color": "#ddd",
                            "legend.fontsize": 8, "axes.prop_cycle": pyplot.cycler(color=pyplot.get_cmap("tab20").colors)})


class Panel(NamedTuple):
    title: str
    x: str
    y: str
    lines: dict  # points by label
    ideal: tuple = ()
    log: tuple = (None, None)  # the bases of both axes
    top: float = 0             # 0: the y axis fits the points; otherwise it reaches from 0 to here
    bars: bool = False         # beside each other instead of lines; x counts the names
    names: tuple = ()


def draw_panel(axes, panel):
    for number, (label, points) in enumerate((label, points) for label, points in panel.lines.items() if points):
        x, y = zip(*points)
        if panel.bars:
            width = 0.8 / len(panel.lines)
            axes.bar([place - 0.4 + (number + 0.5) * width for place in x], y, width, label=label)
        else:
            axes.plot(x, y, "o-", markersize=3, linewidth=1, label=label)
    if panel.ideal:
        axes.plot(*zip(*panel.ideal), "k:", label="ideal")
    for base, scale in zip(panel.log, (axes.set_xscale, axes.set_yscale)):
        if base:
            scale("log", base=base)
    if not panel.log[0]:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if panel.top:
        axes.set_ylim(0, panel.top)
    if panel.names:
        axes.set_xticks(range(len(panel.names)), panel.names)
    axes.set(title=panel.title, xlabel=panel.x, ylabel=panel.y)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncol=2, frameon=False)


def save(path, panels, width=4.2, heading=""):
    """Panels side by side, each so many inches wide."""
    figure, axes = pyplot.subplots(1, len(panels), figsize=(width * len(panels), 4.6), squeeze=False, layout="constrained")
    for each, panel in zip(axes[0], panels):
        draw_panel(each, panel)
    figure.suptitle(heading, fontsize=8)
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})
    pyplot.close(figure)
