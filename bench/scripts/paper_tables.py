"""The paper's Tables 1 to 4, its figures beside the measured ones; the bars; and the other results of its section 5."""
import math
import statistics

from paper_models import MODELS
from results import fitted_exponent, markdown_table, ratio

PRINTED = "incremental+hashed+rays"
SWEEP_LINE = "Huang+sweep-line+rays"
BY_NAME = {model.name: model for model in MODELS}


class Rows:
    def __init__(self, rows, threads):
        self.threads = threads
        self._rows = {(row.model, row.spacing, row.method, row.threads): row for row in rows}
        self.models = [model for model in MODELS if (model.name, "uniform", "engine", threads[0]) in self._rows]

    def get(self, model, method, spacing="uniform", threads=1):
        return self._rows.get((model.name, spacing, method, threads))

    def engine(self, model, spacing="uniform", threads=1):
        return self.get(model, "engine", spacing, threads)

    def seconds(self, model, method, key, spacing="uniform", threads=1):
        row = self.get(model, method, spacing, threads)
        return row.seconds(key) if row else None

    def cell(self, model, method, key, spacing="uniform", threads=1):
        """A time, or the reason why there is none."""
        row = self.get(model, method, spacing, threads)
        if row is None:
            return "-"
        found = row.seconds(key)
        if found is None:
            return row.missing
        return shown(found) + (remark(row) if key in ("contours_s", "total_s") else "")

    def park_total(self, model):
        slicing = self.seconds(model, "trivial", "slicing_s")
        contours = self.seconds(model, SWEEP_LINE, "contours_s")
        return None if slicing is None or contours is None else slicing + contours


    def printed_with_sense(self, model):
        parts = [self.seconds(model, PRINTED, key) for key in ("total_s", "sense_s")]
        return None if None in parts else sum(parts)


def shown(seconds):
    return "-" if seconds is None else f"{seconds:.3g}" if seconds < 100 else f"{seconds:.0f}"


def remark(row):
    """How its answer differs from the engine's."""
    planes, contours = row.figures.get("planes_apart"), row.figures.get("contours_apart")
    if row.method.startswith("LDNI"):
        return ""
    if planes:
        return f" ({planes} planes differ)"
    return f" ({contours} contours differ)" if contours else ""


def name_of(rows, model):
    return model.name + (" (stand-in)" if model.recipe is not None and rows.engine(model).figures.get("stand_in") else "")


def table_1(rows):
    lines = []
    for model in rows.models:
        for spacing, k, m in (("uniform", model.k, model.m), ("adaptive", model.k_random, model.m_random)):
            engine = rows.engine(model, spacing)
            if engine is not None:
                figures = engine.figures
                lines.append([name_of(rows, model), spacing, f"{model.n:,}", f"{k:,}", f"{m:,}", f"{figures['n']:,}",
                              f"{figures['k']:,}", f"{figures['m']:,}", f"{figures['contours']:,}"])
    return markdown_table(["model", "spacing", "n, paper", "k", "m", "n, here", "k", "m", "contours"], lines)


def table_2(rows, spacing):
    uniform = spacing == "uniform"
    methods = ["trivial", "Tata"] + (["Huang"] if uniform else []) + ["sort-first", "presorted", "Slic3r", PRINTED]
    heads = ["model"] + (["Park, paper", "Slic3r, paper", "proposed, paper"] if uniform else ["Park, paper", "proposed, paper"])
    heads += ["trivial (Park)"] + methods[1:-1] + ["incremental, as printed"]
    heads += [f"engine, {count} thr." for count in rows.threads] + ["M items/s, engine"]
    lines = []
    for model in rows.models:
        engine = rows.engine(model, spacing)
        if engine is None:
            continue
        items = sum(engine.figures[key] for key in "nkm")
        lines.append([name_of(rows, model)] + [shown(s) for s in (model.slicing[:3] if uniform else model.slicing[3:])] +
                     [rows.cell(model, method, "slicing_s", spacing) for method in methods] +
                     [rows.cell(model, "engine", "slicing_s", spacing, count) for count in rows.threads] +
                     [f"{items / engine.seconds('slicing_s') / 1e6:.0f}"])
    return markdown_table(heads, lines)


def table_3(rows):
    methods = ["Huang+trivial", SWEEP_LINE, "Slic3r", PRINTED]
    heads = (["model", "trivial, paper", "Park, paper", "Slic3r, paper", "proposed, paper", "trivial", "sweep line (Park)",
              "Slic3r", "hashed, as printed", "sense by rays"] + [f"engine, {count} thr." for count in rows.threads])
    lines = [[name_of(rows, model)] + [shown(s) for s in model.contours] +
             [rows.cell(model, method, "contours_s") for method in methods] + [rows.cell(model, PRINTED, "sense_s")] +
             [rows.cell(model, "engine", "contours_s", threads=count) for count in rows.threads] for model in rows.models]
    return markdown_table(heads, lines)


def table_4(rows):
    methods = ["McMains", "topological", "LDNI, 0.1 mm"]
    heads = (["model", "Park, paper", "Slic3r, paper", "proposed, paper", "Park", "Slic3r", "as printed", "and sense by rays"] + methods +
             [f"engine, {count} thr." for count in rows.threads] + ["paper's share of contours", "engine's"])
    lines = []
    for model in rows.models:
        engine = rows.engine(model)
        contours, total = engine.seconds("contours_s"), engine.seconds("total_s")
        lines.append([name_of(rows, model)] + [shown(s) for s in model.totals()] + [shown(rows.park_total(model))] +
                     [rows.cell(model, method, "total_s") for method in ("Slic3r", PRINTED)] +
                     [shown(rows.printed_with_sense(model))] + [rows.cell(model, method, "total_s") for method in methods] +
                     [rows.cell(model, "engine", "total_s", threads=count) for count in rows.threads] +
                     [f"{100 * model.contours[3] / model.totals()[2]:.0f} %", f"{100 * contours / total:.0f} %"])
    return markdown_table(heads, lines)


def peers(rows, names):
    heads = ["model", "engine, 1 thr.", f"engine, {rows.threads[-1]} thr."] + names
    lines = []
    for model in rows.models:
        cells = []
        for peer in names:
            row = rows.get(model, "peer " + peer)
            cells.append("-" if row is None else row.missing or peer_cell(row.figures))
        lines.append([name_of(rows, model)] +
                     [rows.cell(model, "engine", "total_s", threads=count) for count in (1, rows.threads[-1])] + cells)
    return markdown_table(heads, lines)


def peer_time(figures):
    """The time from the soup in memory to contours; for a slicing program, the time of its slicing stage."""
    return statistics.median(figures["total_s"] if "build_s" in figures else figures["slice_s"])


def peer_cell(figures):
    apart = figures.get("contours_apart")
    return shown(peer_time(figures)) + (f" ({apart} contours differ)" if apart else "")


def exponents(rows):
    """Exponents fitted by least squares over the models, time against the quantity that bounds it."""
    def fit(x_of, seconds_of, spacing):
        points = [(x_of(rows.engine(model, spacing).figures), seconds_of(model)) for model in rows.models
                  if rows.engine(model, spacing) is not None and seconds_of(model)]
        return f"{fitted_exponent(points):.2f}" if len(points) > 1 else "-"

    uniform = ("n + k + m, uniform, slicing", lambda f: f["n"] + f["k"] + f["m"], "uniform", "slicing_s")
    adaptive = ("n log2 k + k + m, adaptive, slicing", lambda f: f["n"] * math.log2(f["k"]) + f["k"] + f["m"], "adaptive",
                "slicing_s")
    joined = ("m, uniform, contours", lambda f: f["m"], "uniform", "contours_s")
    lines = []
    for what, x_of, spacing, key in (uniform, adaptive, joined):
        lines.append([what] + [fit(x_of, lambda model, m=method: rows.seconds(model, m, key, spacing), spacing)
                               for method in (PRINTED, "engine")])
    return markdown_table(["seconds against", "as printed", "engine, 1 thr."], lines)


def bars(rows):
    """Every bar of these experiments for every model: the ratio, the bar, and whether it is met."""
    lines = []

    def hold(what, least, wanted):
        for model in rows.models:
            found = wanted(model)
            if found is not None:
                lines.append([what, model.name, f"{found:.{2 if found < 10 else 1}f}", f"at least {least(model)}",
                              "met" if found >= least(model) else "NOT met"])

    def over_engine(method):
        return lambda model: ratio(rows.seconds(model, method, "total_s"), rows.seconds(model, "engine", "total_s"))

    def least_of_printed(model):
        return 40 if model.name in small else 5 if model.name in tall else 20

    small, tall = ("liver", "femur"), ("warrior", "robot")
    hold("as printed, without sense / engine", least_of_printed, over_engine(PRINTED))
    hold("as printed, with sense by rays / engine", least_of_printed,
         lambda m: ratio(rows.printed_with_sense(m), rows.seconds(m, "engine", "total_s")))
    hold("topological / engine", lambda m: 2, over_engine("topological"))
    hold("Slic3r's way / engine", lambda m: 15 if m.name in small else 8, over_engine("Slic3r"))
    for peer in ("cgal", "vtk"):
        def peer_over_engine(model, peer=peer):
            row = rows.get(model, "peer " + peer)
            return None if row is None or row.figures is None else ratio(peer_time(row.figures),
                                                                        rows.seconds(model, "engine", "total_s"))
        hold(f"{peer} / engine", lambda m: 50 if m.name in small else 15, peer_over_engine)
    if 2 in rows.threads:
        hold("engine, 1 thread / 2 threads", lambda m: 1.8,
             lambda model: ratio(rows.seconds(model, "engine", "total_s"), rows.seconds(model, "engine", "total_s", threads=2)))
        for model in rows.models:
            if model.name == "skull":
                found = rows.seconds(model, "engine", "total_s", threads=2)
                lines.append(["engine on 2 threads, s", model.name, shown(found), "at most 2.5",
                              "met" if found <= 2.5 else "NOT met"])
    return markdown_table(["ratio", "model", "figure", "bar", ""], lines)
