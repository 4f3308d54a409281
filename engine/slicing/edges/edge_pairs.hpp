// Pairs of edges that come near one another, of paths in a plane, on one thread.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/parallel.hpp"
#include "slicing/edges/edge_runs.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/edges/run_strips.hpp"

namespace lamella {

/// Searches one layer after another; its memory is kept.
class EdgePairs {
public:
    explicit EdgePairs(const Memory* memory = nullptr) : runs_(memory), strips_(memory), search_(memory) {}

    void clear() noexcept { runs_.clear(); }

    /// The points must stay until find() has returned. Throws std::bad_alloc.
    void add(const EdgePath& path) { runs_.add(path); }

    std::uint64_t edges() const noexcept { return runs_.edges(); }

    /// To be called in `meet`: find() ends, and returns false.
    void stop() noexcept { search_.stop(); }

    /// From here on find() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept {
        strips_.follow(host);
        search_.follow(host);
    }

    /// Calls meet(a, i, b, j) once for each pair, in no order, of edge i of path a and edge j of path b whose boxes come
    /// within `margin` of each other: all such pairs of two paths, and of one path all that meet elsewhere than in the joint
    /// of two runs, and some that do not. Edge i leads from a[i] to a[i + 1]. `margin` is below grid_limit. False if it
    /// would take more than `steps`, and not all were found. Throws std::bad_alloc.
    template <class Meet>
    bool find(std::int32_t margin, std::uint64_t steps, Meet meet) {
        strips_.assign(runs_.runs(), margin);
        return search_.find(runs_, strips_, 0, 1, steps,
                            [&](std::uint32_t a, std::size_t i, std::uint32_t b, std::size_t j) {
                                const LayerPath& a_path = runs_.paths()[a];
                                const LayerPath& b_path = runs_.paths()[b];
                                meet(a_path.given, i - a_path.begin, b_path.given, j - b_path.begin);
                            });
    }

private:
    EdgeRuns runs_;
    RunStrips strips_;
    PairSearch search_;
};

}  // namespace lamella
