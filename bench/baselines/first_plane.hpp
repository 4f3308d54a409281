// The range of planes that an interval of heights contains, and items grouped by the first of them (the paper's
// Algorithm 2).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "method.hpp"

namespace lamella::baselines {

/// Index of the first plane above a height; k if there is none. O(1) for uniform planes, O(log k) for others.
class FirstPlaneAbove {
public:
    explicit FirstPlaneAbove(const Problem& problem) noexcept
        : planes_(problem.planes), uniform_(problem.uniform), first_(problem.first), step_(problem.step) {}

    std::uint32_t operator()(std::int32_t z) const noexcept {
        if (!uniform_ || planes_.empty()) {
            return static_cast<std::uint32_t>(std::upper_bound(planes_.begin(), planes_.end(), z) - planes_.begin());
        }
        // Each plane is rounded to the grid by itself, so the quotient can be one too small or one too large.
        const double quotient = std::floor((z - first_) / step_) + 1;
        auto i = static_cast<std::size_t>(std::clamp(quotient, 0.0, static_cast<double>(planes_.size())));
        while (i < planes_.size() && planes_[i] <= z) {
            ++i;
        }
        while (i > 0 && planes_[i - 1] > z) {
            --i;
        }
        return static_cast<std::uint32_t>(i);
    }

private:
    std::span<const std::int32_t> planes_;
    bool uniform_;
    double first_;
    double step_;
};

}  // namespace lamella::baselines
