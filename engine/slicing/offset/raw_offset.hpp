// Raw offset curves: closed contours moved sideways edge by edge. They may cross themselves and each other; the overlay
// takes their loops away by the positive rule.
//
// An edge of length L with unit direction u moves by d n, where n points to its right, out of the solid. A positive distance
// d dilates, a negative one erodes. At a corner v with a turn of theta (to the left: positive; t = tan(theta / 2)) the moved
// edges become longer by d t each, or shorter where that is negative.
//
//     outer corner, d t >= 0         beyond the limit: cut           inner corner, d t < 0
//
//         solid  |   :                   solid  |   :                     solid
//                |   :                          |   :               --------. v
//        --------. v :                  --------. v :                       |
//                    :                             .                - - . m |  solid
//        - - - - - - . m                - - - - .                       :   |
//
//  - Outer: the miter m = v + d (n1 + n2) / (1 + cos theta), if |m - v| <= limit |d|. Beyond the limit two points, where the
//    moved edges are cut across the bisector at distance |d| from v: |d| tan(|theta| / 4) beyond their ends. Or an arc: see
//    arc_directions.hpp.
//  - Inner: the same point m if all edges of the contour keep their direction, that is, if L and what the two ends add are
//    positive together. Otherwise edges that shrink to a point go on the way: see moving_edges.hpp.
//  - A spike, a turn of 180 degrees, counts as outer, as it looks alike from both sides: solid needs the cut, and what the
//    cut of a slit adds lies within 1.42 |d| of its end.
//
// Why the positive rule gives the offset region. Let d > 0. While the distance grows from 0 to d, each edge adds 1 to the
// winding number of each point that it passes over, and nothing takes any away. The numbers of a layer's contours are 1 in
// solid and 0 outside: in the end they are positive in solid and in what edges have passed over, and nowhere else. For d < 0
// edges take away 1 each: only solid that none has passed over stays positive.
//  - An edge passes over no more than its rectangle, up to the moved edge, and the wedges from its outer corners to their
//    miters: corners between edges that have met on the way are inner ones.
//  - Every point within the distance is passed over. Take one outside, and the point of the contour nearest to it. That lies
//    on an edge, which comes nearer at unit speed, or at a corner between two such edges, which comes no slower. So the
//    point is reached by the time that equals its distance.
// So the region lies between all that is within the distance and all rectangles and wedges together; it lacks wedges of
// edges that were gone before the distance. Tested at random places around random polygons, most of them next to the curve.
//
// Which contours closing leaves alone. If all edges keep their direction, and no inner corner passes the limit, then the
// curve's own curve at -d is the contour, in exact arithmetic:
//  - A moved edge has the direction of its edge. Moved back, it lies on the edge's line again.
//  - An inner corner is an outer one of the curve, with the same turn and within the limit: its miter is where the lines of
//    its two edges meet, v.
//  - An outer corner is an inner one of the curve. It is trimmed, as edges get their lengths L > 0 back: again v. A cut
//    corner is two inner ones; the edge between them goes back to the line through v and to length 0: both are v.
// If, besides, the curves of a layer meet neither themselves nor each other and nest as the contours do, then they bound the
// dilated region, and eroding that gives the contours. So closing changes contours only where curves meet, where an edge is
// turned round, or where an inner corner passes the limit.
//
// A line is walked there and back, so that all of the above holds: the curve's winding numbers are how many edges have
// passed over a point. At its two ends, which are spikes, it is cut at v (butt), at the distance beyond (square), or round.
//
// Points are rounded to the nearest of the grid. Only + - * / and sqrt, in a fixed order: the same bytes on every platform.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "lamella/overlay.hpp"
#include "slicing/offset/arc_directions.hpp"
#include "slicing/offset/moving_edges.hpp"

namespace lamella {

/// 1 + cos theta of a turn whose miter is 1,000 distances long. The miters of sharper corners are not computed: too few
/// digits of them would be right.
inline constexpr double sharpest_cosine1 = 2e-6;

/// Edge i runs from corner i to corner i + 1 and stands at i + 1; the last one stands at 0 too.
struct OffsetEdges {
    double* ux;  ///< unit direction
    double* uy;
    double* length;
};

struct OffsetCorners {
    double* added;    ///< to the length of both moved edges; negative at an inner corner, 0 at an outer one beyond the limit
    double* cosine1;  ///< 1 + the cosine of the turn
    Point* miter;
};

/// What outer corners and the ends of lines become. `arcs` fits the distance, where
/// something is round or a line.
struct Corners {
    double limit = 3;  ///< a longer miter, in distances, is cut or rounded; at least 1, counts as 1,000 if it is more
    bool round = false;
    End end = End::region;
    const ArcDirections* arcs = nullptr;
};

/// The curve of one contour.
struct RawCurve {
    std::size_t first_point = 0;  ///< index into the points of all curves since clear()
    std::size_t count = 0;        ///< consecutive points differ; 0 if fewer than three are left, which enclose nothing
    bool directions_kept = true;  ///< every edge, moved and trimmed, keeps its direction
    bool reflex_cut = false;      ///< an inner corner passes the miter limit: the way back would cut it
    bool beyond_grid = false;     ///< a point lies beyond grid_limit: the points are not to be used
};

/// One per thread; scratch is kept.
class RawOffset {
public:
    explicit RawOffset(Worker& worker) noexcept : worker_(worker) {}

    /// Forgets the curves: for the next layer.
    void clear() noexcept { points_.clear(); }

    /// Appends the curve of a closed contour, solid on the left, from any of its points on; the first is not repeated.
    /// `distance`: grid units, finite, at most 2 grid_limit either way. Precondition: three points or more, consecutive ones
    /// differ. At most three points an edge, but for arcs; O(e log e) for e edges and those of arcs. Throws std::bad_alloc.
    RawCurve append(std::span<const Point> contour, double distance, const Corners& corners);

    /// Appends the curve around an open line, as wide as twice the distance, which is above 0. Precondition: one point or
    /// more.
    RawCurve append_line(std::span<const Point> line, double distance, const Corners& corners);

    /// For the contour that append() had last, some edges of which did not keep their direction: as MovingEdges::fold().
    bool fold(Vector<Point>& points, Vector<std::uint32_t>& numbers) const { return moving_.fold(points, numbers); }

    std::span<Point> points_of(const RawCurve& curve) noexcept {
        return std::span(points_).subspan(curve.first_point, curve.count);
    }

private:
    struct Shape {
        const Corners& corners;
        double distance;
        std::size_t far_end = 0;  ///< a line's corners 0 and far_end are ends; 0: it is none
        double least_cosine1 = std::max(2.0 / (corners.limit * corners.limit), sharpest_cosine1);  ///< of a miter

        bool is_end(std::size_t corner) const noexcept { return far_end != 0 && (corner == 0 || corner == far_end); }
        bool is_round(std::size_t corner) const noexcept {
            return is_end(corner) ? corners.end == End::round : corners.round;
        }
    };

    void reserve(std::size_t count);
    RawCurve append(std::span<const Point> contour, const Shape& shape);
    RawCurve append_dot(Point at, double distance, const Corners& corners);
    void settle_sharp_corners(std::span<const Point> contour, const Shape& shape, RawCurve& curve);
    bool keeps_direction(std::size_t edge) const noexcept {
        return edges_.length[edge + 1] + (corners_.added[edge] + corners_.added[edge + 1]) > 0;
    }
    bool keep_directions(std::size_t count) const noexcept;
    /// An outer corner that is more than a miter.
    bool is_cut(std::size_t corner, const Shape& shape) const noexcept {
        return corners_.added[corner] >= 0 && corners_.cosine1[corner] < shape.least_cosine1;
    }
    void list_moving(std::span<const Point> contour, const Shape& shape);
    ArcDirections::Between arc_at(std::size_t corner, const Shape& shape) const noexcept;
    Direction normal_of(std::size_t corner, bool next, double distance) const noexcept;
    RawCurve finish(RawCurve curve);

    Worker& worker_;
    Vector<double> numbers_{worker_.memory()};  // what edges_ and corners_ point to
    Vector<Point> miters_{worker_.memory()};
    OffsetEdges edges_{};
    OffsetCorners corners_{};  // the first stands at the end too
    MovingEdges moving_{worker_};
    Vector<Point> line_{worker_.memory()};  // there and back
    Vector<Point> points_{worker_.memory()};
};

}  // namespace lamella
