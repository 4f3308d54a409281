// Contours cut where they cross, with all points on the grid: snap rounding.
//
// Each vertex, that is each end of an edge and each crossing, is rounded to a grid point, whose pixel then is hot: the
// square of one unit around it, with its left and lower side. Each edge is bent to pass through the middle of every hot
// pixel that it meets:
//
//          . . . . . .          the crossing lies in the pixel of `o`. Both edges are bent to run through `o`, and so would
//         a-._   . _-d          be any other edge that meets its pixel, though it may cross neither.
//          . .`-o-'. .
//         c-'´ . `-. b
//
// Strands remain between vertices that meet nowhere but in vertices (Hobby 1999; Guibas and Marimont 1998):
// bending never moves an edge across a vertex. It can move an edge onto one, where the strand is cut without a further move.
// So every vertex lies within half a unit per axis of the exact one, and every point of a strand within half a unit of its
// edge.
//
// A point that comes near no edge but its own two is no vertex, since no other edge can pass its pixel: it stays a point
// within a strand. So most strands are long, and there are few.
//
//          --o-----.               a strand from crossing to crossing, with three points of the contour within
//             \     \  .
//              `-.---o--
//
// O((e + c + s) log (e + c)) for e edges that are near another, c crossings and s places where an edge passes a vertex;
// other edges cost a step each.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/edges/slab_search.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

// Which contours of a layer meet, and where, if a fill rule is asked for.

/// Two edges that are both moved by rounding, each by half a unit per axis, can touch where they come so near.
inline constexpr std::int32_t rounding_reach = 1;

/// True if `p` lies within `reach` of the edge from `a` to `b` on both axes; may be true somewhat farther away if
/// `reach` > 0.
bool is_near(Point p, Point a, Point b, std::int32_t reach) noexcept;

/// Where two edges cross, rounded: the grid point whose pixel, which is a unit wide and contains its left and lower side,
/// contains the crossing. `a` to `b` and `c` to `d` must cross there, in a single point, which is not `a`.
Point rounded_crossing(Point a, Point b, Point c, Point d) noexcept;

/// What of an edge and the point that it leaves comes near something else.
struct Nearness {
    bool edge = false;  ///< somewhere between its ends
    bool point = false;
};

/// Two contours meet where their edges come within rounding_reach of each other. A contour meets itself where two of its
/// edges have a common point that is not the end of one and the start of the next.
class Contacts {
public:
    explicit Contacts(Worker& worker) noexcept : worker_(worker) {}

    /// Compares closed contours. O(q log q) for q points whose edges lie apart, plus a step for each pair of
    /// edges with close boxes; where few of those come near, O(q log^2 q). Throws std::bad_alloc.
    void find(std::span<const NestItem> contours);

    /// True if the contour meets another or itself.
    bool meets(std::uint32_t contour) const noexcept { return meets_[contour] != 0; }
    bool any_meets() const noexcept { return any_meets_; }
    /// For each edge of a contour from its start, and the point that it leaves, what comes within rounding_reach of an edge
    /// of another contour, or of another run of its own, or at a sharp corner of the next one. Contours that meet nothing:
    /// without sharp corners.
    std::span<const Nearness> near(std::uint32_t contour) const noexcept {
        return std::span(near_).subspan(first_edges_[contour], first_edges_[contour + 1] - first_edges_[contour]);
    }
    /// Where edges cross, rounded; in no order, and as often as two cross there.
    std::span<const Point> crossings() const noexcept { return crossings_; }

private:
    bool meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j);
    struct EndsNear {
        bool any = false;
        bool between = false;  ///< not only to an end
    };

    void mark(const EdgePath& path, std::size_t edge, bool meets, bool bends) noexcept;
    EndsNear mark_ends(const EdgePath& path, std::size_t edge, Point a, Point b) noexcept;
    Nearness& near_at(const EdgePath& path, std::size_t edge) noexcept {
        return near_[first_edges_[path.contour] + (edge < path.edges() ? edge : edge - path.edges())];
    }
    void mark_sharp_corners(const EdgePath& path);

    Worker& worker_;
    EdgePairs pairs_{worker_};
    SlabSearch slabs_{worker_};                          // where boxes tell too little apart
    Vector<std::uint8_t> meets_{worker_.memory()};       // of each contour
    Vector<std::size_t> first_edges_{worker_.memory()};  // of each contour
    Vector<Nearness> near_{worker_.memory()};
    Vector<Point> crossings_{worker_.memory()};
    bool any_meets_ = false;
};

/// True if the edge from `a` to `b` meets the pixel of `p`.
bool passes_pixel(Point a, Point b, Point p) noexcept;

/// Leads from vertex to vertex, straight or over points of a contour.
struct Strand {
    std::uint32_t from;
    std::uint32_t to;
    std::int64_t times;     ///< contours that run from `from` to `to`, minus those that run back
    std::uint32_t contour;  ///< of a chain: number of the contour
    std::uint32_t first;    ///< of a chain: the edge that it begins with or within, from the contour's start
    std::uint32_t edges;    ///< 1: straight
    std::uint32_t part;     ///< of the contours along it, as Contour::part
    PointOrigin origin;     ///< of a straight one, from `from` to `to`: of the contour that stands for all along it

    bool is_chain() const noexcept { return edges > 1; }
};

/// One layer after another; scratch is kept. One per thread.
class SnapRounding {
public:
    explicit SnapRounding(Worker& worker) noexcept : worker_(worker) {}

    /// Forgets all contours.
    void clear() noexcept { contours_.clear(); }
    /// A closed contour that is there `times` times. near[i]: of edge i from the start, and of the point that it leaves.
    void add(const NestItem& contour, std::int64_t times, std::span<const Nearness> near) {
        contours_.push_back({&contour, times, near});
    }
    /// `crossings` are rounded ones of the contours. Throws std::bad_alloc.
    void run(std::span<const Point> crossings);

    /// Ascending.
    std::span<const Point> vertices() const noexcept { return vertices_; }
    /// Without those along which opposite contours cancel.
    std::span<const Strand> strands() const noexcept { return strands_; }
    bool any_cancelled() const noexcept { return any_cancelled_; }
    /// The i-th point: 0 is the first vertex, `edges` the last.
    Point point_of(const Strand& strand, std::uint32_t i) const noexcept {
        if (i == 0 || i == strand.edges) {
            return vertices_[i == 0 ? strand.from : strand.to];
        }
        const NestItem& item = *contours_[strand.contour].item;
        const std::size_t at = std::size_t{item.start} + strand.first + i;
        return item.points[at < item.count ? at : at - item.count];
    }
    /// The origin of edge i, from the first vertex on.
    PointOrigin origin_of(const Strand& strand, std::uint32_t i) const noexcept {
        if (!strand.is_chain()) {
            return strand.origin;
        }
        const NestItem& item = *contours_[strand.contour].item;
        const std::uint32_t edge = strand.first + i;
        return stretch_of(item.origin_from_start(edge), i > 0 || vertices_[strand.from] == item.from_start(edge),
                          i + 1 < strand.edges || vertices_[strand.to] == item.from_start(edge + 1));
    }

private:
    struct Source {
        const NestItem* item;
        std::int64_t times;
        std::span<const Nearness> near;

        bool may_bend(std::uint32_t edge) const noexcept;
        Point from(std::uint32_t edge) const noexcept { return item->from_start(edge); }
        Point to(std::uint32_t edge) const noexcept { return item->from_start(edge + 1); }
    };
    struct Found {
        Point point;
        std::uint32_t vertex;
    };
    /// Where a contour comes to a vertex: on an edge from the contour's start, or where that begins.
    struct Stop {
        std::uint32_t vertex;
        std::uint32_t edge;
        bool at_begin;
    };

    void collect_vertices(std::span<const Point> crossings);
    void add_strands_of(std::uint32_t contour);
    void find_passed(Point a, Point b);
    void add_strand(std::uint32_t contour, const Stop& from, const Stop& to);
    void add_straight(const Source& source, std::uint32_t from, std::uint32_t to, const PointOrigin& origin);
    std::uint32_t vertex_at(Point p) const noexcept;
    void sort_strands();
    void merge_strands();

    Worker& worker_;
    Vector<Source> contours_{worker_.memory()};
    Vector<Point> vertices_{worker_.memory()};
    PointTree tree_{worker_};
    Vector<Strand> strands_{worker_.memory()};
    Vector<Strand> sorted_{worker_.memory()};
    Vector<std::uint32_t> first_strands_{worker_.memory()};  // straight ones from each vertex on, in sorted_
    Vector<std::uint32_t> next_strands_{worker_.memory()};   // where the next one from each vertex goes
    Vector<Found> on_edge_{worker_.memory()};  // vertices that an edge passes between its ends, in its direction
    bool any_cancelled_ = false;
};

}  // namespace lamella
