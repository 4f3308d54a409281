#include "slicing/offset/fold.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "slicing/offset/raw_offset.hpp"

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
    return moved_on_grid(b, part * ux, part * uy);
}

struct Step {
    double x, y, length;

    Step(Point from, Point to) noexcept
        : x(static_cast<double>(to.x) - from.x), y(static_cast<double>(to.y) - from.y), length(std::sqrt(x * x + y * y)) {}
    double sine_to(const Step& next) const noexcept { return (x * next.y - y * next.x) / (length * next.length); }
    double cosine1_to(const Step& next) const noexcept { return 1 + (x * next.x + y * next.y) / (length * next.length); }
    /// The tangent of half the turn.
    double turn_to(const Step& next) const noexcept {
        return (x * next.y - y * next.x) / (length * next.length + (x * next.x + y * next.y));
    }
};

/// By how much the offset of the edge from `b` to `c` shrinks on its way, as a share of its length for each unit of
/// distance; zero or less if it does not.
double shrinking(Point a, Point b, Point c, Point d) noexcept {
    const Step before(a, b);
    const Step edge(b, c);
    const Step after(c, d);
    return -(before.turn_to(edge) + edge.turn_to(after)) / edge.length;
}

/// True if the outer corner `b` passes the miter limit. Between the moved edges then runs a third one, which stays where one
/// of them shrinks to a point.
bool is_cut(Point a, Point b, Point c, double miter) noexcept {
    const Step before(a, b);
    const Step after(b, c);
    return before.sine_to(after) >= 0 && before.cosine1_to(after) < std::max(2.0 / (miter * miter), sharpest_cosine1);
}

/// True if the edge from `a` to `b`, an end of which was rounded, still has its direction: when it moves by `distance`, its
/// ends may slip along it by a few units.
bool is_steady(Point a, Point b, double distance) noexcept {
    constexpr double slip = 8;
    return Step(a, b).length * slip >= distance;
}

/// Replaces edges of an open stretch, the first to shrink to a point first, until none does so within the distance. Those at
/// its ends stay.
bool fold_stretch(double distance, double miter, Vector<Point>& stretch, Vector<std::uint32_t>& indices) {
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
        const Point a = stretch[first - 1];
        const Point b = stretch[first];
        const Point c = stretch[first + 1];
        const Point d = stretch[first + 2];
        if (is_cut(a, b, c, miter) || is_cut(b, c, d, miter)) {
            return false;
        }
        const std::optional<Point> corner = corner_of(a, b, c, d);
        if (!corner || !is_steady(a, *corner, distance) || !is_steady(*corner, d, distance)) {
            return false;
        }
        stretch[first] = *corner;
        indices[first] = no_point;
        stretch.erase(stretch.begin() + static_cast<std::ptrdiff_t>(first) + 1);
        indices.erase(indices.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    }
}

}  // namespace

bool fold_edges(std::span<const Point> contour, std::span<const std::uint32_t> turned, double distance, double miter,
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
        if (!fold_stretch(distance, miter, stretch, stretch_indices)) {
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
