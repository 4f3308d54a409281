#include "6_contours/gaps.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace lamella {

std::span<const Gap> GapCloser::close(std::span<const Ends> polylines, double reach) {
    find_candidates(polylines, reach);
    std::sort(candidates_.begin(), candidates_.end(), [polylines](const Candidate& a, const Candidate& b) {
        const auto key = [polylines](const Candidate& c) {
            return std::tuple(c.squared, polylines[c.gap.from].last, polylines[c.gap.to].first, c.gap.from, c.gap.to);
        };
        return key(a) < key(b);
    });
    next_.assign(polylines.size(), -1);
    taken_.assign(polylines.size(), 0);
    gaps_.clear();
    for (const auto& [squared, gap] : candidates_) {
        if (next_[gap.from] < 0 && taken_[gap.to] == 0) {
            next_[gap.from] = gap.to;
            taken_[gap.to] = 1;
            gaps_.push_back(gap);
        }
    }
    return gaps_;
}

/// Every end with the starts within reach: those whose x is come from a list by x.
void GapCloser::find_candidates(std::span<const Ends> polylines, double reach) {
    by_x_.resize(polylines.size());
    std::iota(by_x_.begin(), by_x_.end(), 0U);
    std::sort(by_x_.begin(), by_x_.end(),
              [polylines](std::uint32_t a, std::uint32_t b) { return polylines[a].first.x < polylines[b].first.x; });
    candidates_.clear();
    for (std::uint32_t from = 0; from < polylines.size(); ++from) {
        const Point end = polylines[from].last;
        auto start = std::lower_bound(by_x_.begin(), by_x_.end(), end.x - reach,
                                      [polylines](std::uint32_t p, double x) { return polylines[p].first.x < x; });
        for (; start != by_x_.end() && polylines[*start].first.x <= end.x + reach; ++start) {
            const double dx = static_cast<double>(polylines[*start].first.x) - end.x;
            const double dy = static_cast<double>(polylines[*start].first.y) - end.y;
            if (dx * dx + dy * dy <= reach * reach) {
                candidates_.push_back({dx * dx + dy * dy, {from, *start}});
            }
        }
    }
}

}  // namespace lamella
