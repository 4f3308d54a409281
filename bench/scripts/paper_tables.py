"""The paper's Tables 1 to 4, its figures beside the measured ones; the bars; and the other results of its section 5."""
import math
import statistics

from paper_models import MODELS
from readme_table import markdown_table
from results import fitted_exponent, ratio

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


def paper_columns(names, figures):
    """Columns are heads and functions of the model. These hold the paper's own figures."""
    return [(f"{name}, paper", lambda model, i=i: shown(figures(model)[i])) for i, name in enumerate(names)]


def columns(rows, key, methods, spacing="uniform"):
    """Measured times, by method."""
    return [(head, lambda model, method=method: rows.cell(model, method, key, spacing)) for head, method in methods.items()]


def engine_columns(rows, key, spacing="uniform", counts=None):
    return [(f"engine, {count} thr.", lambda model, count=count: rows.cell(model, "engine", key, spacing, count))
            for count in counts or rows.threads]


def model_table(rows, *groups, spacing="uniform"):
    """A row for each model that was measured."""
    all_columns = [("model", lambda model: name_of(rows, model)), *(column for group in groups for column in group)]
    return markdown_table([head for head, _ in all_columns],
                          [[cell(model) for _, cell in all_columns] for model in rows.models if rows.engine(model, spacing)])


def table_1(rows):
    lines = []
    for model in rows.models:
        for spacing, k, m in (("uniform", model.k, model.m), ("adaptive", model.k_random, model.m_random)):
            engine = rows.engine(model, spacing)
            if engine is not None:
                here = [engine.figures[key] for key in ("n", "k", "m", "contours")]
                lines.append([name_of(rows, model), spacing] + [f"{count:,}" for count in (model.n, k, m, *here)])
    return markdown_table(["model", "spacing", "n, paper", "k", "m", "n, here", "k", "m", "contours"], lines)


def table_2(rows, spacing):
    def rate(model):
        engine = rows.engine(model, spacing)
        return f"{sum(engine.figures[key] for key in 'nkm') / engine.seconds('slicing_s') / 1e6:.0f}"

    uniform = spacing == "uniform"
    paper = (paper_columns(("Park", "Slic3r", "proposed"), lambda model: model.slicing) if uniform else
             paper_columns(("Park", "proposed"), lambda model: model.slicing[3:]))
    same = ["Tata"] + (["Huang"] if uniform else []) + ["sort-first", "presorted", "Slic3r"]
    methods = {"trivial (Park)": "trivial", **{name: name for name in same}, "incremental, as printed": PRINTED}
    return model_table(rows, paper, columns(rows, "slicing_s", methods, spacing), engine_columns(rows, "slicing_s", spacing),
                       [("M items/s, engine", rate)], spacing=spacing)


def table_3(rows):
    methods = {"trivial": "Huang+trivial", "sweep line (Park)": SWEEP_LINE, "Slic3r": "Slic3r", "hashed, as printed": PRINTED}
    return model_table(rows, paper_columns(("trivial", "Park", "Slic3r", "proposed"), lambda model: model.contours),
                       columns(rows, "contours_s", methods), columns(rows, "sense_s", {"sense by rays": PRINTED}),
                       engine_columns(rows, "contours_s"))


def table_4(rows):
    def share(model):
        engine = rows.engine(model)
        return f"{100 * engine.seconds('contours_s') / engine.seconds('total_s'):.0f} %"

    methods = {name: name for name in ("McMains", "topological", "LDNI, 0.1 mm")}
    return model_table(rows, paper_columns(("Park", "Slic3r", "proposed"), lambda model: model.totals()),
                       [("Park", lambda model: shown(rows.park_total(model)))],
                       columns(rows, "total_s", {"Slic3r": "Slic3r", "as printed": PRINTED}),
                       [("and sense by rays", lambda model: shown(rows.printed_with_sense(model)))],
                       columns(rows, "total_s", methods), engine_columns(rows, "total_s"),
                       [("paper's share of contours", lambda model: f"{100 * model.contours[3] / model.totals()[2]:.0f} %"),
                        ("engine's", share)])


def peers(rows, names):
    def cell(model, peer):
        row = rows.get(model, "peer " + peer)
        return "-" if row is None else row.missing or peer_cell(row.figures)

    return model_table(rows, engine_columns(rows, "total_s", counts=(1, rows.threads[-1])),
                       [(peer, lambda model, peer=peer: cell(model, peer)) for peer in names])


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

    bounds = (("n + k + m, uniform, slicing", lambda f: f["n"] + f["k"] + f["m"], "uniform", "slicing_s"),
              ("n log2 k + k + m, adaptive, slicing", lambda f: f["n"] * math.log2(f["k"]) + f["k"] + f["m"], "adaptive", "slicing_s"),
              ("m, uniform, contours", lambda f: f["m"], "uniform", "contours_s"))
    lines = [[what] + [fit(x_of, lambda model, m=method, key=key: rows.seconds(model, m, key, spacing), spacing)
                       for method in (PRINTED, "engine")] for what, x_of, spacing, key in bounds]
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
