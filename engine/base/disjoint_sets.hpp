// Disjoint sets of numbers (union-find): DisjointSets for one thread, SharedSets for several. In both, the root of a set is
// its smallest member: sets come out in the order of what they hold, whatever order they were united in.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

#include "base/atomic_word.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// O(log n) amortised a call.
class DisjointSets {
public:
    explicit DisjointSets(const Memory* memory = nullptr) : parents_(memory) {}

    /// Members [0, count), each alone in its set.
    void assign(std::size_t count) {
        parents_.resize(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            parents_[i] = i;
        }
    }

    /// One more member, alone in its set.
    void add() { parents_.push_back(static_cast<std::uint32_t>(parents_.size())); }

    std::uint32_t root(std::uint32_t i) noexcept {
        while (parents_[i] != i) {
            parents_[i] = parents_[parents_[i]];  // halves the path
            i = parents_[i];
        }
        return i;
    }

    void unite(std::uint32_t a, std::uint32_t b) noexcept {
        const auto [first, second] = std::minmax({root(a), root(b)});
        parents_[second] = first;
    }

private:
    Vector<std::uint32_t> parents_;
};

/// Several threads unite at once. A link always goes to a smaller member, so that the sets do not depend on who came first.
template <class Index>
class SharedSets {
public:
    /// One call of run(): members [0, count), each alone in its set.
    SharedSets(std::size_t count, const Parallel& parallel, const Memory* memory) : parents_(memory) {
        constexpr std::size_t grain = std::size_t{1} << 16;
        parents_.resize_discarding(count);
        parallel.run_ranges(count, grain, [&](std::size_t begin, std::size_t end, int) {
            std::iota(parents_.begin() + begin, parents_.begin() + end, static_cast<Index>(begin));
        });
    }

    std::size_t size() const noexcept { return parents_.size(); }

    /// Once no thread unites any more.
    bool is_root(std::size_t i) const { return parents_[i] == i; }

    void unite(Index a, Index b) {
        for (;;) {
            a = root(a);
            b = root(b);
            if (a == b) {
                return;
            }
            if (a > b) {
                std::swap(a, b);
            }
            Index expected = b;
            if (at(b).replace(expected, a)) {
                return;
            }  // another thread linked b first: look again
        }
    }

    /// The smallest member of the set, as far as it has been united.
    Index root(Index i) {
        for (Index parent = at(i).load(); parent != i; parent = at(i).load()) {
            const Index grandparent = at(parent).load();
            Index expected = parent;
            at(i).replace(expected, grandparent);  // halves the path; that it may fail does no harm
            i = grandparent;
        }
        return i;
    }

private:
    AtomicWord<Index> at(Index i) { return AtomicWord<Index>(parents_[i]); }

    Array<Index> parents_;
};

}  // namespace lamella
