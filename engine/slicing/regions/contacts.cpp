#include "slicing/regions/contacts.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "base/sign.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t most_steps = std::uint64_t{1} << 31;
constexpr std::uint64_t most_contacts = 1 << 18;  // of one cluster

bool cross(Point a, Point b, Point c, Point d) noexcept {
    return sign_of(side_of_line(a, b, c)) * sign_of(side_of_line(a, b, d)) < 0 &&
           sign_of(side_of_line(c, d, a)) * sign_of(side_of_line(c, d, b)) < 0;
}

bool are_near(Point a, Point b, Point c, Point d, std::int32_t reach) noexcept {
    return is_near(a, c, d, reach) || is_near(b, c, d, reach) || is_near(c, a, b, reach) || is_near(d, a, b, reach) ||
           cross(a, b, c, d);
}

}  // namespace

bool is_near(Point p, Point a, Point b, std::int32_t reach) noexcept {
    const Int128 distance_by_length = side_of_line(a, b, p);
    const std::int64_t length = std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
    const Int128 most = Int128{reach} * length;
    return FlatBox::around(a, b).grown(reach).meets({p, p}) && -most <= distance_by_length && distance_by_length <= most;
}

bool Contacts::find(std::span<const NestItem> contours) {
    near_.clear();
    clusters_.assign(contours.size());
    contours_.assign(contours.size(), {});
    shared_.clear();
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        pace_.spend(contours[c].count);
        near_.add({{contours[c].points, contours[c].count}, c, true, contours[c].start});
    }
    const bool all =
        near_.find(clipping_reach, most_steps,
                   [this](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) { meet(a, i, b, j); });
    find_crowds();
    return all;
}

void Contacts::meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    const bool same = a.contour == b.contour;
    if (same && ((i + 1) % a.edges() == j || (j + 1) % a.edges() == i)) {
        return;  // neighbours
    }
    if (!are_near(a[i], a[i + 1], b[j], b[j + 1], same ? 0 : clipping_reach)) {
        return;
    }
    const auto contour = static_cast<std::uint32_t>(a.contour);
    contours_[contour].itself |= same;
    join(contour, static_cast<std::uint32_t>(b.contour));
    if (++contours_[leader(contour)].contacts > most_contacts) {
        near_.stop();
    }
    note_shared(a, i, b, j);
}

/// Points of a line are in the order of their coordinates, one way or the other.
void Contacts::note_shared(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    if (side_of_line(a[i], a[i + 1], b[j]) != 0 || side_of_line(a[i], a[i + 1], b[j + 1]) != 0) {
        return;
    }
    const auto [a_low, a_high] = std::minmax({a[i], a[i + 1]});
    const auto [b_low, b_high] = std::minmax({b[j], b[j + 1]});
    const Point low = std::max(a_low, b_low);
    const Point high = std::min(a_high, b_high);
    if (low < high) {
        ++contours_[leader(static_cast<std::uint32_t>(a.contour))].shared;
        shared_.push_back({static_cast<std::uint32_t>(a.contour), static_cast<std::uint32_t>(i), low, high});
        shared_.push_back({static_cast<std::uint32_t>(b.contour), static_cast<std::uint32_t>(j), low, high});
    }
}

void Contacts::find_crowds() {
    std::sort(shared_.begin(), shared_.end(), [this](const Shared& a, const Shared& b) {
        pace_.spend(1);
        return a < b;
    });
    Point reached;  // the farthest end of the stretches before on the same edge
    for (std::size_t s = 0; s < shared_.size(); ++s) {
        const Shared& own = shared_[s];
        const bool same_edge = s > 0 && shared_[s - 1].contour == own.contour && shared_[s - 1].edge == own.edge;
        contours_[own.contour].crowded |= same_edge && own.low < reached;
        reached = same_edge ? std::max(reached, own.high) : own.high;
    }
}

void Contacts::join(std::uint32_t a, std::uint32_t b) noexcept {
    const auto [first, second] = std::minmax({leader(a), leader(b)});
    if (first != second) {
        clusters_.unite(first, second);
        contours_[first].contacts += contours_[second].contacts;
        contours_[first].shared += contours_[second].shared;
    }
}

}  // namespace lamella
