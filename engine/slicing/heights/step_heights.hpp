// How high a slab may be that begins at a step, by what each step allows. Lengths are in steps.
//
//     allowed    4   4   4   3   3   3   5   5   5   5        A slab from here on is 3 steps high: of 4 it would reach into
//                            ^~~~~~~~~                        a step that allows 3, and from one step higher it is 5.
//
// W(s), the largest slab from s on, is found from the top down. A slab from s on that is h high is one from s + 1 on that is
// h - 1 high, so that W(s) <= W(s + 1) + 1, with equality unless the step s, or another within W(s + 1) of it, allows less.
//
// Changes. A slab whose last step is s is followed by one from s + 1 on: so where s allows no more than W(s + 1) and the
// change, no slab is followed by one that is too thin. Slabs that follow thinner ones are held down as the walk goes up.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "lamella/array.hpp"
#include "slicing/heights/slope_table.hpp"

namespace lamella {

struct HeightLimits {
    std::uint32_t least;
    std::uint32_t most;
    std::uint32_t most_change;  ///< 0: any
    std::uint32_t smoothing;    ///< half of the width over which is averaged

    /// What is allowed, in whole steps.
    std::uint32_t within(double height) const noexcept {
        const double whole = std::min(height + StepScale::slack, static_cast<double>(most));
        return std::max(static_cast<std::uint32_t>(whole), least);
    }
};

class StepHeights {
public:
    StepHeights(const HeightLimits& limits, std::uint32_t steps, const Memory* memory)
        : limits_(limits), highest_(limits.most), steps_(memory), largest_(memory) {
        steps_.resize_discarding(steps);
        largest_.resize_discarding(steps);
    }

    static std::uint64_t bytes_for(std::uint64_t steps) noexcept {
        return steps * (sizeof(Step) + sizeof(std::uint32_t) + sizeof(std::uint64_t));
    }

    /// What facets allow over a step.
    void allow(std::uint32_t step, double height) noexcept { steps_[step] = {limits_.within(height), false}; }

    /// Slabs that begin in a range have its height.
    void set_range(double from, double to, std::uint32_t height) noexcept {
        const auto rounded_up = [count = static_cast<double>(steps_.size())](double step) {
            return static_cast<std::size_t>(std::min(step + (1 - StepScale::slack), count));
        };
        std::fill(steps_.begin() + rounded_up(from), steps_.begin() + rounded_up(to), Step{height, true});
        highest_ = std::max(highest_, height);
    }

    /// All has been said. Throws std::bad_alloc.
    void settle() {
        smooth();
        find_largest();
    }

    /// Of a slab that begins at a step, above one that is `below` high; 0: above none. Precondition: settled.
    std::uint32_t of_slab(std::uint32_t step, std::uint32_t below) const noexcept {
        if (steps_[step].in_range) {
            return steps_[step].allowed;
        }
        const std::uint32_t rise = below > 0 && limits_.most_change > 0 ? below + limits_.most_change : limits_.most;
        return std::max(limits_.least, std::min({largest_[step], limits_.most, rise}));
    }

private:
    struct Step {
        std::uint32_t allowed;
        bool in_range;
    };

    void smooth() {
        const std::size_t count = limits_.smoothing > 0 ? steps_.size() : 0;
        Array<std::uint64_t> sums(steps_.memory());  // of what the steps before allow
        sums.resize_discarding(count + 1);
        sums[0] = 0;
        for (std::size_t s = 0; s < count; ++s) {
            sums[s + 1] = sums[s] + steps_[s].allowed;
        }
        for (std::size_t s = 0; s < count; ++s) {
            const std::size_t first = s - std::min<std::size_t>(s, limits_.smoothing);
            const std::size_t end = std::min<std::size_t>(count, s + limits_.smoothing + 1);
            const auto mean = static_cast<std::uint32_t>((sums[end] - sums[first]) / (end - first));
            auto& [allowed, in_range] = steps_[s];
            allowed = in_range ? allowed : std::max(limits_.least, std::min(allowed, mean));
        }
    }

    void find_largest() {
        Array<std::size_t> lowest(steps_.memory());  // by what is allowed: the lowest such step so far
        lowest.resize_discarding(std::size_t{highest_} + 1);
        std::fill(lowest.begin(), lowest.end(), std::numeric_limits<std::size_t>::max());
        std::uint32_t above = highest_;  // W(s + 1); over the mesh nothing limits
        for (std::size_t s = steps_.size(); s-- > 0;) {
            auto& [allowed, in_range] = steps_[s];
            if (limits_.most_change > 0 && !in_range) {
                allowed = std::max(limits_.least, std::min(allowed, above + limits_.most_change));
            }
            // All steps within W(s + 1) allow as much; where one allows no more, W(s) is no more.
            const bool is_held = lowest[above] < s + 1 + above;
            above = std::min(allowed, is_held ? above : above + 1);
            largest_[s] = above;
            lowest[allowed] = s;
        }
    }

    HeightLimits limits_;
    std::uint32_t highest_;  ///< of all slabs
    Array<Step> steps_;
    Array<std::uint32_t> largest_;  ///< W(s)
};

}  // namespace lamella
