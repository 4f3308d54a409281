// A search for pairs whose work is bounded, so that it never becomes quadratic. Its findings do not depend on threads.
#pragma once

#include <algorithm>
#include <cstddef>
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

/// Searches for queries one after another within a budget, on all threads. Most queries are done at the first attempt, at
/// which each may cost a little. Those that take more are begun anew when all others are done: each may then cost an equal
/// share, within a batch, of what is left. Where the search ends depends on the queries alone.
template <class Item>
class BudgetedSearch {
public:
    BudgetedSearch(std::size_t queries, std::size_t budget, const Parallel& parallel)
        : queries_(queries),
          left_(budget),
          parallel_(parallel),
          found_(static_cast<std::size_t>(parallel.threads())),
          costs_(first_batch) {}

    /// How many calls of run() it makes where no query takes much.
    static constexpr std::size_t runs_for(std::size_t queries) { return (queries + first_batch - 1) / first_batch; }

    /// Calls search(query, limit, found) for the queries, which adds to `found`, stops at the limit and returns what it
    /// cost, and keep(query, found, worker) once for each that is searched. Returns whether every query was searched to its
    /// end.
    template <class Search, class Keep>
    bool run(Search search, Keep keep) {
        const std::size_t most_in_vain = left_ / 2;
        std::size_t in_vain = 0;
        std::size_t first = 0;
        for (; first < queries_ && in_vain < most_in_vain; first += first_batch) {
            const std::size_t count = std::min(first_batch, queries_ - first);
            const std::size_t limit = std::min(most_at_first, left_ / first_batch);
            run_batch(
                count, limit, false, [&](std::size_t i) { return first + i; }, search, keep);
            for (std::size_t i = 0; i < count; ++i) {
                spend(costs_[i]);
                if (costs_[i] >= limit) {
                    in_vain += costs_[i];
                    later_.push_back(first + i);
                }
            }
        }
        for (; first < queries_; ++first) {
            later_.push_back(first);
        }
        return run_later(search, keep);
    }

private:
    static constexpr std::size_t first_batch = std::size_t{1} << 14;
    static constexpr std::size_t most_at_first = std::size_t{1} << 16;
    static constexpr std::size_t later_batch = 256;
    static constexpr std::size_t most_for_one = std::size_t{1} << 25;  // so that a query ends soon after a stop is asked for

    void spend(std::size_t cost) noexcept { left_ -= std::min(left_, cost); }

    template <class Search, class Keep>
    bool run_later(Search& search, Keep& keep) {
        bool complete = true;
        for (std::size_t first = 0; first < later_.size(); first += later_batch) {
            const std::size_t count = std::min(later_batch, later_.size() - first);
            const std::size_t limit = std::min(most_for_one, left_ / later_batch);
            if (limit == 0) {
                return false;
            }
            run_batch(
                count, limit, true, [&](std::size_t i) { return later_[first + i]; }, search, keep);
            for (std::size_t i = 0; i < count; ++i) {
                spend(costs_[i]);
                complete = complete && costs_[i] < limit;
            }
        }
        return complete;
    }

    /// `cut_short`: what is found of a query that reaches the limit is kept, too.
    template <class Query, class Search, class Keep>
    void run_batch(std::size_t count, std::size_t limit, bool cut_short, Query query, Search& search, Keep& keep) {
        const std::size_t grain = cut_short ? 1 : 16;
        parallel_.run_ranges(count, grain, [&](std::size_t begin, std::size_t end, int worker) {
            std::vector<Item>& found = found_[static_cast<std::size_t>(worker)];
            for (std::size_t i = begin; i != end; ++i) {
                found.clear();
                costs_[i] = search(query(i), limit, found);
                if (cut_short || costs_[i] < limit) {
                    keep(query(i), found, worker);
                }
            }
        });
    }

    std::size_t queries_;
    std::size_t left_;
    const Parallel& parallel_;
    std::vector<std::vector<Item>> found_;  ///< by worker, of one query
    std::vector<std::size_t> costs_;        ///< of a batch
    std::vector<std::size_t> later_;        ///< queries
};

}  // namespace lamella
