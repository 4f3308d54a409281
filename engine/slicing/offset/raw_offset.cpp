#include "slicing/offset/raw_offset.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/rounding.hpp"

namespace lamella {

namespace {

/// 1 + cos theta of a turn whose miter is 1,000 distances long. The miters of sharper corners are not computed: too few
/// digits of them would be right.
constexpr double sharpest_cosine1 = 2e-6;

/// What an inner corner too sharp to trim takes off: longer than any edge.
constexpr double beyond_any_edge = 1e12;

constexpr double beyond_limit = grid_limit + 1.0;

/// The nearest point of the grid; beyond it, the nearest of those just outside.
Point rounded(double x, double y) noexcept {
    return {round_to_int(std::max(-beyond_limit, std::min(beyond_limit, x))),
            round_to_int(std::max(-beyond_limit, std::min(beyond_limit, y)))};
}

bool is_beyond(Point p) noexcept {
    return std::max(p.x, p.y) > grid_limit || std::min(p.x, p.y) < -grid_limit;
}

/// The sign of the turn at b: 1 to the left. A difference has 32 bits and a sign, and two steps in a row stay on the grid: 63
/// bits and a sign hold the difference of the products.
int turn_sign(Point a, Point b, Point c) noexcept {
    const std::int64_t left = (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - b.y);
    const std::int64_t right = (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - b.x);
    return static_cast<int>(left > right) - static_cast<int>(left < right);
}

/// Leaves one of equal consecutive points; the first follows the last.
Point* without_repeats(Point* first, Point* last) noexcept {
    last = std::unique(first, last);
    while (last - first > 1 && *(last - 1) == *first) {
        --last;
    }
    return last;
}

}  // namespace

void RawOffset::measure_edges(std::span<const Point> contour) {
    const std::size_t count = contour.size();
    edges_.resize(count + 1);
    for (std::size_t i = 0; i < count; ++i) {
        const Point a = contour[i];
        const Point b = contour[i + 1 < count ? i + 1 : 0];
        const double dx = static_cast<double>(b.x) - a.x;
        const double dy = static_cast<double>(b.y) - a.y;
        const double length = std::sqrt(dx * dx + dy * dy);
        const double per_length = 1.0 / length;
        edges_[i + 1] = {dx * per_length, dy * per_length, length};
    }
    edges_[0] = edges_[count];
}

/// All corners as if they were within the limit. Returns the least 1 + cos theta.
double RawOffset::measure_corners(std::span<const Point> contour, double distance) {
    const std::size_t count = contour.size();
    corners_.resize(count + 1);
    miters_.resize(count);
    double least = 2.0;
    for (std::size_t i = 0; i < count; ++i) {
        const Edge& in = edges_[i];
        const Edge& out = edges_[i + 1];
        const double cosine1 = 1.0 + (in.ux * out.ux + in.uy * out.uy);
        const double scale = distance / std::max(cosine1, sharpest_cosine1);
        corners_[i] = {scale * (in.ux * out.uy - in.uy * out.ux), cosine1};
        miters_[i] = rounded(contour[i].x + scale * (in.uy + out.uy), contour[i].y - scale * (in.ux + out.ux));
        least = std::min(least, cosine1);
    }
    return least;
}

/// Corners beyond the limit: what cut ones add, and which inner ones are cut on the way back. The sign of a turn of about 180
/// degrees is lost in rounding, so that it comes from the points.
void RawOffset::settle_sharp_corners(std::span<const Point> contour, const Shape& shape, RawCurve& curve) {
    const std::size_t count = contour.size();
    for (std::size_t i = 0; i < count; ++i) {
        Corner& corner = corners_[i];
        if (corner.cosine1 >= shape.least_cosine1) {
            continue;
        }
        const int turn = turn_sign(contour[i > 0 ? i - 1 : count - 1], contour[i], contour[i + 1 < count ? i + 1 : 0]);
        if (turn * shape.distance < 0) {
            curve.reflex_cut = true;
            corner.added = corner.cosine1 < sharpest_cosine1 ? -beyond_any_edge : corner.added;
        } else {  // tan(theta / 4) = sin(theta / 2) / (1 + cos(theta / 2))
            const double cosine1 = std::max(corner.cosine1, 0.0);
            corner.added = std::abs(shape.distance) * std::sqrt(2.0 - cosine1) / (std::sqrt(2.0) + std::sqrt(cosine1));
        }
    }
}

bool RawOffset::keeps_direction(std::size_t edge) const noexcept {
    return edges_[edge + 1].length + (corners_[edge].added + corners_[edge + 1].added) > 0;
}

Point* RawOffset::write_corner(Point v, std::size_t corner, const Shape& shape, Point* out) const {
    const Corner& at = corners_[corner];
    const Edge& before = edges_[corner];
    const Edge& after = edges_[corner + 1];
    const double d = shape.distance;
    const bool outer = at.added >= 0;
    const std::size_t edge_before = corner > 0 ? corner - 1 : edges_.size() - 2;
    if (outer ? at.cosine1 >= shape.least_cosine1 : keeps_direction(edge_before) && keeps_direction(corner)) {
        *out++ = miters_[corner];
        return out;
    }
    const double beyond = outer ? at.added : 0.0;
    *out++ = rounded(v.x + (d * before.uy + beyond * before.ux), v.y + (beyond * before.uy - d * before.ux));
    if (!outer) {
        *out++ = v;
    }
    *out++ = rounded(v.x + (d * after.uy - beyond * after.ux), v.y - (beyond * after.uy + d * after.ux));
    return out;
}

RawCurve RawOffset::append(std::span<const Point> contour, double distance, double miter_limit) {
    const Shape shape{distance, std::max(2.0 / (miter_limit * miter_limit), sharpest_cosine1)};
    const std::size_t count = contour.size();
    RawCurve curve;
    curve.first_point = points_.size();
    points_.resize(points_.size() + 3 * count);
    measure_edges(contour);
    const bool sharp = measure_corners(contour, distance) < shape.least_cosine1;
    if (sharp) {
        settle_sharp_corners(contour, shape, curve);
    }
    corners_[count] = corners_[0];
    for (std::size_t i = 0; i < count; ++i) {
        curve.directions_kept = curve.directions_kept && keeps_direction(i);
    }
    Point* const first = points_.data() + curve.first_point;
    Point* last = first;
    if (!sharp && curve.directions_kept) {
        last = std::copy(miters_.begin(), miters_.end(), first);
    } else {
        for (std::size_t i = 0; i < count; ++i) {
            last = write_corner(contour[i], i, shape, last);
        }
    }
    curve.beyond_grid = std::any_of(first, last, is_beyond);
    last = without_repeats(first, last);
    curve.count = last - first < 3 ? 0 : static_cast<std::size_t>(last - first);
    points_.resize(curve.first_point + curve.count);
    return curve;
}

}  // namespace lamella
