"""Charts as compact SVG: one element for each series, coordinates with one decimal."""
import math
from typing import NamedTuple

COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf",
           "#aec7e8", "#ffbb78", "#98df8a", "#ff9896", "#c5b0d5", "#c49c94")
LEFT, RIGHT, TOP, BOTTOM = 58, 16, 30, 48  # px around a panel's area
LEGEND_LINE = 14


def escaped(text):
    return str(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def text(x, y, what, size=11, anchor="middle", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="#000"{more}>{escaped(what)}</text>'


def path(points):
    return "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in points)


class Axis:
    """Maps a value to 0 to 1 between the axis' two ends. `base` makes it logarithmic, with ticks at the powers of the base."""

    def __init__(self, label, base=None, ticks=None, limits=None):
        self.label, self.base, self.fixed_ticks, self.limits = label, base, ticks, limits
        self.low, self.high = 0.0, 1.0

    def scaled(self, value):
        return math.log(value, self.base) if self.base else value

    def fit(self, values):
        low, high = self.limits or (min(values, default=1), max(values, default=1))
        low, high = self.scaled(low), self.scaled(high)
        margin = 0 if self.limits else 0.05 * (high - low) or 0.5
        self.low, self.high = low - margin, high + margin
        if self.base and len(self.ticks()) < 2:
            self.low, self.high = math.floor(self.low), math.ceil(self.high)

    def place(self, value):
        return (self.scaled(value) - self.low) / (self.high - self.low)

    def ticks(self):
        if self.fixed_ticks:
            return self.fixed_ticks
        if self.base:
            powers = range(math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9) + 1)
            return [self.base ** power for power in powers]
        rough = (self.high - self.low) / 6
        unit = 10 ** math.floor(math.log10(rough))
        step = next(unit * factor for factor in (1, 2, 5, 10) if unit * factor >= rough)
        return [step * i for i in range(math.ceil(self.low / step), math.floor(self.high / step) + 1)]


class Series(NamedTuple):
    label: str
    points: list
    kind: str  # line, dotted, bars


class Panel:
    """Series over two axes, with a legend below."""

    def __init__(self, title, x, y):
        self.title, self.x, self.y, self.series = title, x, y, []

    def line(self, label, points):
        if points:
            self.series.append(Series(label, points, "line"))

    def dotted(self, label, points):
        self.series.append(Series(label, points, "dotted"))

    def bars(self, label, heights):
        """Adds a bar from the lower end of the y axis for each (x, height), next to the bars of other series."""
        self.series.append(Series(label, heights, "bars"))

    def legend_lines(self):
        return (len(self.series) + 1) // 2

    def draw(self, left, width, height):
        """The SVG elements of a panel, `left` px from the left edge, with a plot area of this height."""
        points = [point for series in self.series for point in series.points]
        self.x.fit([x for x, _ in points])
        self.y.fit([y for _, y in points])
        bars = [series for series in self.series if series.kind == "bars"]
        if bars and self.y.base:  # room below the top of the lowest bar
            self.y.low = math.floor(self.y.low)
        self.left, self.width, self.height, self.bottom = left + LEFT, width - LEFT - RIGHT, height, TOP + height
        parts = [text(self.left + self.width / 2, TOP - 10, self.title, 13)] + self.frame()
        for number, series in enumerate(self.series):
            colour = "#000" if series.kind == "dotted" else COLOURS[number % len(COLOURS)]
            drawn = self.draw_bars(series, colour, bars.index(series), len(bars)) if series in bars else self.draw_line(series, colour)
            parts += [drawn, self.legend_entry(series, colour, number)]
        return parts

    def legend_entry(self, series, colour, number):
        row, column = divmod(number, 2)
        x, y = self.left + column * self.width / 2, self.bottom + BOTTOM + row * LEGEND_LINE
        dash = ' stroke-dasharray="2"' if series.kind == "dotted" else ""
        return (f'<path d="M{x:.1f},{y - 4:.1f}h16" stroke="{colour}" stroke-width="2"{dash}/>' +
                text(x + 22, y, series.label, 10, "start"))

    def at(self, x, y):
        return self.left + self.width * self.x.place(x), TOP + self.height * (1 - self.y.place(y))

    def frame(self):
        x_ticks = [(self.left + self.width * self.x.place(tick), tick) for tick in self.x.ticks()]
        y_ticks = [(TOP + self.height * (1 - self.y.place(tick)), tick) for tick in self.y.ticks()]
        grid = "".join(f"M{x:.1f},{TOP}v{self.height}" for x, _ in x_ticks)
        grid += "".join(f"M{self.left},{y:.1f}h{self.width:.1f}" for y, _ in y_ticks)
        return [
            f'<path d="{grid}" stroke="#ddd"/>',
            f'<path d="M{self.left},{TOP}h{self.width:.1f}v{self.height}h{-self.width:.1f}z" stroke="#000"/>',
            "".join(text(x, self.bottom + 14, tick_label(tick, self.x), 10) for x, tick in x_ticks),
            "".join(text(self.left - 5, y + 4, tick_label(tick, self.y), 10, "end") for y, tick in y_ticks),
            text(self.left + self.width / 2, self.bottom + 30, self.x.label),
            text(0, 0, self.y.label, more=f' transform="translate({self.left - 42:.1f},{TOP + self.height / 2:.1f})rotate(-90)"'),
        ]

    def draw_line(self, series, colour):
        places = [self.at(x, y) for x, y in series.points]
        if series.kind == "dotted":
            return f'<path d="{path(places)}" stroke="#000" stroke-dasharray="2"/>'
        dots = "".join(f"M{x:.1f},{y:.1f}h0" for x, y in places)
        return (f'<g stroke="{colour}"><path d="{path(places)}" stroke-width="1.5"/>'
                f'<path d="{dots}" stroke-width="5" stroke-linecap="round"/></g>')

    def draw_bars(self, series, colour, nth, bars):
        width = 0.8 * self.width / (self.x.high - self.x.low) / bars
        boxes = "".join(f"M{x + (nth - bars / 2) * width:.1f},{self.bottom}V{y:.1f}h{width:.1f}V{self.bottom}z"
                        for x, y in (self.at(*point) for point in series.points))
        return f'<path d="{boxes}" fill="{colour}"/>'


class Names(Axis):
    """An axis with a name at each of 0, 1, 2 and so on."""

    def __init__(self, names):
        super().__init__("", ticks=list(range(len(names))), limits=(-0.6, len(names) - 0.4))
        self.names = names


def tick_label(tick, axis):
    if isinstance(axis, Names):
        return axis.names[tick]
    return f"{tick:g}" if 1e-3 <= abs(tick) < 1e4 or tick == 0 else f"1e{math.log10(tick):.0f}"


def save(path_of_file, panels, width, height, heading=()):
    """Writes panels side by side, each of this width with a plot area of this height. `heading` holds the lines above them."""
    above = 14 * len(heading)
    whole_width = width * len(panels)
    whole_height = above + TOP + height + BOTTOM + LEGEND_LINE * max(panel.legend_lines() for panel in panels)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{whole_width}" height="{whole_height}" '
             f'viewBox="0 0 {whole_width} {whole_height}" font-family="sans-serif">',
             f'<rect width="{whole_width}" height="{whole_height}" fill="#fff"/>']
    parts += [text(whole_width / 2, 14 * (line + 1), what, 10) for line, what in enumerate(heading)]
    parts.append(f'<g fill="none" transform="translate(0,{above})">')
    for number, panel in enumerate(panels):
        parts += panel.draw(number * width, width, height)
    with open(path_of_file, "w", encoding="utf-8") as file:
        file.write("\n".join(parts + ["</g>", "</svg>", ""]))
