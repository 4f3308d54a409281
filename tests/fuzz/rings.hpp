// Rings on small lattices and over the whole grid, drawn from the fuzzer's bytes.
#pragma once

#include "bytes.hpp"
#include "engine/region_checks.hpp"

namespace fuzz {

using Ring = regions::Polygon;
using Rings = regions::Polygons;
using lamella::grid_limit;
using lamella::Point;

constexpr double unit_mm = 1;  // lengths are in units

/// Where coordinates lie: steps of a lattice, with or without a few units added.
struct Lattice {
    std::int32_t step;
    std::int32_t half_width;  // in steps
    bool loose;

    std::int32_t coordinate(Bytes& bytes) const {
        const unsigned byte = bytes.next();
        const auto steps = static_cast<std::int32_t>(byte % static_cast<unsigned>(2 * half_width + 1)) - half_width;
        const std::int32_t more = loose ? static_cast<std::int32_t>(bytes.below(7)) - 3 : 0;
        return std::clamp(steps * step + more, -grid_limit, grid_limit);
    }
};

inline Lattice drawn_lattice(Bytes& bytes) {
    constexpr Lattice lattices[] = {{1, 4, false},   {1, 100, false},     {1 << 28, 4, false},  {1 << 28, 4, true},
                                    {1000, 8, true}, {1 << 16, 40, true}, {1 << 23, 100, true}, {1 << 30, 1, true}};
    return lattices[bytes.below(8)];
}

/// Every coordinate drawn; or one only changed, so that edges are upright and level; or the way back along a spike.
inline Ring drawn_ring(Bytes& bytes, const Lattice& lattice) {
    Ring ring;
    const unsigned shape = bytes.next();
    const std::size_t count = 1 + shape % 16;
    for (std::size_t i = 0; i < count; ++i) {
        Point p{lattice.coordinate(bytes), lattice.coordinate(bytes)};
        if (shape >= 192 && !ring.empty()) {
            (i % 2 == 0 ? p.x : p.y) = i % 2 == 0 ? ring.back().x : ring.back().y;
        }
        ring.push_back(p);
    }
    if (shape >= 96 && shape < 128) {
        ring.insert(ring.end(), ring.rbegin(), ring.rend());
    }
    if (shape >= 64 && shape < 96) {
        ring.insert(ring.end(), ring.begin(), ring.end());
    }
    return ring;
}

/// What rounding may move: a few units along every edge.
inline double rounding_along(const Rings& rings) {
    return 5 * (regions::perimeter_of(rings) + 20);
}

}  // namespace fuzz
