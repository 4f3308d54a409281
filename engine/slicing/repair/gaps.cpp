#include "slicing/repair/gaps.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

namespace lamella {

/// An end and a start that are each other's nearest are a pair, whatever is joined before them, since everything else is
/// farther from both. The pairs can therefore be found in any order; sorting all distances is not needed.
std::span<const Gap> GapCloser::close(std::span<const PolylineEnds> polylines, double reach) {
    const double reach_squared = std::min(reach * reach, std::numeric_limits<double>::max());
    ends_.assign(polylines, &PolylineEnds::last);
    starts_.assign(polylines, &PolylineEnds::first);
    next_.assign(polylines.size(), -1);
    taken_.assign(polylines.size(), 0);
    gaps_.clear();
    for (std::uint32_t end = 0; end < ends_.site_count(); ++end) {
        while (ends_.holds(end)) {
            follow_chain(end, reach_squared);
        }
    }
    std::sort(gaps_.begin(), gaps_.end(), [polylines, this](const Gap& a, const Gap& b) {
        pace_.spend(1);
        const auto key = [polylines](const Gap& gap) {
            const Point end = polylines[gap.from].last;
            const Point start = polylines[gap.to].first;
            return std::tuple(squared_distance(end, start), end, start, gap.from, gap.to);
        };
        return key(a) < key(b);
    });
    return gaps_;
}

/// Follows the chain from `end` to the start nearest to it, to the end nearest to that, and so on. Distances fall, until two
/// sites are each other's nearest. They are joined, and the chain goes on from the site before them, so that no search is
/// repeated. On return `end` is joined, or taken off if nothing is within reach.
void GapCloser::follow_chain(std::uint32_t end, double reach_squared) {
    chain_.assign(1, end);
    while (!chain_.empty()) {
        const bool at_end = chain_.size() % 2 == 1;
        const std::uint32_t site = chain_.back();
        EndTree& others = at_end ? starts_ : ends_;
        const std::uint32_t nearest = others.nearest((at_end ? ends_ : starts_).at(site), reach_squared);
        if (nearest == EndTree::none) {
            ends_.take_all(site);  // it is the first of the chain: all others are within reach of their predecessor
            chain_.pop_back();
        } else if (chain_.size() > 1 && nearest == chain_.end()[-2]) {
            join(at_end ? site : nearest, at_end ? nearest : site);
            chain_.resize(chain_.size() - 2);
        } else {
            chain_.push_back(nearest);
        }
    }
}

/// Joins as many as both sites hold. All are equally far apart, so they are paired by number.
void GapCloser::join(std::uint32_t end, std::uint32_t start) {
    while (ends_.holds(end) && starts_.holds(start)) {
        const Gap gap{ends_.take(end), starts_.take(start)};
        next_[gap.from] = gap.to;
        taken_[gap.to] = 1;
        gaps_.push_back(gap);
    }
}

}  // namespace lamella
