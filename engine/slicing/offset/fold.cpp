#include "slicing/offset/fold.hpp"

#include <cmath>
#include <optional>

#include "base/rounding.hpp"

namespace lamella {

namespace {

/// Where the line from `a` to `b` meets the one from `c` to `d`, if that runs to the right of it, and neither edge is turned
/// round when it ends or begins there. Lines that are nearly parallel meet nowhere: rounding would decide where.
std::optional<Point> corner_of(Point a, Point b, Point c, Point d) noexcept {
    const double ux = static_cast<double>(b.x) - a.x;
    const double uy = static_cast<double>(b.y) - a.y;
    const double vx = static_cast<double>(d.x) - c.x;
    const double vy = static_cast<double>(d.y) - c.y;
    const double turn = ux * vy - uy * vx;
    constexpr double least_sine = 1e-6;
    if (!(turn < 0) || turn * turn < least_sine * least_sine * ((ux * ux + uy * uy) * (vx * vx + vy * vy))) {
        return {};
    }
    const double wx = static_cast<double>(c.x) - b.x;
    const double wy = static_cast<double>(c.y) - b.y;
    const double part = (wx * vy - wy * vx) / turn;
    const double other_part = (wx * uy - wy * ux) / turn;
    if (!(part > -1 && other_part < 1)) {
        return {};
    }
    const double x = b.x + part * ux;
    const double y = b.y + part * uy;
    if (!(std::abs(x) < grid_limit && std::abs(y) < grid_limit)) {
        return {};
    }
    return Point{round_to_int(x), round_to_int(y)};
}

/// By how much the offset of the edge from `b` to `c` shrinks on its way, as a share of its length for each unit of
/// distance; zero or less if it does not.
double shrinking(Point a, Point b, Point c, Point d) noexcept {
    struct Vector2 {
        double x, y, length;

        Vector2(Point from, Point to) noexcept
            : x(static_cast<double>(to.x) - from.x),
              y(static_cast<double>(to.y) - from.y),
              length(std::sqrt(x * x + y * y)) {}
        /// The tangent of half the turn.
        double turn_to(const Vector2& next) const noexcept {
            return (x * next.y - y * next.x) / (length * next.length + (x * next.x + y * next.y));
        }
    };
    const Vector2 before(a, b);
    const Vector2 edge(b, c);
    const Vector2 after(c, d);
    return -(before.turn_to(edge) + edge.turn_to(after)) / edge.length;
}

/// Replaces edges of an open stretch, the first to shrink to a point first, until none does so within the distance. Those at
/// its ends stay.
bool fold_stretch(double distance, Vector<Point>& stretch, Vector<std::uint32_t>& indices) {
    for (;;) {
        std::size_t first = 0;
        double fastest = 1 / distance;
        for (std::size_t k = 1; k + 2 < stretch.size(); ++k) {
            const double own = shrinking(stretch[k - 1], stretch[k], stretch[k + 1], stretch[k + 2]);
            if (own >= fastest) {
                fastest = own;
                first = k;
            }
        }
        if (first == 0) {
            return true;
        }
        const std::optional<Point> corner =
            corner_of(stretch[first - 1], stretch[first], stretch[first + 1], stretch[first + 2]);
        if (!corner || *corner == stretch[first - 1] || *corner == stretch[first + 2]) {
            return false;
        }
        stretch[first] = *corner;
        indices[first] = no_point;
        stretch.erase(stretch.begin() + static_cast<std::ptrdiff_t>(first) + 1);
        indices.erase(indices.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    }
}

}  // namespace

bool fold_edges(std::span<const Point> contour, std::span<const std::uint32_t> turned, double distance,
                Vector<Point>& points, Vector<std::uint32_t>& indices) {
    constexpr std::size_t before = 2;  // points of a stretch before its first edge that turns round
    constexpr std::size_t after = 3;   // and after the start of its last
    const std::size_t count = contour.size();
    const std::size_t begin = points.size();
    const std::size_t base = (turned[0] + count - before) % count;
    const auto append = [&](std::size_t i, Vector<Point>& to, Vector<std::uint32_t>& to_indices) {
        const std::size_t index = (base + i) % count;
        to.push_back(contour[index]);
        to_indices.push_back(static_cast<std::uint32_t>(index));
    };
    const auto place_of = [&](std::size_t t) { return (turned[t] + count - base) % count; };
    Vector<Point> stretch(points.get_allocator());
    Vector<std::uint32_t> stretch_indices(indices.get_allocator());
    std::size_t next = 0;
    for (std::size_t t = 0; t < turned.size();) {
        const std::size_t first = place_of(t) - before;
        std::size_t last = place_of(t++) + after;
        while (t < turned.size() && place_of(t) <= last + before) {
            last = place_of(t++) + after;
        }
        if (last >= count) {
            points.resize(begin);
            return false;
        }
        for (; next < first; ++next) {
            append(next, points, indices);
        }
        stretch.clear();
        stretch_indices.clear();
        for (; next <= last; ++next) {
            append(next, stretch, stretch_indices);
        }
        if (!fold_stretch(distance, stretch, stretch_indices)) {
            points.resize(begin);
            return false;
        }
        points.insert(points.end(), stretch.begin(), stretch.end());
        indices.insert(indices.end(), stretch_indices.begin(), stretch_indices.end());
    }
    for (; next < count; ++next) {
        append(next, points, indices);
    }
    return true;
}

}  // namespace lamella
