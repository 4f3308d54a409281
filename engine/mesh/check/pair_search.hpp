// A search for pairs whose work is bounded, so that it never becomes quadratic. Its findings do not depend on threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/check.hpp"

namespace lamella {

/// Counts what workers find, and keeps the `most` smallest items.
template <class Item>
class Tally {
public:
    Tally(std::size_t most, const Parallel& parallel) : most_(most), shares_(static_cast<std::size_t>(parallel.threads())) {}

    void add(const Item& item, int worker) {
        Share& own = shares_[static_cast<std::size_t>(worker)];
        ++own.count;
        own.items.push_back(item);
        if (own.items.size() >= 2 * most_ + slack) {
            keep_smallest(own.items);
        }
    }

    /// The count of all, and make_place(item) for those kept, in their order.
    template <class MakePlace>
    void fill_in(FaultFinding& finding, MakePlace make_place) const {
        std::vector<Item> items;
        for (const Share& own : shares_) {
            finding.count += own.count;
            items.insert(items.end(), own.items.begin(), own.items.end());
        }
        keep_smallest(items);
        for (const Item& item : items) {
            finding.places.push_back(make_place(item));
        }
    }

private:
    static constexpr std::size_t slack = 256;
    struct Share {
        std::uint64_t count = 0;
        std::vector<Item> items;
    };

    void keep_smallest(std::vector<Item>& items) const {
        std::sort(items.begin(), items.end());
        items.resize(std::min(items.size(), most_));
    }

    std::size_t most_;
    std::vector<Share> shares_;  ///< by worker
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
    std::vector<std::size_t> costs_;        ///< by query in the batch
    std::vector<std::size_t> later_;        ///< queries
};

}  // namespace lamella
