#include "slicing/simplify/chain.hpp"

#include <cmath>

namespace lamella {

namespace {

struct Vector2 {
    std::int64_t x;
    std::int64_t y;
};

constexpr Vector2 between(Point from, Point to) noexcept {
    return {std::int64_t{to.x} - from.x, std::int64_t{to.y} - from.y};
}

/// At most 2^63, which the grid's diagonal has.
constexpr std::uint64_t square(Vector2 v) noexcept {
    return static_cast<std::uint64_t>(v.x * v.x) + static_cast<std::uint64_t>(v.y * v.y);
}

/// Whether the two point the same way by less than a right angle. The sum of the products could take 65 bits.
constexpr bool leads_along(Vector2 u, Vector2 v) noexcept {
    return u.x * v.x > -(u.y * v.y);
}

/// Twice the area of a triangle: at most the square of the grid's side, 2^62.
constexpr std::uint64_t distance_by_length(Vector2 line, Vector2 to) noexcept {
    const std::int64_t area = line.x * to.y - line.y * to.x;
    return static_cast<std::uint64_t>(area < 0 ? -area : area);
}

/// The greatest so far, the first of equal ones.
struct Greatest {
    std::uint64_t value = 0;
    std::size_t at = 0;

    void see(std::uint64_t other, std::size_t place) noexcept {
        at = other > value ? place : at;
        value = other > value ? other : value;
    }
};

}  // namespace

std::uint64_t floor_of_root(Int128 value) noexcept {
    auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(value)));
    const auto is_above = [value](std::uint64_t candidate) { return Int128{candidate} * candidate > value; };
    if (root > 0 && (is_above(root) || !is_above(root + 1))) {
        root = (root + static_cast<std::uint64_t>(value / root)) / 2;  // one step of Newton's leaves a unit or two
    }
    while (is_above(root)) {
        --root;
    }
    while (!is_above(root + 1)) {
        ++root;
    }
    return root;
}

/// A point beside the line is as far from it as its triangle with the ends is large; one beyond an end is as far as the end.
/// Those beyond an end, if too far, are split off first: they are where the chain leads back.
ChainReach measure_chain(const Point* points, std::size_t first, std::size_t last, std::int64_t tolerance) noexcept {
    const Point a = points[first];
    const Point b = points[last];
    const Vector2 line = between(a, b);
    Greatest beside;
    Greatest beyond;
    for (std::size_t i = first + 1; i < last; ++i) {
        const Vector2 from_a = between(a, points[i]);
        const Vector2 from_b = between(b, points[i]);
        if (!leads_along(from_a, line)) {
            beyond.see(square(from_a), i);
        } else if (leads_along(from_b, line)) {
            beyond.see(square(from_b), i);
        } else {
            beside.see(distance_by_length(line, from_a), i);
        }
    }
    const std::size_t middle = first + (last - first) / 2;
    const Int128 squared = Int128{tolerance} * tolerance;
    if (a == b || Int128{beyond.value} > squared) {
        return {beyond.value > 0 ? beyond.at : middle, false};
    }
    const bool within = beside.value <= floor_of_root(squared * square(line));
    return {beside.value > 0 ? beside.at : middle, within};
}

}  // namespace lamella
