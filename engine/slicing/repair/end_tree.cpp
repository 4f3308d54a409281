#include "slicing/repair/end_tree.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <tuple>

namespace lamella {

namespace {

constexpr std::uint32_t leaf_size = 8;  // sites, at most

constexpr std::int32_t lowest = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t highest = std::numeric_limits<std::int32_t>::max();

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
    leaf_count_ = std::bit_ceil(site_count() / leaf_size + 1);
    order(0, leaf_count_);
    boxes_.resize(std::size_t{2} * leaf_count_);
    for (std::uint32_t node = 2 * leaf_count_ - 1; node > 0; --node) {
        measure(node);
    }
}

std::uint32_t EndTree::first_site(std::uint32_t leaf) const noexcept {
    return static_cast<std::uint32_t>(std::uint64_t{leaf} * site_count() / leaf_count_);
}

/// Halves the sites of these leaves across the longer side of their box, recursively.
void EndTree::order(std::uint32_t first_leaf, std::uint32_t leaf_count) {
    if (leaf_count == 1) {
        return;
    }
    const std::uint32_t first = first_site(first_leaf);
    const std::uint32_t end = first_site(first_leaf + leaf_count);
    const Box box = box_of(first, end);
    pace_.spend(end - first);
    const bool wide = std::int64_t{box.max.x} - box.min.x > std::int64_t{box.max.y} - box.min.y;
    std::nth_element(sites_.begin() + first, sites_.begin() + first_site(first_leaf + leaf_count / 2), sites_.begin() + end,
                     [wide](const Site& a, const Site& b) { return wide ? a.at.x < b.at.x : a.at.y < b.at.y; });
    order(first_leaf, leaf_count / 2);
    order(first_leaf + leaf_count / 2, leaf_count / 2);
}

/// The box of the sites in [first, end) that have an end left.
EndTree::Box EndTree::box_of(std::uint32_t first, std::uint32_t end) const noexcept {
    Box box{{highest, highest}, {lowest, lowest}};
    for (std::uint32_t site = first; site < end; ++site) {
        if (holds(site)) {
            const Point at = sites_[site].at;
            box.min = {std::min(box.min.x, at.x), std::min(box.min.y, at.y)};
            box.max = {std::max(box.max.x, at.x), std::max(box.max.y, at.y)};
        }
    }
    return box;
}

/// Computes the node's box from its children or sites.
void EndTree::measure(std::uint32_t node) noexcept {
    if (node >= leaf_count_) {
        boxes_[node] = box_of(first_site(node - leaf_count_), first_site(node - leaf_count_ + 1));
        return;
    }
    const Box& a = boxes_[std::size_t{2} * node];
    const Box& b = boxes_[std::size_t{2} * node + 1];
    boxes_[node] = {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y)},
                    {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y)}};
}

std::uint32_t EndTree::nearest(Point to, double most_squared, std::uint32_t but) {
    Nearest best{most_squared, {highest, highest}, none, but};
    search(1, to, best);
    return best.site;
}

/// A lower bound for squared_distance() to any point in the box: it rounds in the same way.
double EndTree::squared_distance_to(const Box& box, Point point) noexcept {
    if (box.min.x > box.max.x) {
        return std::numeric_limits<double>::infinity();
    }
    return squared_distance(point, {std::clamp(point.x, box.min.x, box.max.x), std::clamp(point.y, box.min.y, box.max.y)});
}

void EndTree::search(std::uint32_t node, Point to, Nearest& best) {
    pace_.spend(leaf_size);
    if (node < leaf_count_) {
        const double squared[] = {squared_distance_to(boxes_[std::size_t{2} * node], to),
                                  squared_distance_to(boxes_[std::size_t{2} * node + 1], to)};
        const std::uint32_t nearer = squared[1] < squared[0] ? 1 : 0;
        for (const std::uint32_t child : {nearer, 1 - nearer}) {
            if (squared[child] <= best.squared) {
                search(2 * node + child, to, best);
            }
        }
        return;
    }
    const std::uint32_t end = first_site(node - leaf_count_ + 1);
    for (std::uint32_t site = first_site(node - leaf_count_); site < end; ++site) {
        const Point at = sites_[site].at;
        const double squared = squared_distance(to, at);
        if (holds(site) && site != best.but && std::tie(squared, at) < std::tie(best.squared, best.at)) {
            best = {squared, at, site, best.but};
        }
    }
}

std::uint32_t EndTree::take(std::uint32_t site) noexcept {
    assert(holds(site));
    const std::uint32_t polyline = polylines_[sites_[site].next++];
    if (!holds(site)) {
        shrink(site);
    }
    return polyline;
}

void EndTree::take_all(std::uint32_t site) noexcept {
    sites_[site].next = sites_[site].end;
    shrink(site);
}

/// Computes the boxes around a site again that has become empty.
void EndTree::shrink(std::uint32_t site) noexcept {
    // The last leaf that starts at or before the site.
    const auto leaf = static_cast<std::uint32_t>(((std::uint64_t{site} + 1) * leaf_count_ - 1) / site_count());
    assert(first_site(leaf) <= site && site < first_site(leaf + 1));
    for (std::uint32_t node = leaf_count_ + leaf; node > 0; node /= 2) {
        measure(node);
    }
}

}  // namespace lamella
