// Layers combined with layers.
#include <deque>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "lamella/overlay.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

using Contours = py::array_t<std::int32_t, py::array::c_style>;

/// Sets as _combine.py leaves them: (what, first, last, grow, fill rule, part or None). What: a Result; a Result and a
/// layer's index; or arrays (n, 2) in grid units, and the step of their grid. Holds what the engine's sets view, but for
/// arrays and results: `given` must outlive it.
class Sets {
public:
    explicit Sets(const py::list& given) {
        for (const py::handle each : given) {
            const auto fields = py::reinterpret_borrow<py::tuple>(each);
            LayerSet& set = sets_.emplace_back(LayerSet{.layers = layers_of(fields[0]),
                                                        .from = fields[1].cast<std::int32_t>(),
                                                        .to = fields[2].cast<std::int32_t>(),
                                                        .grow_mm = fields[3].cast<double>(),
                                                        .fill_rule = static_cast<FillRule>(fields[4].cast<int>())});
            if (!fields[5].is_none()) {
                set.part = fields[5].cast<std::uint32_t>();
            }
        }
    }

    std::span<const LayerSet> all() const noexcept { return sets_; }

private:
    Layers layers_of(const py::object& what) {
        if (!py::isinstance<py::tuple>(what)) {
            return what.cast<const HeldResult&>().result;
        }
        const auto pair = py::reinterpret_borrow<py::tuple>(what);
        if (!py::isinstance<py::list>(pair[0])) {
            return layers_.emplace_back(pair[0].cast<const HeldResult&>().result[pair[1].cast<std::size_t>()]);
        }
        std::vector<std::span<const Point>>& paths = paths_.emplace_back();
        for (const py::handle contour : pair[0]) {
            const auto rows = py::reinterpret_borrow<Contours>(contour);
            paths.emplace_back(reinterpret_cast<const Point*>(rows.data()), static_cast<std::size_t>(rows.shape(0)));
        }
        return contours_.emplace_back(ContourSet{paths, pair[1].cast<double>()});
    }

    std::deque<LayerView> layers_;
    std::deque<std::vector<std::span<const Point>>> paths_;
    std::deque<ContourSet> contours_;
    std::vector<LayerSet> sets_;
};

/// By the index of a word in RULES of _combine.py.
Rule rule_of(std::size_t word, std::size_t sets) noexcept {
    const Rule rules[] = {unite, subtract, intersect(sets), exclusive, {.last_wins = true}};
    return rules[word];
}

/// Precondition: from 1 to most_layer_sets sets.
HeldResult combine(const py::list& given, const py::object& rule, const Asked& asked) {
    const Sets sets(given);
    Rule by;
    if (py::isinstance<py::array>(rule)) {
        const auto labels = py::reinterpret_borrow<py::array_t<std::uint32_t, py::array::c_style>>(rule);
        by.labels = {labels.data(), static_cast<std::size_t>(labels.size())};
    } else {
        by = rule_of(rule.cast<std::size_t>(), given.size());
    }
    SliceResult result;
    run(asked,
        [&](const Context& context) { return Overlay().combine(result, sets.all(), by, asked.options.region, context); });
    return HeldResult(std::move(result));
}

/// Steps: (mm, kept) each. `how`: join, end, miter limit, arc tolerance.
HeldResult offset(const py::list& given, const std::vector<std::pair<double, bool>>& steps,
                  const std::tuple<int, int, double, double>& how, const Asked& asked) {
    const Sets sets(given);
    std::vector<OffsetStep> moves;
    for (const auto& [mm, keep] : steps) {
        moves.push_back({mm, keep});
    }
    const auto [join, end, miter_limit, arc_tolerance] = how;
    const OffsetOptions options{.join = static_cast<Join>(join),
                                .end = static_cast<End>(end),
                                .miter_limit = miter_limit,
                                .arc_tolerance_mm = arc_tolerance};
    SliceResult result;
    run(asked, [&](const Context& context) {
        return Overlay().offset(result, sets.all()[0], moves, options, asked.options.region, context);
    });
    return HeldResult(std::move(result));
}

/// `given`: the polylines, then what clips them.
HeldResult clip(const py::list& given, bool inside, bool boundary_is_inside, const Asked& asked) {
    const Sets sets(given);
    SliceResult result;
    run(asked, [&](const Context& context) {
        return Overlay().clip(result, sets.all()[0].layers, sets.all()[1], {inside, boundary_is_inside}, context);
    });
    return HeldResult(std::move(result));
}

}  // namespace

void define_overlay(py::module_& module) {
    module.attr("most_layer_sets") = most_layer_sets;
    module.attr("most_labels") = most_labels;
    module.def("combine", &combine);
    module.def("offset", &offset);
    module.def("clip", &clip);
}

}  // namespace lamella::python
