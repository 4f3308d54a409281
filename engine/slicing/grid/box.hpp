// Boxes on the grid: of points in a plane, and of vertices in space.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "lamella/grid.hpp"

namespace lamella {

/// The smaller number of each axis, and the larger one.
constexpr Point low_corner(Point a, Point b) noexcept {
    return {std::min(a.x, b.x), std::min(a.y, b.y)};
}
constexpr Point high_corner(Point a, Point b) noexcept {
    return {std::max(a.x, b.x), std::max(a.y, b.y)};
}
constexpr GridVertex low_corner(const GridVertex& a, const GridVertex& b) noexcept {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
constexpr GridVertex high_corner(const GridVertex& a, const GridVertex& b) noexcept {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// True if `a` has the larger number of some axis.
constexpr bool exceeds(Point a, Point b) noexcept {
    return a.x > b.x || a.y > b.y;
}
constexpr bool exceeds(const GridVertex& a, const GridVertex& b) noexcept {
    return a.x > b.x || a.y > b.y || a.z > b.z;
}

/// A box with its boundary, between two corners.
template <class Corner>
struct GridBox {
    static constexpr std::size_t axes = sizeof(Corner) / sizeof(std::int32_t);

    Corner low;
    Corner high;

    /// Meets nothing, and becomes whatever is included.
    static constexpr GridBox nothing() noexcept {
        std::array<std::int32_t, axes> most{};
        std::array<std::int32_t, axes> least{};
        most.fill(std::numeric_limits<std::int32_t>::max());
        least.fill(std::numeric_limits<std::int32_t>::min());
        return {std::bit_cast<Corner>(most), std::bit_cast<Corner>(least)};
    }
    static constexpr GridBox around(const Corner& a, const Corner& b) noexcept {
        return {low_corner(a, b), high_corner(a, b)};
    }
    static constexpr GridBox around(std::span<const Corner> corners) noexcept {
        GridBox box = nothing();
        for (const Corner& corner : corners) {
            box.include({corner, corner});
        }
        return box;
    }

    constexpr void include(const GridBox& other) noexcept {
        low = low_corner(low, other.low);
        high = high_corner(high, other.high);
    }
    constexpr bool meets(const GridBox& other) const noexcept {
        return !exceeds(low, other.high) && !exceeds(other.low, high);
    }
    constexpr bool holds(const Corner& corner) const noexcept { return meets({corner, corner}); }

    /// The corners' numbers by axis.
    struct Numbers {
        std::array<std::int32_t, axes> low;
        std::array<std::int32_t, axes> high;
    };
    constexpr Numbers numbers() const noexcept { return std::bit_cast<Numbers>(*this); }

    friend constexpr auto operator<=>(const GridBox&, const GridBox&) = default;
};

using SpaceBox = GridBox<GridVertex>;
using FlatBox = GridBox<Point>;

constexpr std::int64_t width_of(const FlatBox& box) noexcept {
    return std::int64_t{box.high.x} - box.low.x;
}
constexpr std::int64_t height_of(const FlatBox& box) noexcept {
    return std::int64_t{box.high.y} - box.low.y;
}
constexpr FlatBox grown(const FlatBox& box, std::int32_t by) noexcept {
    return {{box.low.x - by, box.low.y - by}, {box.high.x + by, box.high.y + by}};
}

}  // namespace lamella
