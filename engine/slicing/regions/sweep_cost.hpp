// The cost of a sweep over closed paths with a list of the edges at the current height, as in the clipping library.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace lamella {

class SweepCost {
public:
    /// An edge of a path, by the heights of its ends. Throws std::bad_alloc.
    void add_edge(std::int64_t from, std::int64_t to) {
        if (from != to) {
            lows_.push_back(std::min(from, to));
            highs_.push_back(std::max(from, to));
        } else {
            ++level_;
        }
    }

    /// The number of visits to an edge. At each height where edges begin, all edges there are visited once, once more for
    /// each two that begin and once more for each that ends; a level edge is visited once. O(edges log edges).
    std::uint64_t looks() {
        std::sort(lows_.begin(), lows_.end());
        std::sort(highs_.begin(), highs_.end());
        std::uint64_t looks = level_;
        std::size_t begun = 0;
        std::size_t ended = 0;
        while (begun < lows_.size()) {
            const std::size_t begun_before = begun;
            const std::size_t ended_before = ended;
            const std::int64_t height = lows_[begun];
            while (begun < lows_.size() && lows_[begun] == height) {
                ++begun;
            }
            while (highs_[ended] <= height) {
                ++ended;
            }
            looks += (begun - ended) * (1 + (begun - begun_before) / 2 + (ended - ended_before));
        }
        return looks;
    }

private:
    std::vector<std::int64_t> lows_, highs_;
    std::uint64_t level_ = 0;
};

}  // namespace lamella
