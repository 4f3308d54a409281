#include "slicing/repair/gaps.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace lamella {

void EndTree::assign(std::span<const PolylineEnds> polylines, Point PolylineEnds::*end) {
    polylines_.resize(polylines.size());
    std::iota(polylines_.begin(), polylines_.end(), 0U);
    std::sort(polylines_.begin(), polylines_.end(), [polylines, end, this](std::uint32_t a, std::uint32_t b) {
        worker_.spend(1);
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
    tree_.assign(sites_.size(), [this](std::size_t site) { return sites_[site].at; });
}

std::uint32_t EndTree::take(std::uint32_t site) noexcept {
    assert(holds(site));
    const std::uint32_t polyline = polylines_[sites_[site].next++];
    if (!holds(site)) {
        tree_.take_off(site);
    }
    return polyline;
}

void EndTree::take_all(std::uint32_t site) noexcept {
    sites_[site].next = sites_[site].end;
    tree_.take_off(site);
}

/// Two ends that are each other's nearest are a pair, whatever is joined before them, since everything else is farther from
/// both. The pairs can therefore be found in any order; sorting all distances is not needed.
std::span<const Gap> GapCloser::close(std::span<const PolylineEnds> polylines, const GapRules& rules) {
    assert(polylines.size() < std::size_t{1} << 31);
    reach_squared_ = std::min(rules.reach * rules.reach, std::numeric_limits<double>::max());
    sense_ = rules.sense;
    ends_.assign(polylines, &PolylineEnds::last);
    starts_.assign(polylines, &PolylineEnds::first);
    joined_to_.clear();
    joined_to_.reserve(2 * polylines.size());
    for (std::uint32_t p = 0; p < polylines.size(); ++p) {
        joined_to_.emplace_back(p, false);
        joined_to_.emplace_back(p, true);
    }
    gaps_.clear();
    follow_chains(true);
    if (sense_ == StitchDirection::any) {
        follow_chains(false);
    }
    sort_gaps(polylines);
    return gaps_;
}

/// Until no last or no first point is left.
void GapCloser::follow_chains(bool last) {
    const EndTree& tree = tree_of(last);
    for (std::uint32_t site = 0; site < tree.site_count(); ++site) {
        while (tree.holds(site)) {
            follow_chain({site, last});
        }
    }
}

/// Follows the chain from `first` to the site nearest to it, to the one nearest to that, and so on. Pairs come ever earlier
/// in the order in which they are joined, until two sites are each other's nearest. They are joined, and the chain goes on
/// from the site before them, so that no search is repeated. On return an end of `first` is joined, or all are taken off if
/// nothing is within reach.
void GapCloser::follow_chain(Site first) {
    chain_.assign(1, first);
    while (!chain_.empty()) {
        const Site site = chain_.back();
        const Site other = nearest(site);
        if (other == no_site) {
            tree_of(site.last).take_all(site.number);  // it is `first`: all others are within reach of their predecessor
            chain_.pop_back();
        } else if (other == site) {
            join(site, site);
            chain_.pop_back();
        } else if (chain_.size() > 1 && other == chain_.end()[-2]) {
            join(site, other);
            chain_.resize(chain_.size() - 2);
        } else {
            chain_.push_back(other);
        }
    }
}

/// The site whose ends come first among those that an end at `site` can be joined to: the site itself where two ends of a
/// kind meet there and no end of the other kind does.
GapCloser::Site GapCloser::nearest(Site site) {
    const Point from = at(site);
    const Site kept{tree_of(!site.last).nearest(from, reach_squared_), !site.last};
    if (sense_ == StitchDirection::oriented) {
        return kept.number == EndTree::none ? no_site : kept;
    }
    double least = reach_squared_;
    if (kept.number != EndTree::none) {
        least = squared_distance(from, at(kept));
        if (least == 0) {
            return kept;
        }
    }
    EndTree& same = tree_of(site.last);
    if (same.count_at(site.number) > 1) {
        return site;
    }
    const Site turned{same.nearest(from, least, site.number), site.last};
    const bool turns =
        turned.number != EndTree::none && (kept.number == EndTree::none || squared_distance(from, at(turned)) < least);
    return turns ? turned : (kept.number == EndTree::none ? no_site : kept);
}

/// Joins as many as both sites hold. All are equally far apart, so they are paired by number.
void GapCloser::join(Site a, Site b) {
    const bool swap = a.last != b.last ? b.last : at(b) < at(a);
    const auto [from, to] = swap ? std::pair(b, a) : std::pair(a, b);
    EndTree& tree_from = tree_of(from.last);
    EndTree& tree_to = tree_of(to.last);
    const std::uint32_t count =
        a == b ? tree_from.count_at(a.number) / 2 : std::min(tree_from.count_at(from.number), tree_to.count_at(to.number));
    for (std::uint32_t i = 0; i < count; ++i) {
        const PolylineEnd end{tree_from.take(from.number), from.last};
        const PolylineEnd start{tree_to.take(to.number), to.last};
        joined_to_[end.number()] = start;
        joined_to_[start.number()] = end;
        gaps_.push_back({end, start});
    }
}

std::span<const Gap> GapCloser::leave_open(std::span<const std::uint8_t> crossed) {
    std::size_t kept = 0;
    for (std::size_t g = 0; g < gaps_.size(); ++g) {
        const Gap gap = gaps_[g];
        if (crossed[g] == 0) {
            gaps_[kept++] = gap;
        } else {
            joined_to_[gap.from.number()] = gap.from;
            joined_to_[gap.to.number()] = gap.to;
        }
    }
    gaps_.erase(gaps_.begin() + static_cast<std::ptrdiff_t>(kept), gaps_.end());
    return gaps_;
}

/// By distance; see close().
void GapCloser::sort_gaps(std::span<const PolylineEnds> polylines) {
    std::sort(gaps_.begin(), gaps_.end(), [polylines, this](const Gap& a, const Gap& b) {
        worker_.spend(1);
        const auto key = [polylines](const Gap& gap) {
            const Point from = polylines[gap.from.polyline()].at(gap.from.last());
            const Point to = polylines[gap.to.polyline()].at(gap.to.last());
            return std::tuple(squared_distance(from, to), gap.turns(), from, to, gap.from.number(), gap.to.number());
        };
        return key(a) < key(b);
    });
}

}  // namespace lamella
