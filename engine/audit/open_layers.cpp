#include "lamella/audit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "audit/questions.hpp"
#include "base/guard.hpp"
#include "base/words.hpp"
#include "slicing/repair/polylines.hpp"

namespace lamella {

namespace {

constexpr double beyond = 1 + 1e-12;            ///< makes up for what squares of lengths and their units lose
constexpr double any_reach = 4.0 * grid_limit;  ///< beyond the diagonal of the grid

/// The least number of two digits that is not below `value`, which is positive.
std::string rounded_up(double value) {
    double step = 1;
    while (value >= 100 * step) {
        step *= 10;
    }
    double scale = 1;
    while (value * scale < 10) {
        scale *= 10;
    }
    return exact_text(std::ceil(value / step * scale) * step / scale);  // one of step and scale is 1
}

std::string percent_text(double share) {
    const double tenths = std::round(1000 * share);
    return tenths < 1 ? "less than 0.1 %" : exact_text(tenths / 10) + " %";
}

/// How far apart ends of one part's polylines are that have to be joined, in grid units. Sets `stuck` where some have
/// nothing to be joined to.
double reach_of(std::span<const PolylineEnds> ends, StitchDirection direction, GapCloser& closer, bool& stuck) {
    const std::span<const Gap> gaps = closer.close(ends, {any_reach, any_reach, direction});
    double longest = 1;  // ends at one point have to be joined too
    for (const Gap& gap : gaps) {
        const auto at = [&](PolylineEnd end) { return ends[end.polyline()].at(end.last()); };
        longest = std::max(longest, std::sqrt(squared_distance(at(gap.from), at(gap.to))));
    }
    stuck = stuck || gaps.size() < ends.size();
    return longest * beyond;
}

OpenLayers open_layer(const LayerView& view, StitchDirection direction, const StopCheck& stop) {
    OpenLayers found;
    if (view.segments == 0) {
        return found;
    }
    found.crossed = 1;
    found.crossed_mm = view.top_mm - view.bottom_mm;
    for (const Stitch& gap : view.stitches) {
        found.reach_mm = std::max(found.reach_mm, std::sqrt(squared_distance(gap.from, gap.to)) * view.grid_mm * beyond);
    }
    Worker worker(nullptr, stop);
    worker.spend(view.stitches.size() + view.contours.size());
    std::vector<const Contour*> open;
    for (const Contour& contour : view.contours) {
        if (contour.role == Role::open && contour.point_count > 0) {
            open.push_back(&contour);
        }
    }
    if (open.empty()) {
        return found;
    }
    found.layers = 1;
    found.height_mm = found.crossed_mm;
    std::stable_sort(open.begin(), open.end(), [](const Contour* a, const Contour* b) { return a->part < b->part; });
    GapCloser closer(worker);
    bool stuck = false;
    std::vector<PolylineEnds> ends;
    for (std::size_t i = 0; i < open.size(); ++i) {
        const std::span<const Point> points = view.points_of(*open[i]);
        ends.push_back({points.front(), points.back()});
        if (i + 1 == open.size() || open[i + 1]->part != open[i]->part) {
            found.reach_mm = std::max(found.reach_mm, reach_of(ends, direction, closer, stuck) * view.grid_mm);
            ends.clear();
        }
    }
    found.stuck = stuck ? 1 : 0;
    return found;
}

}  // namespace

double OpenLayers::share() const noexcept {
    return crossed_mm > 0 ? height_mm / crossed_mm
                          : static_cast<double>(layers) / static_cast<double>(std::max<std::uint64_t>(crossed, 1));
}

void OpenLayers::add(const OpenLayers& other) noexcept {
    layers += other.layers;
    crossed += other.crossed;
    stuck += other.stuck;
    height_mm += other.height_mm;
    crossed_mm += other.crossed_mm;
    reach_mm = std::max(reach_mm, other.reach_mm);
}

Result<OpenLayers> find_open_layer(const LayerView& layer, StitchDirection direction, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<OpenLayers> { return open_layer(layer, direction, context.stop); });
}

OpenLayers find_open_layers(const SliceResult& result, const Parallel& parallel) {
    std::vector<OpenLayers> layers(result.size());
    parallel.run(layers.size(), [&](std::size_t i, int) {
        layers[i] = open_layer(result[i], result.info.options.stitch_direction, parallel.stop());
    });
    OpenLayers all;
    for (const OpenLayers& layer : layers) {
        all.add(layer);
    }
    return all;
}

std::string describe(const OpenLayers& open, std::string_view option) {
    const bool one = open.layers == 1;
    std::string text = std::to_string(open.layers) + " of " + std::to_string(open.crossed) +
                       (open.crossed == 1 ? " layer (" : " layers (") + percent_text(open.share()) + " of the height) " +
                       (one ? "has open contours: its" : "have open contours: their") + " area is not known; ";
    if (open.stuck == open.layers) {
        return text + "no length of " + std::string(option) + "would close " + (one ? "it" : "them");
    }
    text += std::string(option) + rounded_up(open.reach_mm / (beyond * beyond)) + " would close ";
    return text + (open.stuck > 0 ? "all but " + std::to_string(open.stuck) : (one ? "it" : "them"));
}

}  // namespace lamella
