// A search for pairs whose work is bounded, so that it never becomes quadratic. Its findings do not depend on threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/check.hpp"

namespace lamella {

/// Counts items, and keeps the `most` smallest.
template <class Item>
class Tally {
public:
    explicit Tally(std::size_t most) noexcept : most_(most) {}

    void add(const Item& item) {
        constexpr std::size_t slack = 256;
        ++count_;
        items_.push_back(item);
        if (items_.size() >= 2 * most_ + slack) {
            keep_smallest();
        }
    }

    /// The count, and make_place(item) for those kept, in their order.
    template <class MakePlace>
    void fill_in(FaultFinding& finding, MakePlace make_place) {
        keep_smallest();
        finding.count = count_;
        for (const Item& item : items_) {
            finding.places.push_back(make_place(item));
        }
    }

private:
    void keep_smallest() {
        std::sort(items_.begin(), items_.end());
        items_.resize(std::min(items_.size(), most_));
    }

    std::size_t most_;
    std::uint64_t count_ = 0;
    std::vector<Item> items_;
};

/// The cost of a search at most, in boxes compared: about a second, which suffices for real meshes.
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
    /// cost; and keep(item) for all that is found, on one thread at a time, a query's items in the order in which it found
    /// them.
    /// Returns whether every query was searched to its end.
    template <class Search, class Keep>
    bool run(Search search, Keep keep) {
        const std::size_t most_in_vain = left_ / 2;
        std::size_t in_vain = 0;
        std::size_t first = 0;
        std::vector<std::size_t> later;
        for (; first < queries_ && in_vain < most_in_vain; first += first_batch) {
            const std::size_t count = std::min(first_batch, queries_ - first);
            const std::size_t limit = std::min(most_at_first, left_ / first_batch);
            run_batch(
                count, limit, false, [&](std::size_t i) { return first + i; }, search, keep);
            for (std::size_t i = 0; i < count; ++i) {
                if (costs_[i] >= limit) {
                    in_vain += costs_[i];
                    later.push_back(first + i);
                }
            }
        }
        for (; first < queries_; ++first) {
            later.push_back(first);
        }
        bool complete = true;
        for (std::size_t begin = 0; begin < later.size(); begin += later_batch) {
            const std::size_t count = std::min(later_batch, later.size() - begin);
            const std::size_t limit = std::min(most_for_one, left_ / later_batch);
            if (limit == 0) {
                return false;
            }
            run_batch(
                count, limit, true, [&](std::size_t i) { return later[begin + i]; }, search, keep);
            complete = complete && std::all_of(costs_.begin(), costs_.begin() + static_cast<std::ptrdiff_t>(count),
                                               [&](std::size_t cost) { return cost < limit; });
        }
        return complete;
    }

private:
    static constexpr std::size_t first_batch = std::size_t{1} << 14;
    static constexpr std::size_t most_at_first = std::size_t{1} << 16;
    static constexpr std::size_t later_batch = 256;
    static constexpr std::size_t most_for_one = std::size_t{1} << 25;  // so that a query ends soon after a stop is asked for

    /// `cut_short`: what is found of a query that reaches the limit is kept, too.
    template <class Query, class Search, class Keep>
    void run_batch(std::size_t count, std::size_t limit, bool cut_short, Query query, Search& search, Keep& keep) {
        parallel_.run_ranges(count, cut_short ? 1 : 16, [&](std::size_t begin, std::size_t end, int worker) {
            std::vector<Item>& found = found_[static_cast<std::size_t>(worker)];
            for (std::size_t i = begin; i != end; ++i) {
                found.clear();
                costs_[i] = search(query(i), limit, found);
                if (!found.empty() && (cut_short || costs_[i] < limit)) {
                    const std::lock_guard lock(keeping_);
                    std::for_each(found.begin(), found.end(), keep);
                }
            }
        });
        for (std::size_t i = 0; i < count; ++i) {
            left_ -= std::min(left_, costs_[i]);
        }
    }

    std::size_t queries_;
    std::size_t left_;
    const Parallel& parallel_;
    std::vector<std::vector<Item>> found_;  ///< by worker, of one query
    std::mutex keeping_;
    std::vector<std::size_t> costs_;  ///< by query in the batch
};

}  // namespace lamella
