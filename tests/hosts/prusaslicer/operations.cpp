// Operations on whole stacks of layers by the host's functions and by lamella::Overlay: what they give, and how long they
// take. Under the adapter's licence: AGPL-3.0-or-later (see adapter.cpp).
//
// Both get the same layers, cut by the library. The host's functions run layer by layer in a loop of oneTBB, as in its
// PrintObject; the library takes a SliceResult, and hands over layers that become the host's polygons at once.
#include <tbb/parallel_for.h>

#include <array>
#include <cstdio>
#include <lamella/overlay.hpp>
#include <libslic3r/ClipperUtils.hpp>
#include <utility>

#include "both.hpp"
#include "contours.hpp"
#include "cut.hpp"

namespace compare {
namespace {

using namespace Slic3r;
using namespace lamella_adapter;
using lamella::LayerSet;

constexpr double crossings_mm = 2e-6;  // where contours cross, both round a point to their unit
constexpr double wall_mm = 0.2;
constexpr double closing_mm = 0.049;
constexpr double arc_tolerance_mm = 0.005;
constexpr double opening_mm = 0.045;  // detect_surfaces_type(): a tenth of an extrusion of 0.45 mm

// The same layers, as each of the two takes them.
struct Stack {
    Layers host;
    lamella::SliceResult ours;
};

struct Operation {
    const char* name;
    std::function<Layers(const Stack&)> host;
    std::function<Layers(const Stack&)> ours;
    double bound_mm;
};

lamella::Overlay overlay;  // keeps scratch memory from call to call

Stack stack_of(const Model& model, const std::vector<float>& zs) {
    const HostCalls calls(never);
    Stack made;
    made.ours = calls.finish(
        lamella::slice(view_of(model.mesh.vertices, model.mesh.indices),
                       cutting_options(zs, {.fill_rule = lamella::FillRule::non_zero, .drop_collinear = true})));
    for (const lamella::LayerView& layer : made.ours) {
        made.host.push_back(expolygons(layer));
    }
    return made;
}

// The host: work(layer, the next one) in a loop over layers. Ours: call(layers, destination).
template <class Work, class Call>
Operation layer_by_layer(const char* name, double bound_mm, const Work& work, const Call& call) {
    const auto host = [work](const Stack& stack) {
        Layers made(stack.host.size());
        tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t at) {
            made[at] = work(stack.host[at], at + 1 < made.size() ? stack.host[at + 1] : ExPolygons());
        });
        return made;
    };
    const auto ours = [call](const Stack& stack) {
        Layers made(stack.host.size());
        HostCalls calls(never);
        const auto take = [&](const lamella::LayerView& layer) noexcept {
            calls.within([&] { made[layer.index] = expolygons(layer); });
        };
        calls.finish(call(stack.ours, lamella::LayerSink{.take = take, .order = lamella::SinkOrder::any}));
        return made;
    };
    return {name, host, ours, bound_mm};
}

// An offset by steps, of which the last is the answer.
Operation offset_by(const char* name, lamella::Join join, const std::vector<double>& steps_mm,
                    const std::function<ExPolygons(const ExPolygons&)>& host) {
    std::vector<lamella::OffsetStep> steps;
    for (const double mm : steps_mm) {
        steps.push_back({mm * frame_per_mm, steps.size() + 1 == steps_mm.size()});
    }
    return layer_by_layer(
        name, corners_mm, [host](const ExPolygons& own, const ExPolygons&) { return host(own); },
        [steps, join](const lamella::SliceResult& layers, const lamella::LayerSink& to) {
            return overlay.offset(to, {.layers = layers}, steps,
                                  {.join = join, .arc_tolerance_mm = arc_tolerance_mm * frame_per_mm});
        });
}

// By what lies above and below. The number is a label of the library's less one.
enum Kind : std::size_t { inside, top, bottom };
using Kinds = std::array<Layers, 3>;

// The body of the loop in PrintObject::detect_surfaces_type(), without interface shells.
void detect_by_host(const Layers& layers, std::size_t at, Kinds& made) {
    const ExPolygons& own = layers[at];
    const auto uncovered = [&](const ExPolygons& by) {
        return opening_ex(diff_ex(own, by, ApplySafetyOffset::Yes), scaled<float>(opening_mm));
    };
    ExPolygons above = at + 1 < layers.size() ? uncovered(layers[at + 1]) : own;
    made[bottom][at] = at > 0 ? uncovered(layers[at - 1]) : own;
    if (!above.empty() && !made[bottom][at].empty()) {
        above = diff_ex(above, made[bottom][at]);
    }
    Polygons covered = to_polygons(above);
    polygons_append(covered, to_polygons(made[bottom][at]));
    made[inside][at] = diff_ex(own, covered);
    made[top][at] = std::move(above);
}

Kinds host_surfaces(const Stack& stack) {
    Kinds made;
    made.fill(Layers(stack.host.size()));
    tbb::parallel_for(std::size_t{0}, stack.host.size(), [&](std::size_t at) { detect_by_host(stack.host, at, made); });
    return made;
}

// The host opens neither the lowest layer, all of which is bottom, nor the highest one, all the rest of which is top.
void copy_end(const Layers& layers, std::size_t at, Kinds& made) {
    if (at == 0) {
        made[bottom][at] = layers[at];
        made[top][at].clear();
    } else if (at + 1 == layers.size()) {
        append(made[top][at], std::move(made[inside][at]));
        made[top][at] = union_ex(made[top][at]);
    } else {
        return;
    }
    made[inside][at].clear();
}

// The two differences, eroded; then all three kinds at once, from the differences dilated.
Kinds our_surfaces(const Stack& stack) {
    constexpr double safety_mm = ClipperSafetyOffset * lamella::default_grid_mm;
    HostCalls calls(never);
    const auto uncovered = [&](std::int32_t neighbour) {
        const LayerSet sets[] = {{.layers = stack.ours},
                                 {.layers = stack.ours, .from = neighbour, .to = neighbour, .grow_mm = safety_mm}};
        lamella::SliceResult made;
        calls.finish(overlay.combine(made, sets, lamella::subtract, {.offset_mm = -opening_mm * frame_per_mm}));
        return made;
    };
    const lamella::SliceResult above = uncovered(1);
    const lamella::SliceResult below = uncovered(-1);
    Kinds made;
    made.fill(Layers(stack.host.size()));
    const auto take = [&](const lamella::LayerView& layer) noexcept {
        calls.within([&] {
            for (const lamella::Island island : layer.islands()) {
                made[island.outer->part][layer.index].push_back(expolygon(layer, island));
            }
            copy_end(stack.host, layer.index, made);
        });
    };
    const LayerSet sets[] = {{.layers = stack.ours},
                             {.layers = above, .grow_mm = opening_mm * frame_per_mm},
                             {.layers = below, .grow_mm = opening_mm * frame_per_mm}};
    constexpr std::uint32_t labels[] = {0, 1 + inside, 1 + top, 1 + top, 1 + bottom, 1 + bottom, 1 + bottom, 1 + bottom};
    calls.finish(
        overlay.combine(lamella::LayerSink{.take = take, .order = lamella::SinkOrder::any}, sets, {.labels = labels}));
    return made;
}

Operation detection(const char* name, Kind kind) {
    return {name, [kind](const Stack& stack) { return std::move(host_surfaces(stack)[kind]); },
            [kind](const Stack& stack) { return std::move(our_surfaces(stack)[kind]); }, corners_mm};
}

// What is timed comes first.
std::vector<Operation> operations() {
    const auto host_union = [](ExPolygons own, const ExPolygons& next) {
        append(own, next);
        return union_ex(own);
    };
    const auto our_union = [](const lamella::SliceResult& layers, const lamella::LayerSink& to) {
        const LayerSet sets[] = {{.layers = layers, .to = 1}};
        return overlay.combine(to, sets);
    };
    const auto host_difference = [](const ExPolygons& own, const ExPolygons& next) { return diff_ex(own, next); };
    const auto our_difference = [](const lamella::SliceResult& layers, const lamella::LayerSink& to) {
        const LayerSet sets[] = {{.layers = layers}, {.layers = layers, .from = 1, .to = 1}};
        return overlay.combine(to, sets, lamella::subtract);
    };
    const auto miter = [](const ExPolygons& own) { return offset_ex(own, scaled<float>(-wall_mm)); };
    const auto round = [](const ExPolygons& own) {
        return offset_ex(own, scaled<float>(-wall_mm), jtRound, scaled<double>(arc_tolerance_mm));
    };
    const auto closing = [](const ExPolygons& own) { return closing_ex(own, scaled<float>(closing_mm)); };
    return {layer_by_layer("union_ex", crossings_mm, host_union, our_union),
            layer_by_layer("diff_ex", crossings_mm, host_difference, our_difference),
            offset_by("offset_ex, miter", lamella::Join::miter, {-wall_mm}, miter),
            offset_by("offset_ex, round", lamella::Join::round, {-wall_mm}, round),
            offset_by("closing_ex", lamella::Join::miter, {closing_mm, -closing_mm}, closing),
            detection("top surfaces", top),
            detection("bottom surfaces", bottom),
            detection("inner surfaces", inside)};
}

Way way_of(const Operation& operation) {
    const auto on_stack = [](const std::function<Layers(const Stack&)>& work) {
        return [work](const Model& model, const std::vector<float>& zs) { return work(stack_of(model, zs)); };
    };
    return {.name = operation.name,
            .host = on_stack(operation.host),
            .ours = on_stack(operation.ours),
            .bound_mm = operation.bound_mm,
            .same_layers = true};
}

bool time_row(const char* label, const std::vector<Model>& models, std::span<const Operation> timed) {
    std::vector<Stack> stacks;
    for (const Model& model : models) {
        stacks.push_back(stack_of(model, heights(model, 0.2, 0.1)));
    }
    const auto on_all = [&](const auto& work) { return [&] { std::for_each(stacks.begin(), stacks.end(), work); }; };
    std::printf("| %s |", label);
    bool all = true;
    for (const Operation& operation : timed) {
        all = reaches(medians(on_all(operation.host), on_all(operation.ours)), 1) && all;
    }
    std::printf("\n");
    return all;
}

}  // namespace

bool operations_agree(const std::vector<Model>& parts, const std::vector<Model>& organs) {
    const std::vector<Operation> each = operations();
    std::vector<std::pair<std::string, std::vector<Model>>> rows = {{"the host's", parts}};
    for (const Model& organ : organs) {
        rows.push_back({organ.name, {organ}});
    }
    bool all = true;
    std::string beyond;
    print_agreement_head();
    for (const auto& [label, models] : rows) {
        for (const Operation& operation : each) {
            all = agree(models, 0.1, way_of(operation), label.c_str(), beyond) && all;
        }
    }
    std::printf(
        "\n%s\n| | union_ex | diff_ex | offset_ex, miter | offset_ex, round | closing_ex | top and bottom |\n"
        "|---|---|---|---|---|---|---|\n",
        beyond.c_str());
    for (const auto& [label, models] : rows) {
        all = time_row(label.c_str(), models, std::span(each).first(6)) && all;
    }
    return all;
}

}  // namespace compare
