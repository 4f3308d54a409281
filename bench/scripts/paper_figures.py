"""Draws the paper's Figures 9, 11 and 12 from the measured rows, and Figures 2 and 10 from the tool's output, as compact SVG."""
import math
import os
import re

from chart import Axis, Names, Panel, save
from paper_tables import PRINTED, SWEEP_LINE
from results import ratio


def panel(title, label, rows, methods, key, spacing, x_of):
    """A panel of seconds against the quantity that bounds them, with a line for each method."""
    made = Panel(title, Axis(label, base=10), Axis("seconds", base=10))
    for method, name in methods:
        made.line(name, sorted((x_of(rows.engine(model, spacing).figures), rows.seconds(model, method, key, spacing))
                               for model in rows.models
                               if rows.engine(model, spacing) is not None and rows.seconds(model, method, key, spacing)))
    return made


def figure_9(rows, folder):
    methods = [("trivial", "Park (trivial)"), ("Tata", "Tata"), ("Slic3r", "Slic3r"), (PRINTED, "incremental, as printed")]
    uniform = panel("uniform slicing", "n + k + m", rows, methods + [("Huang", "Huang"), ("engine", "engine, 1 thread")],
                    "slicing_s", "uniform", lambda f: f["n"] + f["k"] + f["m"])
    adaptive = panel("adaptive slicing", "n log k + k + m", rows,
                     methods + [("sort-first", "sort first"), ("engine", "engine, 1 thread")], "slicing_s", "adaptive",
                     lambda f: f["n"] * math.log2(f["k"]) + f["k"] + f["m"])
    save(os.path.join(folder, "paper_figure_9.svg"), [uniform, adaptive], 500, 320)
    return "paper_figure_9.svg"


def figure_11(rows, folder):
    methods = [("Huang+trivial", "trivial"), (SWEEP_LINE, "Park (sweep line)"), ("Slic3r", "Slic3r"),
               (PRINTED, "hashed, as printed"), ("engine", "engine, 1 thread")]
    contours = panel("contours", "m", rows, methods, "contours_s", "uniform", lambda f: f["m"])
    save(os.path.join(folder, "paper_figure_11.svg"), [contours], 560, 320)
    return "paper_figure_11.svg"


def figure_12(rows, folder):
    totals = Panel("total time relative to others, 1 thread", Names([model.name for model in rows.models]), Axis("%", base=10))
    shares = [("as printed / Slic3r's way", lambda m: ratio(rows.seconds(m, PRINTED, "total_s"), rows.seconds(m, "Slic3r", "total_s"))),
              ("engine / Slic3r's way", lambda m: ratio(rows.seconds(m, "engine", "total_s"), rows.seconds(m, "Slic3r", "total_s"))),
              ("engine / as printed", lambda m: ratio(rows.seconds(m, "engine", "total_s"), rows.seconds(m, PRINTED, "total_s"))),
              ("engine / Park", lambda m: ratio(rows.seconds(m, "engine", "total_s"), rows.park_total(m)))]
    for label, share in shares:
        heights = [(place, share(model)) for place, model in enumerate(rows.models)]
        totals.bars(label, [(place, 100 * height) for place, height in heights if height])
    save(os.path.join(folder, "paper_figure_12.svg"), [totals], 820, 320)
    return "paper_figure_12.svg"


def compact_layers(svg):
    """Reduces a layered SVG of the tool to a picture: one path a layer, and no more points than the eye can see."""
    head = re.search(r'<svg [^>]*?( width="[^"]*" height="[^"]*" viewBox="[^"]*")', svg).group(1)
    background = re.search(r"<rect [^>]*>", svg).group(0)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg"{head}>', background]
    for fill, layer in re.findall(r'<g [^>]*fill="([^"]*)"[^>]*>(.*?)</g>', svg, re.DOTALL):
        outlines = "".join(outline(points) for points in re.findall(r'<polygon [^>]*points="([^"]*)"', layer))
        parts.append(f'<path fill="{fill}" transform="scale(.1,-.1)" d="{outlines}"/>')
    return "\n".join(parts + ["</svg>"]) + "\n"


def outline(points):
    """A closed subpath in relative steps of a tenth of a millimetre. Skips points closer than half a millimetre to the last."""
    tenths = [tuple(round(10 * float(value)) for value in point.split(",")) for point in points.split()]
    (x, y), rest = tenths[0], tenths[1:]
    start = f"M{x},{y}l"
    steps = ""
    for next_x, next_y in rest:
        if max(abs(next_x - x), abs(next_y - y)) >= 5:
            steps += f" {next_x - x},{next_y - y}"
            x, y = next_x, next_y
    return (start + steps[1:]).replace(" -", "-").replace(",-", "-") + "z" if steps else ""
