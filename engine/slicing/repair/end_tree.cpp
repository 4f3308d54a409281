#include "slicing/repair/end_tree.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>

namespace lamella {

namespace {

/// A lower bound for squared_distance() to any point in the box: it rounds in the same way.
double squared_distance_to(const FlatBox& box, Point point) noexcept {
    if (exceeds(box.low, box.high)) {
        return std::numeric_limits<double>::infinity();
    }
    return squared_distance(point, high_corner(box.low, low_corner(box.high, point)));
}

}  // namespace

void EndTree::assign(std::span<const PolylineEnds> polylines, Point PolylineEnds::*end) {
    polylines_.resize(polylines.size());
    std::iota(polylines_.begin(), polylines_.end(), 0U);
    std::sort(polylines_.begin(), polylines_.end(), [polylines, end, this](std::uint32_t a, std::uint32_t b) {
        pace_.spend(1);
        return std::tie(polylines[a].*end, a) < std::tie(polylines[b].*end, b);
    });
    sites_.clear();
    for (std::uint32_t i = 0; i < polylines_.size(); ++i) {
        const Point at = polylines[polylines_[i]].*end;
        if (sites_.empty() || sites_.back().at != at) {
            sites_.push_back({at, i, i});
        }
        ++sites_.back().end;
    }
    order_by_place(
        std::span(sites_), [](const Site& site) { return site.at; }, pace_);
    boxes_.assign(
        sites_.size(),
        [this](std::size_t site) {
            return FlatBox{sites_[site].at, sites_[site].at};
        },
        pace_);
}

std::uint32_t EndTree::nearest(Point to, double most_squared, std::uint32_t but) {
    constexpr std::int32_t highest = std::numeric_limits<std::int32_t>::max();
    Nearest best{most_squared, {highest, highest}, none, but};
    search(boxes_.levels() - 1, 0, to, best);
    return best.site;
}

/// The boxes of a block, the nearest first.
void EndTree::search(std::size_t level, std::size_t number, Point to, Nearest& best) {
    constexpr std::size_t fan = BoxTree<Point>::fan;
    pace_.spend(fan);
    std::array<std::pair<double, std::size_t>, fan> near;
    std::size_t count = 0;
    for (std::size_t lane = 0; lane < fan; ++lane) {
        const double squared = squared_distance_to(boxes_.block(level, number)[lane], to);
        if (squared <= best.squared) {
            near[count++] = {squared, number * fan + lane};
        }
    }
    std::sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t i = 0; i < count && near[i].first <= best.squared; ++i) {
        const auto [squared, child] = near[i];
        if (level > 0) {
            search(level - 1, child, to, best);
            continue;
        }
        const auto site = static_cast<std::uint32_t>(child);
        if (site != best.but && std::tie(squared, sites_[site].at) < std::tie(best.squared, best.at)) {
            best = {squared, sites_[site].at, site, best.but};
        }
    }
}

std::uint32_t EndTree::take(std::uint32_t site) noexcept {
    assert(holds(site));
    const std::uint32_t polyline = polylines_[sites_[site].next++];
    if (!holds(site)) {
        boxes_.take_off(site);
    }
    return polyline;
}

void EndTree::take_all(std::uint32_t site) noexcept {
    sites_[site].next = sites_[site].end;
    boxes_.take_off(site);
}

}  // namespace lamella
