// A region of a caller's own contours: a layer without the walk.
#include "lamella/layers.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/words.hpp"
#include "base/worker.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_points = std::size_t{1} << 30;

using ContoursView = std::span<const std::span<const Point>>;

/// The farthest coordinate.
Result<std::int32_t> check_points(ContoursView contours, Worker& worker) {
    std::size_t points = 0;
    std::int32_t farthest = 0;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        points += contours[c].size();
        if (points > most_points) {
            return Error{ErrorCode::invalid_argument, "more than 2^30 points in one plane"};
        }
        for (std::size_t i = 0; i < contours[c].size(); ++i) {
            const Point p = contours[c][i];
            const auto [low, high] = std::minmax({p.x, p.y});
            if (low < -grid_limit || high > grid_limit) {
                return Error{ErrorCode::invalid_argument, "contour " + std::to_string(c) + ", point " + std::to_string(i) +
                                                              ": (" + std::to_string(p.x) + ", " + std::to_string(p.y) +
                                                              ") lies beyond the grid, which ends at " +
                                                              std::to_string(grid_limit) + " units"};
            }
            farthest = std::max({farthest, high, -low});
        }
        worker.spend(contours[c].size());
    }
    return farthest;
}

Status check_all(ContoursView contours, const RegionRules& rules, double grid_mm, Worker& worker) {
    if (!(grid_mm > 0) || !std::isfinite(grid_mm)) {
        return Error{ErrorCode::invalid_argument,
                     "the grid unit must be finite and above 0, not " + exact_text(grid_mm) + " mm"};
    }
    if (Status status = check_rules({.region = rules}); !status) {
        return status;
    }
    const Result<std::int32_t> farthest = check_points(contours, worker);
    return farthest ? check_reach(rules, grid_mm, *farthest * grid_mm) : farthest.error();
}

/// Those that have points.
Vector<Path> list_given(ContoursView contours, Worker& worker) {
    Vector<Path> given(worker.memory());
    given.reserve(contours.size());
    for (const std::span<const Point> contour : contours) {
        worker.spend(1);
        if (!contour.empty()) {
            given.push_back(given_path(contour));
        }
    }
    return given;
}

}  // namespace

Result<SliceResult> region_of(std::span<const std::span<const Point>> contours, const RegionRules& rules, double grid_mm,
                              const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceResult> {
        const PacedStop stop(context.stop);
        Worker worker(context.memory, stop.check());
        worker.ask();
        if (Status status = check_all(contours, rules, grid_mm, worker); !status) {
            return status.error();
        }
        LayerBuilder builder(worker);
        const LayerRules layer_rules{.region = &rules, .grid_mm = grid_mm};
        builder.rules = &layer_rules;
        BandOutput output(context.memory);
        output.begin(output.buffer.span());
        builder.read_given(list_given(contours, worker));
        builder.build(output);
        SliceResult region = copy_layer(output, 0, worker, context.memory);
        region.info.options.region = rules;
        region.info.grid_mm = grid_mm;
        return region;
    });
}

}  // namespace lamella
