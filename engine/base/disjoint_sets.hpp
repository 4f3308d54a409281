// Disjoint sets of numbers (union-find).
#pragma once

#include <cstddef>
#include <numeric>
#include <utility>

#include "base/parallel.hpp"
#include "base/system/atomic_word.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// Several threads unite at once. A link always goes to a smaller member, so that the sets do not depend on who came first:
/// the root of a set is its smallest member.
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
            if (grandparent == parent) {
                return parent;
            }
            at(i).replace(parent, grandparent);  // halves the path; that it may fail does no harm
            i = grandparent;
        }
        return i;
    }

private:
    AtomicWord<Index> at(Index i) { return AtomicWord<Index>(parents_[i]); }

    Array<Index> parents_;
};

}  // namespace lamella
