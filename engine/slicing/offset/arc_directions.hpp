// The edges of round joins: directions at equal angles all around, the same for every corner.
//
//     An outer corner turns from the normal n1 to n2. The directions in between are normals of the arc's edges, which all
//     lie at the distance from v. So the arc lies outside its circle, and within the tolerance of it:
//
//                u1
//           n1    .--.    u2         points:  where n1 and u1 meet, u1 and u2, u2 and n2
//             .--'    '--.
//             |           \  n2
//             |      v     |
//
// Directions come by halving angles: only + - * / and sqrt, the same bytes on every platform.
#pragma once

#include <cstddef>

#include "base/vector.hpp"
#include "lamella/context.hpp"

namespace lamella {

struct Direction {
    double x, y;
};

class ArcDirections {
public:
    /// The finest tolerance that is possible is this share of the distance.
    static constexpr double least_tolerance = 3e-7;

    explicit ArcDirections(const Memory* memory) noexcept : quarter_(memory) {}

    /// As few as keep arcs within the tolerance: a power of two, from 8 to 4096. Both in one unit; the tolerance at least
    /// least_tolerance times the distance. Throws std::bad_alloc.
    void fit(double distance, double tolerance);

    std::size_t size() const noexcept { return 4 * (quarter_.size() - 1); }
    /// The one at i times the angle between two, counted on past a full turn.
    Direction operator[](std::size_t i) const noexcept;
    /// Those strictly between two unit vectors, counter-clockwise from `first`, at most half a turn apart: the index of the
    /// first, and how many.
    struct Between {
        std::size_t first, count;
    };
    Between between(Direction first, Direction last) const noexcept;

private:
    std::size_t last_before(Direction at) const noexcept;

    Vector<Direction> quarter_;  // from (1, 0) to (0, 1)
};

}  // namespace lamella
