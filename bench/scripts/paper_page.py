"""The page of the paper's experiments: its Tables 1 to 4, its figures beside the measured ones, the bars, and its section 5."""
import math
import os
import sys

from drawing import Panel, save
from paper_models import MODELS
from readme_table import Bars, fitted_exponent, machine_table, markdown_table, ratio

PRINTED = "incremental+hashed+rays"
SWEEP_LINE = "Huang+sweep-line+rays"
HEAD = """# The paper's experiments, measured here

`bench/paper.sh` made this page. Times are in seconds, from the soup in memory to contours, quantising included, on one
thread unless stated. They are medians of 5 runs if a run takes less than 2 s, of 3 if less than 10 s, else of 1. Every answer
was compared with the engine's, plane by plane and contour by contour, before its time was printed. Where it differs, the
difference stands beside the time. Columns named *paper* are the paper's own figures, from another machine and, for models
marked as stand-ins, another mesh. Do not divide them by the figures beside them."""
PARK = """Park is the sum of the trivial slicing and the sweep line, measured separately. The printed algorithms do not orient contours;
the engine orients and nests them. For that, the paper names point-in-polygon rays as the next step (*sense by rays*)."""
PEERS = """Programs that a user might choose instead; see [bench/peers](../peers/README.md). CGAL and VTK: from the soup in memory
to contours, one thread. Slicing programs: the time that they print for their slicing stage."""


class Rows:
    def __init__(self, rows, threads):
        self.threads = threads
        self._rows = {(row.model, row.spacing, row.method, row.threads): row for row in rows}
        self.models = [model for model in MODELS if (model.name, "uniform", "engine", threads[0]) in self._rows]

    def get(self, model, method, spacing="uniform", threads=1):
        return self._rows.get((model.name, spacing, method, threads))

    def figures(self, model, spacing="uniform"):
        """The engine's."""
        return self.get(model, "engine", spacing).figures

    def seconds(self, model, method, key="total_s", spacing="uniform", threads=1):
        row = self.get(model, method, spacing, threads)
        return row.seconds(key) if row else None

    def sum(self, model, *parts):
        """Of pairs of method and key; None if one was not measured."""
        seconds = [self.seconds(model, method, key) for method, key in parts]
        return None if None in seconds else sum(seconds)

    def park(self, model):
        return self.sum(model, ("trivial", "slicing_s"), (SWEEP_LINE, "contours_s"))

    def printed_with_sense(self, model):
        return self.sum(model, (PRINTED, "total_s"), (PRINTED, "sense_s"))

    def cell(self, model, method, key, spacing="uniform", threads=1):
        """A time, or the reason why there is none; and how its answer differs from the engine's."""
        row = self.get(model, method, spacing, threads)
        if row is None or row.seconds(key) is None:
            return row.missing if row else "-"
        planes, contours = row.figures["planes_apart"], row.figures.get("contours_apart")
        remark = f" ({planes} planes differ)" if planes else f" ({contours} contours differ)" if contours else ""
        return shown(row.seconds(key)) + (remark if key in ("contours_s", "total_s") else "")


def shown(seconds):
    return "-" if seconds is None else f"{seconds:.3g}" if seconds < 100 else f"{seconds:.0f}"


def name_of(rows, model):
    return model.name + (" (stand-in)" if rows.figures(model)["stand_in"] else "")


def paper_columns(names, figures):
    """Columns are heads and functions of the model. These hold the paper's own figures."""
    return [(f"{name}, paper", lambda model, i=i: shown(figures(model)[i])) for i, name in enumerate(names)]


def columns(rows, key, methods, spacing="uniform"):
    """Measured times, by method."""
    return [(head, lambda model, method=method: rows.cell(model, method, key, spacing)) for head, method in methods.items()]


def engine_columns(rows, key, spacing="uniform", counts=None):
    return [(f"engine, {count} thr.", lambda model, count=count: rows.cell(model, "engine", key, spacing, count))
            for count in counts or rows.threads]


def model_table(rows, *groups):
    """A row for each model that was measured."""
    all_columns = [("model", lambda model: name_of(rows, model)), *(column for group in groups for column in group)]
    return markdown_table([head for head, _ in all_columns], [[cell(model) for _, cell in all_columns] for model in rows.models])


def table_1(rows):
    lines = []
    for model in rows.models:
        for spacing, k, m in (("uniform", model.k, model.m), ("adaptive", model.k_random, model.m_random)):
            here = [rows.figures(model, spacing)[key] for key in ("n", "k", "m", "contours")]
            lines.append([name_of(rows, model), spacing, *(f"{count:,}" for count in (model.n, k, m, *here))])
    return markdown_table(["model", "spacing", "n, paper", "k", "m", "n, here", "k", "m", "contours"], lines)


def table_2(rows, spacing):
    def rate(model):
        figures = rows.figures(model, spacing)
        return f"{sum(figures[key] for key in 'nkm') / rows.seconds(model, 'engine', 'slicing_s', spacing) / 1e6:.0f}"

    uniform = spacing == "uniform"
    paper = (paper_columns(("Park", "Slic3r", "proposed"), lambda model: model.slicing) if uniform else
             paper_columns(("Park", "proposed"), lambda model: model.slicing[3:]))
    same = ["Tata", *(["Huang"] if uniform else []), "sort-first", "presorted", "Slic3r"]
    methods = {"trivial (Park)": "trivial", **{name: name for name in same}, "incremental, as printed": PRINTED}
    return model_table(rows, paper, columns(rows, "slicing_s", methods, spacing), engine_columns(rows, "slicing_s", spacing),
                       [("M items/s, engine", rate)])


def table_3(rows):
    methods = {"trivial": "Huang+trivial", "sweep line (Park)": SWEEP_LINE, "Slic3r": "Slic3r", "hashed, as printed": PRINTED}
    return model_table(rows, paper_columns(("trivial", "Park", "Slic3r", "proposed"), lambda model: model.contours),
                       columns(rows, "contours_s", methods), columns(rows, "sense_s", {"sense by rays": PRINTED}),
                       engine_columns(rows, "contours_s"))


def table_4(rows):
    def share(model):
        return f"{100 * rows.seconds(model, 'engine', 'contours_s') / rows.seconds(model, 'engine'):.0f} %"

    methods = {name: name for name in ("McMains", "topological")}
    return model_table(rows, paper_columns(("Park", "Slic3r", "proposed"), lambda model: model.totals()),
                       [("Park", lambda model: shown(rows.park(model)))],
                       columns(rows, "total_s", {"Slic3r": "Slic3r", "as printed": PRINTED}),
                       [("and sense by rays", lambda model: shown(rows.printed_with_sense(model)))],
                       columns(rows, "total_s", methods), engine_columns(rows, "total_s"),
                       [("paper's share of contours", lambda model: f"{100 * model.contours[3] / model.totals()[2]:.0f} %"),
                        ("engine's", share)])


def peer_seconds(rows, model, peer):
    """The time from the soup in memory to contours; for a slicing program, the time of its slicing stage."""
    row = rows.get(model, peer)
    return row.seconds("total_s" if "build_s" in (row.figures or {}) else "slice_s") if row else None


def peer_table(rows, names):
    def cell(model, peer):
        row, seconds = rows.get(model, peer), peer_seconds(rows, model, peer)
        if seconds is None:
            return row.missing if row else "-"
        apart = row.figures.get("contours_apart")
        return shown(seconds) + (f" ({apart} contours differ)" if apart else "")

    return model_table(rows, engine_columns(rows, "total_s", counts=(1, rows.threads[-1])),
                       [(peer, lambda model, peer=peer: cell(model, peer)) for peer in names])


# The quantities that bound times, by their names.
BOUNDS = {"n + k + m": lambda f: f["n"] + f["k"] + f["m"], "n log2 k + k + m": lambda f: f["n"] * math.log2(f["k"]) + f["k"] + f["m"],
          "m": lambda f: f["m"]}


def points_of(rows, bound, method, key, spacing="uniform"):
    """By model: the bound, and the method's time."""
    return sorted((BOUNDS[bound](rows.figures(model, spacing)), rows.seconds(model, method, key, spacing)) for model in rows.models
                  if rows.seconds(model, method, key, spacing))


def exponents(rows):
    """Fitted by least squares over the models, time against the quantity that bounds it."""
    def fitted(*what):
        found = fitted_exponent(points_of(rows, *what))
        return "-" if found is None else f"{found:.2f}"

    lines = [[f"{bound}, {spacing}, {key[:-2]}", *(fitted(bound, method, key, spacing) for method in (PRINTED, "engine"))]
             for bound, spacing, key in (("n + k + m", "uniform", "slicing_s"), ("n log2 k + k + m", "adaptive", "slicing_s"),
                                         ("m", "uniform", "contours_s"))]
    return markdown_table(["seconds against", "as printed", "engine, 1 thr."], lines)


def bars(rows):
    """Every bar of these experiments for every model."""
    small, tall = ("liver", "femur"), ("warrior", "robot")
    table = Bars()

    def hold(what, bar_of, wanted):
        for model in rows.models:
            if wanted(model):
                table.hold(f"{what}: {model.name}", ratio(wanted(model), rows.seconds(model, "engine")), "at least", bar_of(model))

    def of_printed(model):
        return 40 if model.name in small else 5 if model.name in tall else 20

    hold("as printed, without sense / engine", of_printed, lambda model: rows.seconds(model, PRINTED))
    hold("as printed, with sense by rays / engine", of_printed, rows.printed_with_sense)
    hold("topological / engine", lambda _: 2, lambda model: rows.seconds(model, "topological"))
    hold("Slic3r's way / engine", lambda model: 15 if model.name in small else 8, lambda model: rows.seconds(model, "Slic3r"))
    for peer in ("cgal", "vtk"):
        hold(f"{peer} / engine", lambda model: 50 if model.name in small else 15, lambda model, peer=peer: peer_seconds(rows, model, peer))
    for model in rows.models if 2 in rows.threads else ():
        two = rows.seconds(model, "engine", threads=2)
        table.hold(f"engine, 1 thread / 2 threads: {model.name}", ratio(rows.seconds(model, "engine"), two), "at least", 1.8)
        if model.name == "skull":
            table.hold("engine on 2 threads, skull", two, "at most", 2.5, "s")
    return table.table()


def draw_figures(rows, folder):
    """The paper's Figures 9, 11 and 12. Their names."""
    def panel(title, bound, key, spacing, *methods):
        named = {PRINTED: "as printed", "engine": "engine, 1 thread", SWEEP_LINE: "Park (sweep line)", "Huang+trivial": "trivial"}
        lines = {named.get(method, method): points_of(rows, bound, method, key, spacing) for method in methods}
        return Panel(title, bound, "seconds", lines, log=(10, 10))

    save(os.path.join(folder, "paper_figure_9.svg"), [
        panel("uniform slicing", "n + k + m", "slicing_s", "uniform", "trivial", "Tata", "Slic3r", PRINTED, "Huang", "engine"),
        panel("adaptive slicing", "n log2 k + k + m", "slicing_s", "adaptive", "trivial", "Tata", "Slic3r", PRINTED, "sort-first", "engine")])
    save(os.path.join(folder, "paper_figure_11.svg"), [
        panel("contours", "m", "contours_s", "uniform", "Huang+trivial", SWEEP_LINE, "Slic3r", PRINTED, "engine")])
    pairs = {"as printed / Slic3r's way": (PRINTED, "Slic3r"), "engine / Slic3r's way": ("engine", "Slic3r"),
             "engine / as printed": ("engine", PRINTED), "engine / Park": ("engine", None)}
    shares = {label: [(place, ratio(rows.seconds(model, above), rows.seconds(model, below) if below else rows.park(model)))
                      for place, model in enumerate(rows.models)] for label, (above, below) in pairs.items()}
    shares = {label: [(place, 100 * share) for place, share in points if share] for label, points in shares.items()}
    save(os.path.join(folder, "paper_figure_12.svg"), [Panel("total time relative to others, 1 thread", "", "%", shares, log=(None, 10),
                                                             bars=True, names=[model.name for model in rows.models])], 8)
    return [f"paper_figure_{number}.svg" for number in (9, 11, 12)]


def page(rows, told, peers, pictures):
    machine = machine_table(told.build, build="Release, mimalloc for all methods", limit=f"{told.limit} s",
                            command="`bench/paper.sh " + " ".join(sys.argv[3:]) + "`")
    return "\n\n".join([
        HEAD, machine,
        "## Table 1: models", table_1(rows),
        "## Table 2: slicing, uniform", table_2(rows, "uniform"),
        "## Table 2: slicing, adaptive (random spacing, 0.016 to 0.032 mm)", table_2(rows, "adaptive"),
        "## Table 3: contours, uniform", table_3(rows),
        "## Table 4: both, uniform", table_4(rows), PARK,
        "## Peers, uniform", PEERS, peer_table(rows, peers),
        "## Fitted exponents", exponents(rows),
        "## Bars", bars(rows),
        "## Figures", "\n".join(f"![{name}]({name})" for name in pictures)]) + "\n"
