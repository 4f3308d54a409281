#include "slicing/offset/raw_offset.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

/// count + 1 edges. Precondition: consecutive points differ.
void measure_edges(const Point* points, std::size_t count, const OffsetEdges& edges) {
    for (std::size_t i = 0; i < count; ++i) {
        const Point a = points[i];
        const Point b = points[i + 1 < count ? i + 1 : 0];
        const double dx = static_cast<double>(b.x) - a.x;
        const double dy = static_cast<double>(b.y) - a.y;
        const double length = std::sqrt(dx * dx + dy * dy);
        const double per_length = 1.0 / length;
        edges.ux[i + 1] = dx * per_length;
        edges.uy[i + 1] = dy * per_length;
        edges.length[i + 1] = length;
    }
    edges.ux[0] = edges.ux[count];
    edges.uy[0] = edges.uy[count];
    edges.length[0] = edges.length[count];
}

/// `count` corners, as if none passed the limit. Returns the least 1 + cos theta.
double measure_corners(const Point* points, std::size_t count, const OffsetEdges& edges, double distance,
                       const OffsetCorners& corners) {
    double least = 2;
    for (std::size_t i = 0; i < count; ++i) {
        const double ux1 = edges.ux[i];
        const double uy1 = edges.uy[i];
        const double ux2 = edges.ux[i + 1];
        const double uy2 = edges.uy[i + 1];
        const double cosine1 = 1.0 + (ux1 * ux2 + uy1 * uy2);
        const double scale = distance / std::max(cosine1, sharpest_cosine1);
        corners.added[i] = scale * (ux1 * uy2 - uy1 * ux2);
        corners.cosine1[i] = cosine1;
        corners.miter[i] = moved_on_grid(points[i], scale * (uy1 + uy2), -scale * (ux1 + ux2));
        least = std::min(least, cosine1);
    }
    return least;
}

/// 1 + cos theta, rounded, of a turn of 180 degrees is less.
constexpr double spike_cosine1 = 1e-12;

bool reach_beyond_grid(const Point* first, const Point* last) noexcept {
    std::int32_t highest = 0;
    std::int32_t lowest = 0;
    for (; first != last; ++first) {
        highest = std::max(highest, std::max(first->x, first->y));
        lowest = std::min(lowest, std::min(first->x, first->y));
    }
    return highest > grid_limit || lowest < -grid_limit;
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

/// Makes room for the edges and corners of `count` points.
void RawOffset::reserve(std::size_t count) {
    const std::size_t each = count + 1;
    if (numbers_.size() < 5 * each) {
        numbers_.resize(5 * each);
        miters_.resize(each);
    }
    double* const at = numbers_.data();
    edges_ = {at, at + each, at + 2 * each};
    corners_ = {at + 3 * each, at + 4 * each, miters_.data()};
}

/// The normal of the edge before a corner, or of the next, towards the side that edges move to.
Direction RawOffset::normal_of(std::size_t corner, bool next, double distance) const noexcept {
    const std::size_t at = corner + (next ? 1 : 0);
    return distance > 0 ? Direction{edges_.uy[at], -edges_.ux[at]} : Direction{-edges_.uy[at], edges_.ux[at]};
}

/// Corners beyond the limit: outer ones make no edge shorter, and inner ones are cut on the way back. The sign of a turn of
/// about 180 degrees is lost in rounding, so that it comes from the points.
void RawOffset::settle_sharp_corners(std::span<const Point> contour, const Shape& shape, RawCurve& curve) {
    const std::size_t count = contour.size();
    for (std::size_t i = 0; i < count; ++i) {
        if (corners_.cosine1[i] < shape.least_cosine1) {
            const int turn = side_of(contour[i > 0 ? i - 1 : count - 1], contour[i], contour[i + 1 < count ? i + 1 : 0]);
            const bool inner = turn * shape.distance < 0;
            corners_.added[i] = inner ? -1 : 0;
            curve.reflex_cut = curve.reflex_cut || inner;
        }
    }
}

/// The directions between the normals of a round corner, counter-clockwise.
ArcDirections::Between RawOffset::arc_at(std::size_t corner, const Shape& shape) const noexcept {
    const bool forwards = shape.distance > 0;
    return shape.corners.arcs->between(normal_of(corner, !forwards, shape.distance),
                                       normal_of(corner, forwards, shape.distance));
}

bool RawOffset::keep_directions(std::size_t count) const noexcept {
    std::size_t turned = 0;
    for (std::size_t i = 0; i < count; ++i) {
        turned += keeps_direction(i) ? 0 : 1;
    }
    return turned == 0;
}

RawCurve RawOffset::append(std::span<const Point> contour, double distance, const Corners& corners) {
    return append(contour, {corners, distance});
}

RawCurve RawOffset::append(std::span<const Point> contour, const Shape& shape) {
    const std::size_t count = contour.size();
    reserve(count);
    RawCurve curve;
    curve.first_point = points_.size();
    measure_edges(contour.data(), count, edges_);
    const bool sharp = measure_corners(contour.data(), count, edges_, shape.distance, corners_) < shape.least_cosine1;
    corners_.added[count] = corners_.added[0];
    if (!sharp && keep_directions(count)) {
        points_.insert(points_.end(), corners_.miter, corners_.miter + count);
        return finish(curve);
    }
    if (sharp) {
        settle_sharp_corners(contour, shape, curve);
    }
    list_moving(contour, shape);
    curve.directions_kept = moving_.move(std::abs(shape.distance), points_);
    return finish(curve);
}

/// The edges of the contour, and at outer corners beyond the limit those of the cut or the arc.
void RawOffset::list_moving(std::span<const Point> contour, const Shape& shape) {
    const bool outwards = shape.distance > 0;
    const double side = outwards ? 1 : -1;
    moving_.clear(outwards);
    moving_.reserve(contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const Point v = contour[i];
        const Direction before{edges_.ux[i], edges_.uy[i]};
        if (is_cut(i, shape) && shape.is_round(i)) {
            const ArcDirections& arcs = *shape.corners.arcs;
            const ArcDirections::Between between = arc_at(i, shape);
            for (std::size_t k = 0; k < between.count; ++k) {
                const Direction normal = arcs[between.first + (outwards ? k : between.count - 1 - k)];
                moving_.add_at(v, {-side * normal.y, side * normal.x});
            }
        } else if (is_cut(i, shape)) {  // half the turn on, to the left where it moves to the right
            const double half = corners_.cosine1[i] > spike_cosine1 ? corners_.cosine1[i] / 2 : 0;
            const double cosine = std::sqrt(half);
            const double sine = side * std::sqrt(1 - half);
            moving_.add_at(v, {cosine * before.x - sine * before.y, cosine * before.y + sine * before.x},
                           shape.is_end(i) && shape.corners.end == End::butt);
        }
        moving_.add(v, static_cast<std::uint32_t>(i), {edges_.ux[i + 1], edges_.uy[i + 1]}, edges_.length[i + 1],
                    corners_.miter[i], corners_.added[i] < 0);
    }
}

RawCurve RawOffset::finish(RawCurve curve) {
    Point* const first = points_.data() + curve.first_point;
    Point* last = points_.data() + points_.size();
    curve.beyond_grid = reach_beyond_grid(first, last);
    last = without_repeats(first, last);
    curve.count = last - first < 3 ? 0 : static_cast<std::size_t>(last - first);
    points_.resize(curve.first_point + curve.count);
    return curve;
}

RawCurve RawOffset::append_line(std::span<const Point> line, double distance, const Corners& corners) {
    line_.clear();
    std::unique_copy(line.begin(), line.end(), std::back_inserter(line_));
    if (line_.size() == 1) {
        return append_dot(line_[0], distance, corners);
    }
    const std::size_t far_end = line_.size() - 1;
    line_.reserve(2 * far_end);
    for (std::size_t i = far_end; i-- > 1;) {
        line_.push_back(line_[i]);
    }
    return append(line_, {corners, distance, far_end});
}

/// A line of no length has no sides, but its ends have edges on all sides.
RawCurve RawOffset::append_dot(Point at, double distance, const Corners& corners) {
    RawCurve curve;
    curve.first_point = points_.size();
    const std::size_t edges = corners.end == End::butt ? 0 : corners.end == End::square ? 4 : corners.arcs->size();
    for (std::size_t i = 0; i < edges; ++i) {
        const std::size_t step = corners.arcs->size() / edges;
        const Direction a = (*corners.arcs)[i * step];
        const Direction b = (*corners.arcs)[(i + 1) * step];
        const double scale = distance / (1.0 + (a.x * b.x + a.y * b.y));
        points_.push_back(moved_on_grid(at, scale * (a.x + b.x), scale * (a.y + b.y)));
    }
    return finish(curve);
}

}  // namespace lamella
