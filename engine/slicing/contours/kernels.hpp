// The loops over every point or edge of every layer, in forms for several instruction sets. All forms give the same bytes:
// the same operations in the same order, without contraction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/dispatch.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella {

/// The active edges of a plane, one array per quantity: edge e passes through (x, y) at height z and moves by (slope_x,
/// slope_y) per unit of height. All in grid units.
struct EdgeArrays {
    const std::int32_t* x;
    const std::int32_t* y;
    const std::int32_t* z;
    const double* slope_x;
    const double* slope_y;
};

struct Kernels {
    /// points[e] = where edge e pierces the plane at height z, for e in [0, count), as pierced_point() says. Arrays are
    /// readable, and points writable, up to the next multiple of padded_count.
    void (*pierce)(const EdgeArrays& edges, std::int32_t z, std::size_t count, Point* points);
    /// ring[i] = points[slots[i]] for i in [0, count), count > 0, and the facts of the closed ring that this makes. `slots`
    /// is readable, with numbers below the number of points, and `ring` writable up to the next multiple of padded_count.
    RingFacts (*trace)(const Point* points, const std::uint32_t* slots, std::size_t count, Point* ring);
    /// Writes to `indices` the i in [0, count), in ascending order, with values[i] == value; returns how many. `indices` is
    /// writable up to count + select_padding.
    std::size_t (*select_equal)(const std::uint32_t* values, std::size_t count, std::uint32_t value, std::uint32_t* indices);
};

/// Arrays handed to pierce() and trace() are padded to a multiple of it.
inline constexpr std::size_t padded_count = 8;
/// select_equal() may write so many elements beyond those that it finds.
inline constexpr std::size_t select_padding = 16;

/// All forms, the fastest first.
std::span<const Form<Kernels>> kernel_forms() noexcept;

}  // namespace lamella
