// Disjoint sets whose members are alike or opposite to one another.
#pragma once

#include <cstdint>
#include <utility>

#include "base/vector.hpp"

namespace lamella {

/// The root of a set is its smallest member: sets come out in the order of what they hold. O(log n) amortised a call.
class JoinedSets {
public:
    struct Member {
        std::uint32_t root;
        bool opposite;  ///< to the root
    };

    explicit JoinedSets(std::size_t count = 0, const Memory* memory = nullptr) : parents_(memory), opposite_(memory) {
        reset(count);
    }

    /// `count` sets of one member each. Throws std::bad_alloc.
    void reset(std::size_t count) {
        parents_.resize(count);
        opposite_.assign(count, 0);
        for (std::uint32_t i = 0; i < count; ++i) {
            parents_[i] = i;
        }
    }

    Member find(std::uint32_t i) {
        bool opposite = false;
        while (parents_[i] != i) {
            const std::uint32_t parent = parents_[i];
            opposite_[i] ^= opposite_[parent];  // halves the path; a root is never opposite to itself
            parents_[i] = parents_[parent];
            opposite ^= opposite_[i] != 0;
            i = parents_[i];
        }
        return {i, opposite};
    }

    /// Where both are in one set already, nothing changes.
    void unite(std::uint32_t a, std::uint32_t b, bool opposite = false) {
        Member first = find(a);
        Member second = find(b);
        if (first.root > second.root) {
            std::swap(first, second);
        }
        if (first.root != second.root) {
            parents_[second.root] = first.root;
            opposite_[second.root] = static_cast<std::uint8_t>(first.opposite ^ second.opposite ^ opposite);
        }
    }

private:
    Vector<std::uint32_t> parents_;
    Vector<std::uint8_t> opposite_;
};

}  // namespace lamella
