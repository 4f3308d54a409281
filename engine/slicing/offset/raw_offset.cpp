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

/// The length that an inner corner too sharp to trim takes off: longer than any edge.
constexpr double beyond_any_edge = 1e12;

bool reach_beyond_grid(const Point* first, const Point* last) noexcept {
    std::int32_t highest = 0;
    std::int32_t lowest = 0;
    for (; first != last; ++first) {
        highest = std::max(highest, std::max(first->x, first->y));
        lowest = std::min(lowest, std::min(first->x, first->y));
    }
    return highest > grid_limit || lowest < -grid_limit;
}

/// Where two edges around `v` meet that lie at the distance, by their normals.
Point meeting_of(Point v, double distance, Direction a, Direction b) noexcept {
    const double scale = distance / (1.0 + (a.x * b.x + a.y * b.y));
    return moved_on_grid(v, scale * (a.x + b.x), scale * (a.y + b.y));
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

/// Corners beyond the limit: what cut ones add, and which inner ones are cut on the way back. The sign of a turn of about
/// 180 degrees is lost in rounding, so that it comes from the points. Returns how many points arcs have beyond two a
/// corner.
std::size_t RawOffset::settle_sharp_corners(std::span<const Point> contour, const Shape& shape, RawCurve& curve) {
    const std::size_t count = contour.size();
    std::size_t arc_points = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (corners_.cosine1[i] >= shape.least_cosine1) {
            continue;
        }
        const int turn = side_of(contour[i > 0 ? i - 1 : count - 1], contour[i], contour[i + 1 < count ? i + 1 : 0]);
        if (turn * shape.distance < 0) {
            curve.reflex_cut = true;
            corners_.added[i] = corners_.cosine1[i] < sharpest_cosine1 ? -beyond_any_edge : corners_.added[i];
        } else if (shape.is_round(i)) {
            corners_.added[i] = 0;  // at least
            arc_points += arc_at(i, shape).count;
        } else if (shape.is_end(i)) {
            corners_.added[i] = shape.corners.end == End::square ? shape.distance : 0;
        } else {  // tan(theta / 4) = sin(theta / 2) / (1 + cos(theta / 2))
            const double cosine1 = std::max(corners_.cosine1[i], 0.0);
            corners_.added[i] = std::abs(shape.distance) * std::sqrt(2.0 - cosine1) / (std::sqrt(2.0) + std::sqrt(cosine1));
        }
    }
    return arc_points;
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

Point* RawOffset::write_corner(std::span<const Point> contour, std::size_t corner, const Shape& shape, Point* out) const {
    if (!is_cut(corner, shape)) {
        *out++ = corners_.miter[corner];
        return out;
    }
    const Point v = contour[corner];
    if (shape.is_round(corner)) {
        return write_arc(v, corner, shape, out);
    }
    const double d = shape.distance;
    const double beyond = corners_.added[corner];
    const double ux1 = edges_.ux[corner];
    const double uy1 = edges_.uy[corner];
    const double ux2 = edges_.ux[corner + 1];
    const double uy2 = edges_.uy[corner + 1];
    *out++ = moved_on_grid(v, d * uy1 + beyond * ux1, beyond * uy1 - d * ux1);
    *out++ = moved_on_grid(v, d * uy2 - beyond * ux2, -(beyond * uy2 + d * ux2));
    return out;
}

/// Where edges with neighbouring normals meet, from that of the edge before the corner to that of the next.
Point* RawOffset::write_arc(Point v, std::size_t corner, const Shape& shape, Point* out) const {
    const ArcDirections& arcs = *shape.corners.arcs;
    const ArcDirections::Between between = arc_at(corner, shape);
    const bool forwards = shape.distance > 0;
    Direction last = normal_of(corner, false, shape.distance);
    for (std::size_t i = 0; i <= between.count; ++i) {
        const std::size_t at = between.first + (forwards ? i : between.count - 1 - i);
        const Direction next = i < between.count ? arcs[at] : normal_of(corner, true, shape.distance);
        *out++ = meeting_of(v, std::abs(shape.distance), last, next);
        last = next;
    }
    return out;
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
    const std::size_t arc_points = sharp ? settle_sharp_corners(contour, shape, curve) : 0;
    corners_.added[count] = corners_.added[0];
    curve.directions_kept = keep_directions(count);
    if (!curve.directions_kept) {
        list_moving(contour, shape);
        moving_.move(std::abs(shape.distance), points_);
        return finish(curve, points_.data() + points_.size());
    }
    points_.resize(points_.size() + 2 * count + arc_points);
    Point* last = points_.data() + curve.first_point;
    if (!sharp) {
        last = std::copy(corners_.miter, corners_.miter + count, last);
    } else {
        for (std::size_t i = 0; i < count; ++i) {
            last = write_corner(contour, i, shape, last);
        }
    }
    return finish(curve, last);
}

bool RawOffset::fold(double distance, Vector<Point>& points, Vector<std::uint32_t>& numbers) const {
    return moving_.fold(std::abs(distance), points, numbers);
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

RawCurve RawOffset::finish(RawCurve curve, Point* last) {
    Point* const first = points_.data() + curve.first_point;
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
    points_.resize(points_.size() + edges);
    Point* out = points_.data() + curve.first_point;
    for (std::size_t i = 0; i < edges; ++i) {
        const std::size_t step = corners.arcs->size() / edges;
        *out++ = meeting_of(at, distance, (*corners.arcs)[i * step], (*corners.arcs)[(i + 1) * step]);
    }
    return finish(curve, out);
}

}  // namespace lamella
