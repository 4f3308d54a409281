// The edges of a contour on their way sideways: one that shrinks to a point goes, and its neighbours meet from then on.
//
//     a                     d     A notch, whose edges move into it. The floor's edge, from b to c, is a point when it has
//      \  .               .  /      come up to `o`, and goes. Those of the walls go on, until they meet at `x`. With the
//       \   ` .       . '   /       floor, the curve would cross itself there, and then run along the floor backwards.
//        \      ` x '      /
//         \       o       /
//          b-------------c
//
// Each moved edge is a stretch of its line, moved: from `begin` to `end` along it, which change at a steady rate between two
// events. The edge goes when both are equal. The next event comes from a heap.
//
// The contour is folded if edges that are gone are left out of it, and their neighbours run on to where their lines meet,
// here below the floor: moved, it becomes the same curve.
//
// Where the neighbours of such an edge do not meet, as the parallel walls of a slot do not, its corners become joints: from
// there on, edges move as if their ends were free, and the curve goes from one end back to the corner and out to the other.
// Loops at joints, and where edges meet that are no neighbours, are left to the overlay (see raw_offset.hpp).
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "slicing/offset/arc_directions.hpp"

namespace lamella {

/// The nearest point of the grid; beyond it, the nearest of those just outside. Rounds what is added, so that it does not
/// depend on where a contour stands, but for odd shifts of ties.
Point moved_on_grid(Point from, double x, double y) noexcept;

/// The number of a point that is none of the contour's.
inline constexpr std::uint32_t no_point = 0xffffffff;

/// One contour after another; scratch is kept. One per thread.
class MovingEdges {
public:
    explicit MovingEdges(Worker& worker) noexcept : worker_(worker) {}

    /// For the next contour. `outwards`: edges move to their right, else to their left.
    void clear(bool outwards) noexcept;
    /// For so many edges at least.
    void reserve(std::size_t edges) { edges_.reserve(edges); }
    /// The next edge: from `from` on in a direction, a unit vector. `point`: which of the contour's points that is; `miter`:
    /// where it meets the edge before if both move and neither goes. `shrinks`: the corner there is an inner one, at which
    /// edges become shorter.
    void add(Point from, std::uint32_t point, Direction along, double length, Point miter, bool shrinks);
    /// One of no length, at a corner. `stands`: it does not move, and edges before and after it end beside it.
    void add_at(Point corner, Direction along, bool stands = false);
    /// Moves all by a distance above 0, and appends where they are then: nothing if fewer than three are left. True if no
    /// edge shrank to a point. O(e log e) for e edges. Throws std::bad_alloc.
    bool move(double distance, Vector<Point>& points);
    /// Appends the contour as folded by move(), rounded, and of each point which it was, or no_point. False, with some
    /// appended, where there are joints, where a folded corner lies beyond the grid or beside a cut or an arc, or where an
    /// edge to it is so short that rounding turns it or leaves none.
    bool fold(Vector<Point>& points, Vector<std::uint32_t>& numbers) const;

private:
    enum class Corner : std::uint8_t { given, met, joint };

    /// A stretch of a moved line. Numbers are of the distance 0, and what they grow by for each unit of it.
    struct Edge {
        Point from;  ///< lengths along the edge count from here
        Point miter;
        Direction along;
        double begin = 0;
        double end = 0;
        double begin_rate = 0;
        double end_rate = 0;
        double vanishes = 0;
        double joint_since = 0;
        std::uint32_t point = no_point;
        std::uint32_t before = 0;
        std::uint32_t after = 0;
        Corner corner = Corner::given;  ///< at its begin
        bool shrinks = false;
        bool stands = false;
    };
    struct Event {
        double distance;
        std::uint32_t edge;
        friend bool operator>(const Event& a, const Event& b) noexcept {
            return a.distance != b.distance ? a.distance > b.distance : a.edge > b.edge;
        }
    };

    Direction normal_of(const Edge& edge) const noexcept;
    double growth(const Edge& before, const Edge& after) const noexcept;
    void set_rates(Edge& before, Edge& after, double rate, double at) const noexcept;
    void schedule(std::uint32_t number, double now);
    bool neighbours_meet(const Edge& edge) const noexcept;
    void take_off(std::uint32_t number, double at);
    void make_joint(std::uint32_t number, double at);
    Point place_on(const Edge& edge, double along, double distance) const noexcept;
    template <class Take>
    void each_left(Take take) const;
    bool is_steady(const Edge& edge) const noexcept;
    void append_corner(const Edge& edge, Vector<Point>& points) const;

    Worker& worker_;
    double side_ = 1;  // 1: to the right, -1: to the left
    double distance_ = 0;
    std::size_t left_ = 0;
    Vector<Edge> edges_{worker_.memory()};
    Vector<Event> events_{worker_.memory()};  // a heap; those of edges that have changed since are passed over
};

}  // namespace lamella
