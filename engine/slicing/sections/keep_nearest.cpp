#include <algorithm>
#include <limits>
#include <optional>

#include "base/guard.hpp"
#include "base/vector.hpp"
#include "lamella/sections.hpp"
#include "slicing/grid/distance.hpp"
#include "slicing/nesting/inside.hpp"

namespace lamella {

namespace {

/// Exact; the boundary does not count as inside.
bool holds_middle(std::span<const Point> ring, nesting::AddEdges add_edges) noexcept {
    return nesting::strictly_inside(add_edges, ring.data(), static_cast<std::uint32_t>(ring.size()), Point{0, 0});
}

double squared_distance_from_middle(std::span<const Point> ring) noexcept {
    double least = std::numeric_limits<double>::infinity();
    Point from = ring.back();
    for (const Point to : ring) {
        least = std::min(least, squared_distance(0, 0, from, to));
        from = to;
    }
    return least;
}

/// Nothing where there is no island.
std::optional<Island> nearest_island(const LayerView& layer, nesting::AddEdges add_edges) noexcept {
    std::optional<Island> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const Island island : layer.islands()) {
        const bool in_solid = holds_middle(layer.points_of(*island.outer), add_edges) &&
                              std::none_of(island.holes.begin(), island.holes.end(), [&](const Contour& hole) {
                                  return holds_middle(layer.points_of(hole), add_edges);
                              });
        const double distance = in_solid ? -1 : squared_distance_from_middle(layer.points_of(*island.outer));
        if (distance < least) {
            least = distance;
            nearest = island;
        }
    }
    return nearest;
}

}  // namespace

Result<SliceResult> keep_nearest_islands(const SliceResult& sections, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceResult> {
        const nesting::AddEdges add_edges = best_of(nesting::add_edges_forms(), instruction_set());
        Vector<Contour> contours(context.memory);
        Vector<Point> points(context.memory);
        SliceResult kept(context.memory);
        kept.info = sections.info;
        kept.layers.resize_discarding(sections.size());
        const auto keep = [&](const LayerView& layer, const Contour& contour, std::int64_t parent) {
            contours.push_back(contour);
            contours.back().first_point = points.size();
            contours.back().parent = parent;
            const std::span<const Point> own = layer.points_of(contour);
            points.insert(points.end(), own.begin(), own.end());
        };
        for (std::size_t i = 0; i < sections.size(); ++i) {
            const LayerView layer = sections[i];
            const std::size_t first = contours.size();
            if (const std::optional<Island> island = nearest_island(layer, add_edges)) {
                keep(layer, *island->outer, -1);
                for (const Contour& hole : island->holes) {
                    keep(layer, hole, static_cast<std::int64_t>(first));
                }
            }
            for (const Contour& contour : layer.contours) {
                if (contour.role == Role::open) {
                    keep(layer, contour, -1);
                }
            }
            kept.layers[i] = sections.layers[i];
            kept.layers[i].first_contour = first;
            kept.layers[i].contour_count = contours.size() - first;
        }
        kept.contours.resize_discarding(contours.size());
        std::copy(contours.begin(), contours.end(), kept.contours.begin());
        kept.points.resize_discarding(points.size());
        std::copy(points.begin(), points.end(), kept.points.begin());
        const auto count = [&](Role role) {
            return static_cast<std::uint64_t>(
                std::count_if(contours.begin(), contours.end(), [role](const Contour& c) { return c.role == role; }));
        };
        kept.info.contours = contours.size();
        kept.info.points = points.size();
        kept.info.holes = count(Role::hole);
        kept.info.open_contours = count(Role::open);
        kept.info.flat_contours = kept.info.stitches = 0;
        return kept;
    });
}

}  // namespace lamella
