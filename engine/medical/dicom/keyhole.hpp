// An outer contour and its holes as one ring.
//
// From the leftmost point M of each hole a bridge runs left to the nearest point B of another contour of the region, and is
// walked both ways:
//
//     .----------.
//     |   .--.   |
//     B===M  |   |        ... B M (around the hole) M B ...
//     |   '--'   |
//     '----------'
//
// A bridge meets nothing between its ends, since B is the nearest point; and two bridges never meet, since all are
// horizontal and the nearer hole would be the other's nearest. Each leads to a contour that begins farther left, so that the
// bridges form a tree with the outer contour at its root. A bridge has no area: the ring's area is the region's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lamella/result.hpp"

namespace lamella {

/// In grid units. The end B of a bridge within an edge has no whole x.
struct RingPoint {
    double x = 0;
    double y = 0;
    friend bool operator==(const RingPoint&, const RingPoint&) = default;
};

class Keyhole {
public:
    /// `contours`: closed ones of one layer, an outer one first, then its holes, none of which crosses another; they may
    /// touch. Gives the ring, whose first point is not repeated, valid until the next call. A hole that lies in no contour
    /// is left out. h holes, q points: O(q log h) and what lies at equal heights; at most O(q h).
    std::span<const RingPoint> join(std::span<const std::span<const Point>> contours);

private:
    /// The end of a bridge, B.
    struct Bridge {
        std::uint32_t hole = 0;
        std::uint32_t contour = 0;
        std::uint32_t vertex = 0;  ///< where the edge begins that B lies on
        bool at_vertex = false;
        bool within = false;  ///< at a vertex: the bridge runs through the region there
        // x of B: whole + rest / divisor, with 0 <= rest < divisor
        std::int64_t whole = 0;
        std::int64_t rest = 0;
        std::int64_t divisor = 0;  ///< 0: none was found yet

        double x() const noexcept {
            return static_cast<double>(whole) + static_cast<double>(rest) / static_cast<double>(divisor);
        }
    };

    void start_bridges();
    bool begins_farther_left(std::uint32_t contour, std::uint32_t hole) const noexcept;
    void find_ends(std::uint32_t contour);
    void offer(Bridge& bridge, const Bridge& end) const;
    void sort_bridges();
    void emit_ring();
    void put(RingPoint point);
    Point point(std::uint32_t contour, std::size_t vertex) const noexcept {
        return contours_[contour][vertex % contours_[contour].size()];
    }

    std::span<const std::span<const Point>> contours_;
    std::vector<Bridge> bridges_;        ///< of holes
    std::vector<std::int32_t> heights_;  ///< of `bridges_`, ascending
    std::vector<std::uint32_t>
        first_from_;  ///< of each contour: its first bridge end in `bridges_`, once sorted for the ring
    std::vector<RingPoint> ring_;
};

}  // namespace lamella
