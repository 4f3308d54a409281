// A search for pairs whose work is bounded, so that it never becomes quadratic. Its findings do not depend on threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"

namespace lamella {

/// Counts items and keeps the `most` smallest of them.
template <class Item>
class Tally {
public:
    explicit Tally(std::size_t most) : most_(most) {}

    void add(const Item& item) {
        ++count_;
        items_.push_back(item);
        if (items_.size() >= 2 * most_ + slack) {
            keep_smallest();
        }
    }
    void add(const Tally& other) {
        count_ += other.count_;
        items_.insert(items_.end(), other.items_.begin(), other.items_.end());
        keep_smallest();
    }

    std::uint64_t count() const noexcept { return count_; }
    /// Ascending.
    const std::vector<Item>& smallest() {
        keep_smallest();
        return items_;
    }

private:
    static constexpr std::size_t slack = 256;

    void keep_smallest() {
        std::sort(items_.begin(), items_.end());
        if (items_.size() > most_) {
            items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(most_), items_.end());
        }
    }

    std::size_t most_;
    std::uint64_t count_ = 0;
    std::vector<Item> items_;
};

/// What a search may cost in all, in boxes compared: about a second, which suffices for real meshes.
constexpr std::size_t search_budget(std::size_t items) {
    return (std::size_t{1} << 29) + 1024 * items;
}

/// Calls search(query, limit, worker) for each query in [0, count); it returns what it cost, and stops at the limit, which
/// is an equal share, within a batch, of what is left of the budget: where the search ends depends on the queries alone.
/// Returns whether every query was searched to its end.
template <class Search>
bool search_within_budget(std::size_t count, const Parallel& parallel, Search search) {
    constexpr std::size_t chunk = 16;
    constexpr std::size_t batch = 16 * chunk;
    std::atomic<bool> complete = true;
    std::size_t left = search_budget(count);
    for (std::size_t first = 0; first < count; first += batch) {
        const std::size_t limit = left / batch;
        if (limit == 0) {
            return false;
        }
        const std::size_t last = std::min(count, first + batch);
        std::atomic<std::size_t> spent = 0;
        parallel.run((last - first + chunk - 1) / chunk, [&](std::size_t i, int worker) {
            std::size_t own = 0;
            for (std::size_t query = first + i * chunk; query < std::min(last, first + (i + 1) * chunk); ++query) {
                const std::size_t cost = search(query, limit, worker);
                if (cost >= limit) {
                    complete = false;
                }
                own += cost;
            }
            spent += own;
        });
        left -= std::min<std::size_t>(left, spent);
    }
    return complete;
}

}  // namespace lamella
