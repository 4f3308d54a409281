#include "medical/raster/clipped_area.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace lamella {

namespace {

/// Twice the area of a polygon.
double twice_area(const std::vector<PointMm>& polygon) {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PointMm& a = polygon[i];
        const PointMm& b = polygon[(i + 1) % polygon.size()];
        sum += a.x * b.y - b.x * a.y;
    }
    return sum;
}

/// Keeps what of a polygon lies on one side of a line x = limit or y = limit (Sutherland and Hodgman): its area is right,
/// whatever its form.
std::vector<PointMm> clipped(const std::vector<PointMm>& polygon, bool along_y, double limit, double side) {
    const auto beyond = [&](const PointMm& at) { return side * ((along_y ? at.y : at.x) - limit); };
    std::vector<PointMm> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PointMm& a = polygon[i];
        const PointMm& b = polygon[(i + 1) % polygon.size()];
        const double from = beyond(a);
        const double to = beyond(b);
        if (from <= 0) {
            kept.push_back(a);
        }
        if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
            const double t = from / (from - to);
            kept.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
        }
    }
    return kept;
}

}  // namespace

double area_within(std::vector<PointMm> polygon, PointMm min, PointMm max) {
    polygon = clipped(clipped(polygon, false, min.x, -1), false, max.x, 1);
    polygon = clipped(clipped(polygon, true, min.y, -1), true, max.y, 1);
    return 0.5 * twice_area(polygon);
}

double perimeter_of(std::span<const Point> points) noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        const Point& q = points[i + 1 < points.size() ? i + 1 : 0];
        sum += std::sqrt(std::pow(static_cast<double>(std::int64_t{q.x} - p.x), 2) +
                         std::pow(static_cast<double>(std::int64_t{q.y} - p.y), 2));
    }
    return sum;
}

}  // namespace lamella
