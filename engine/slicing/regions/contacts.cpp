#include "slicing/regions/contacts.hpp"

#include <cassert>
#include <cstdlib>
#include <limits>

#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t any_number = std::numeric_limits<std::uint64_t>::max();

/// True if the edge from `joint` to `to` leads back, by more than a right angle, from the one from `from` to `joint`.
bool turns_back(Point from, Point joint, Point to) noexcept {
    const std::int64_t along_x = (std::int64_t{joint.x} - from.x) * (std::int64_t{to.x} - joint.x);
    const std::int64_t along_y = (std::int64_t{joint.y} - from.y) * (std::int64_t{to.y} - joint.y);
    return along_x < -along_y;
}

/// True if one of the two edges lies on the other.
bool runs_back(Point from, Point joint, Point to) noexcept {
    return side_of(from, joint, to) == 0 && turns_back(from, joint, to);
}

/// value / (2 * divisor), rounded; halves up.
Int128 rounded_half(Int128 value, Int128 divisor) noexcept {
    const Int128 twice = 2 * divisor;
    const Int128 sum = value + divisor;
    return sum / twice - (sum % twice < 0 ? 1 : 0);
}

}  // namespace

bool is_near(Point p, Point a, Point b, std::int32_t reach) noexcept {
    if (!grown(FlatBox::around(a, b), reach).holds(p)) {
        return false;
    }
    const Int128 distance_by_length = side_of_line(a, b, p);
    const std::int64_t length = std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
    const Int128 most = Int128{reach} * length;
    return -most <= distance_by_length && distance_by_length <= most;
}

Point rounded_crossing(Point a, Point b, Point c, Point d) noexcept {
    const std::int64_t dx = std::int64_t{b.x} - a.x;
    const std::int64_t dy = std::int64_t{b.y} - a.y;
    const Int128 c_side = side_of_line(a, b, c);
    const Int128 d_side = side_of_line(a, b, d);
    assert(c_side != d_side);
    Int128 whole = c_side - d_side;  // the crossing is a + (b - a) part / whole
    Int128 part = side_of_line(c, d, a);
    assert(part != 0);
    // side_of_line(c, d, a) - side_of_line(c, d, b) is whole or its opposite: the signs of `part` and `whole` must agree.
    if (part < 0) {
        part = -part;
    }
    if (whole < 0) {
        whole = -whole;
    }
    return {static_cast<std::int32_t>(a.x + rounded_half(2 * part * dx, whole)),
            static_cast<std::int32_t>(a.y + rounded_half(2 * part * dy, whole))};
}

void Contacts::find(std::span<const NestItem> contours) {
    near_.clear();
    meets_.assign(contours.size(), 0);
    crossings_.clear();
    first_edges_.clear();
    first_edges_.push_back(0);
    any_meets_ = false;
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        worker_.spend(contours[c].count);
        near_.add({{contours[c].points, contours[c].count}, c, true, contours[c].start});
        first_edges_.push_back(first_edges_.back() + contours[c].count);
    }
    near_edges_.assign(first_edges_.back(), 0);
    near_.find(rounding_reach, any_number,
               [this](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) { meet(a, i, b, j); });
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        if (meets(c)) {
            mark_sharp_corners(contours[c], c);
        }
    }
}

/// Where an edge runs back along the one before, so near that either may be bent through an end of the other.
void Contacts::mark_sharp_corners(const NestItem& contour, std::uint32_t number) {
    const std::span<std::uint8_t> near = std::span(near_edges_).subspan(first_edges_[number], contour.count);
    worker_.spend(contour.count);
    for (std::uint32_t i = 0; i < contour.count; ++i) {
        const Point from = contour.from_start(i);
        const Point joint = contour.from_start(i + 1);
        const Point to = contour.from_start(i + 2);
        if (turns_back(from, joint, to) &&
            (is_near(from, joint, to, rounding_reach) || is_near(to, from, joint, rounding_reach))) {
            near[i] = near[i + 1 < contour.count ? i + 1 : 0] = 1;
        }
    }
}

void Contacts::meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    const bool same = a.contour == b.contour;
    const Point a0 = a[i];
    const Point a1 = a[i + 1];
    const Point b0 = b[j];
    const Point b1 = b[j + 1];
    if (same && ((i + 1) % a.edges() == j || (j + 1) % a.edges() == i)) {
        if ((a1 == b0 && runs_back(a0, a1, b1)) || (b1 == a0 && runs_back(b0, b1, a1))) {
            mark(a, i, true);
            mark(b, j, true);
        }
        return;
    }
    const auto touch = [&](std::int32_t reach) {
        return is_near(a0, b0, b1, reach) || is_near(a1, b0, b1, reach) || is_near(b0, a0, a1, reach) ||
               is_near(b1, a0, a1, reach);
    };
    const bool crossing = edges_cross(a0, a1, b0, b1);
    if (!crossing && !touch(rounding_reach)) {
        return;
    }
    const bool meets = !same || crossing || touch(0);
    mark(a, i, meets);
    mark(b, j, meets);
    if (crossing) {
        crossings_.push_back(rounded_crossing(a0, a1, b0, b1));
    }
}

void Contacts::mark(const EdgePath& path, std::size_t edge, bool meets) noexcept {
    near_edges_[first_edges_[path.contour] + edge] = 1;
    meets_[path.contour] |= meets ? 1 : 0;
    any_meets_ = any_meets_ || meets;
}

}  // namespace lamella
