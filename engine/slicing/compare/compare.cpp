// compare(), as the list of its stages:
//
//     overlay      what lies in the first alone, in the second alone and in both: labels 1 to 3, by one arrangement a layer
//     areas        of each label, and what follows from them
//     distances    of contours, both ways

#include "lamella/compare.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/overlay.hpp"
#include "slicing/compare/contour_distance.hpp"

namespace lamella {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

bool has_open(const LayerView& layer) noexcept {
    return std::any_of(layer.contours.begin(), layer.contours.end(),
                       [](const Contour& contour) { return contour.role == Role::open; });
}

void require_same_planes(const SliceResult& first, const SliceResult& second) {
    const std::size_t common = std::min(first.size(), second.size());
    std::size_t i = 0;
    const auto is_same = [&] {  // as Overlay has it
        return first.layers[i].plane == second.layers[i].plane || first.layers[i].plane_mm == second.layers[i].plane_mm;
    };
    while (i < common && is_same()) {
        ++i;
    }
    if (i < std::max(first.size(), second.size())) {
        throw Refused{
            {.code = ErrorCode::invalid_argument,
             .message = "layer " + std::to_string(i) + " of the two lies at other heights: cut both at the same planes",
             .plane = static_cast<std::int64_t>(i)}};
    }
}

/// Dice and Jaccard of three areas.
void finish_areas(LayerComparison& row) noexcept {
    const double both = row.first_mm2 + row.second_mm2;
    if (both > 0) {
        row.dice = 2 * row.both_mm2 / both;
        row.jaccard = row.both_mm2 / (both - row.both_mm2);
    }
}

void find_areas(const LayerView& labelled, LayerComparison& row) noexcept {
    std::array<double, 3> areas{};  // first alone, second alone, both
    for (const Contour& contour : labelled.contours) {
        areas[contour.part] += labelled.area_mm2(contour);
    }
    row.both_mm2 = areas[2];
    row.first_mm2 = areas[0] + areas[2];
    row.second_mm2 = areas[1] + areas[2];
    finish_areas(row);
}

/// Of both ways; grid units.
Distances find_distances(const LayerView& first, const LayerView& second, Worker& worker) {
    NearestEdges of_first(worker);
    NearestEdges of_second(worker);
    of_first.assign(first);
    of_second.assign(second);
    if (of_first.empty() || of_second.empty()) {
        return of_first.empty() && of_second.empty() ? Distances{} : Distances{infinity, 1, infinity};
    }
    const Distances there = of_first.distances_to(of_second);
    const Distances back = of_second.distances_to(of_first);
    return {there.sum + back.sum, there.length + back.length, std::max(there.most, back.most)};
}

void write_distances(const Distances& found, double grid_mm, LayerComparison& row) noexcept {
    if (found.length > 0) {
        row.mean_distance_mm = found.sum / found.length * grid_mm;
        row.hausdorff_mm = found.most * grid_mm;
    }
}

/// Sums over all layers. NaN stays, as of a layer that is not known.
void sum_up(const SliceResult& first, std::span<const Distances> distances, Comparison& found) noexcept {
    LayerComparison& all = found.stack;
    all.first_mm2 = all.second_mm2 = all.both_mm2 = 0;
    Distances total;
    bool known = true;
    for (std::size_t i = 0; i < found.layers.size(); ++i) {
        const LayerComparison& row = found.layers[i];
        const double thickness = first.layers[i].top_mm - first.layers[i].bottom_mm;
        all.first_mm2 += row.first_mm2 * thickness;
        all.second_mm2 += row.second_mm2 * thickness;
        all.both_mm2 += row.both_mm2 * thickness;
        known = known && !std::isnan(row.first_mm2);
        if (!distances.empty()) {
            total.sum += distances[i].sum;
            total.length += distances[i].length;
            total.most = std::max(total.most, distances[i].most);
        }
    }
    finish_areas(all);
    if (known) {
        write_distances(total, first.info.grid_mm, all);
    }
}

}  // namespace

Result<Comparison> compare(const SliceResult& first, const SliceResult& second, const CompareOptions& options,
                           const Context& context) noexcept {
    return guarded(context, [&]() -> Result<Comparison> {
        require_same_planes(first, second);
        const Parallel parallel(context);
        parallel.begin_stage(0.5);
        SliceResult labelled(context.memory);
        const std::array<LayerSet, 2> sets = {{{.layers = first}, {.layers = second}}};
        static constexpr std::array<std::uint32_t, 4> labels = {0, 1, 2, 3};
        require(Overlay().combine(Destination(labelled), sets, {.labels = labels}, {}, parallel.within(context)));
        parallel.reach(0.5);
        Comparison found(context.memory);
        found.layers.resize_discarding(first.size());
        Vector<Distances> distances(options.distances ? first.size() : 0, Distances(), context.memory);
        parallel.begin_stage(1);
        parallel.run(first.size(), [&](std::size_t i, int) {
            Worker worker(parallel.memory(), parallel.stop());
            LayerComparison& row = found.layers[i] = {};
            row.layer = i;
            row.z_mm = first.layers[i].plane_mm;
            if (has_open(first[i]) || has_open(second[i])) {
                return;
            }
            find_areas(labelled[i], row);
            if (options.distances) {
                distances[i] = find_distances(first[i], second[i], worker);
                write_distances(distances[i], first.info.grid_mm, row);
            }
        });
        sum_up(first, distances, found);
        parallel.finish();
        return found;
    });
}

}  // namespace lamella
