#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/guard.hpp"
#include "base/vector.hpp"
#include "lamella/sections.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr Point middle{0, 0};

/// How often a contour runs counter-clockwise around (0, 0); what lies on it counts as outside. Exact.
int winding_around_middle(std::span<const Point> ring) noexcept {
    int winding = 0;
    Point a = ring.back();
    for (const Point b : ring) {
        if ((a.y <= 0) != (b.y <= 0) && side_of(a, b, middle) == (a.y <= 0 ? 1 : -1)) {
            winding += a.y <= 0 ? 1 : -1;
        }
        a = b;
    }
    return winding;
}

double distance_from_middle(std::span<const Point> ring) noexcept {
    double least = std::numeric_limits<double>::infinity();
    Point a = ring.back();
    for (const Point b : ring) {
        const auto ax = static_cast<double>(a.x);
        const auto ay = static_cast<double>(a.y);
        const double dx = b.x - ax;
        const double dy = b.y - ay;
        const double square = dx * dx + dy * dy;
        const double along = square > 0 ? std::clamp(-(ax * dx + ay * dy) / square, 0.0, 1.0) : 0;
        const double x = ax + along * dx;
        const double y = ay + along * dy;
        least = std::min(least, x * x + y * y);
        a = b;
    }
    return least;
}

/// Nothing where there is no island.
std::optional<Island> nearest_island(const LayerView& layer) noexcept {
    std::optional<Island> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const Island island : layer.islands()) {
        int winding = winding_around_middle(layer.points_of(*island.outer));
        for (const Contour& hole : island.holes) {
            winding += winding_around_middle(layer.points_of(hole));
        }
        const double distance = winding > 0 ? -1 : distance_from_middle(layer.points_of(*island.outer));
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
            if (const std::optional<Island> island = nearest_island(layer)) {
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
