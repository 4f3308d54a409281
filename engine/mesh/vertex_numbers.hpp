// The distinct vertices of a mesh in order, and which of them each corner is.
//
// Triangles that follow one another share most of their vertices: each range of them is numbered by itself first, by a hash
// table in the cache, so that only what it found need be brought together with what the others found.
//
//     range 0: corners a b c  b d c   ->  a b c d   numbers 0 1 2  1 3 2
//     range 1: corners c d e  d f e   ->  c d e f   numbers 0 1 2  1 3 2   ->  all: a b c d e f
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/distribute.hpp"
#include "base/guard.hpp"
#include "base/parallel_sort.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// Distinct items, numbered in the order in which they come: open addressing by the highest bits of an item's hash, at most
/// half full. Its memory is kept.
template <class Item, std::uint64_t (*hash)(const Item&) noexcept>
class alignas(worker_alignment) NumberTable {
public:
    /// Forgets all items, and makes room for about `count`; beyond that it grows.
    void clear(std::size_t count) {
        constexpr std::size_t least_room = 512;
        items_.clear();
        resize(std::bit_ceil(2 * std::max(count, least_room)));
    }

    /// That of an item equal to this one, or the next number: then the item is new.
    std::uint32_t number(const Item& item) {
        std::uint32_t* slot = &slot_of(item);
        if (*slot == 0) {
            if (2 * (items_.size() + 1) > slots_.size()) {
                resize(2 * slots_.size());
                for (std::uint32_t i = 0; i < items_.size(); ++i) {
                    slot_of(items_[i]) = i + 1;
                }
                slot = &slot_of(item);
            }
            items_.push_back(item);
            *slot = static_cast<std::uint32_t>(items_.size());
        }
        return *slot - 1;
    }

    /// By number.
    const std::vector<Item>& items() const noexcept { return items_; }

private:
    void resize(std::size_t slots) {
        slots_.assign(slots, 0);
        shift_ = 64 - std::countr_zero(slots);
    }

    /// The slot of the item, or the free one where it belongs.
    std::uint32_t& slot_of(const Item& item) {
        std::size_t slot = static_cast<std::size_t>(hash(item) >> shift_);
        while (slots_[slot] != 0 && !(items_[slots_[slot] - 1] == item)) {
            slot = (slot + 1) & (slots_.size() - 1);
        }
        return slots_[slot];
    }

    std::vector<Item> items_;
    std::vector<std::uint32_t> slots_;  ///< 1 + a number, or 0
    int shift_ = 0;
};

/// `Corners` reads the mesh:
///
///     Vertex           compared by == and <
///     (t)              the three vertices of triangle t
///     hash(vertex)     of which the highest bits count
///     key(vertex)      vertices come in the order of their keys, and of equal keys in their own
///     differ(a, b)     true if two equal vertices are not the same but for rounding
template <class Corners>
class VertexNumbers {
public:
    using Vertex = typename Corners::Vertex;

    /// Ten calls of run(). O(n) expected for n triangles, and O(v log v) for v vertices. Throws std::bad_alloc, and Refused
    /// from 2^32 vertices on.
    VertexNumbers(Corners corners, std::size_t triangles, const Parallel& parallel)
        : vertices(parallel.memory()),
          of_corners(parallel.memory()),
          corners_(std::move(corners)),
          parallel_(parallel),
          triangles_(triangles),
          found_(ranges_for(triangles, parallel)),
          firsts_(found_.size() + 1, 0) {
        number_ranges();
        const Array<Vertex> found = bring_together();
        const Array<Item> items = sorted(found);
        Array<std::uint32_t> of_found(parallel.memory());
        of_found.resize_discarding(items.size());
        const auto vertex = [&](std::size_t i) -> const Vertex& { return found[items[i].number]; };
        number_where(
            items.size(), parallel, [&](std::size_t i) { return i == 0 || !(vertex(i) == vertex(i - 1)); },
            [&](std::size_t count) { vertices.resize_discarding(count); },
            [&](std::size_t i, std::uint32_t number, bool is_new) {
                of_found[items[i].number] = number;
                if (is_new) {
                    vertices[number] = vertex(i);
                } else if (Corners::differ(vertex(i), vertex(i - 1))) {
                    joined_.store(true, std::memory_order_relaxed);
                }
            });
        parallel.run(found_.size(), [&](std::size_t range, int) {
            for (std::size_t corner = 3 * first(range); corner != 3 * first(range + 1); ++corner) {
                of_corners[corner] = of_found[firsts_[range] + of_corners[corner]];
            }
        });
    }

    Array<Vertex> vertices;           ///< distinct, in order
    Array<std::uint32_t> of_corners;  ///< by 3 * triangle + corner

    /// True if a vertex stands for several that differ.
    bool joined() const noexcept { return joined_; }

private:
    using Key = decltype(std::declval<const Corners&>().key(std::declval<const Vertex&>()));
    /// A vertex that some range has found.
    struct Item {
        Key key;
        std::uint32_t number;  ///< among all that were found
    };

    std::size_t first(std::size_t range) const noexcept { return triangles_ * range / found_.size(); }

    /// Leaves each corner its vertex's number among what its range has found.
    void number_ranges() {
        of_corners.resize_discarding(3 * triangles_);
        std::vector<NumberTable<Vertex, Corners::hash>> tables(static_cast<std::size_t>(parallel_.threads()));
        parallel_.run(found_.size(), [&](std::size_t range, int worker) {
            NumberTable<Vertex, Corners::hash>& table = tables[static_cast<std::size_t>(worker)];
            table.clear(table.items().size());  // as many as last time are to be expected
            bool joined = false;
            for (std::size_t t = first(range); t != first(range + 1); ++t) {
                const auto own = corners_(t);
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::uint32_t number = table.number(own[i]);
                    joined = joined || Corners::differ(table.items()[number], own[i]);
                    of_corners[3 * t + i] = number;
                }
            }
            found_[range] = table.items();
            if (joined) {
                joined_.store(true, std::memory_order_relaxed);
            }
        });
    }

    /// What the ranges have found. Frees it there.
    Array<Vertex> bring_together() {
        for (std::size_t range = 0; range < found_.size(); ++range) {
            firsts_[range + 1] = firsts_[range] + found_[range].size();
        }
        if (firsts_.back() > std::numeric_limits<std::uint32_t>::max()) {
            throw Refused{{ErrorCode::result_too_large, "the mesh has too many vertices to be numbered"}};
        }
        Array<Vertex> found(parallel_.memory());
        found.resize_discarding(firsts_.back());
        parallel_.run(found_.size(), [&](std::size_t range, int) {
            const std::vector<Vertex> own = std::exchange(found_[range], {});
            std::copy(own.begin(), own.end(), found.begin() + firsts_[range]);
        });
        return found;
    }

    /// Those found, in order.
    Array<Item> sorted(const Array<Vertex>& found) const {
        constexpr std::size_t grain = std::size_t{1} << 12;
        Array<Item> items(parallel_.memory());
        items.resize_discarding(found.size());
        parallel_.run_ranges(found.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i != end; ++i) {
                items[i] = {corners_.key(found[i]), static_cast<std::uint32_t>(i)};
            }
        });
        sort_in_parallel(
            items.span(),
            [&](const Item& a, const Item& b) { return a.key != b.key ? a.key < b.key : found[a.number] < found[b.number]; },
            parallel_, parallel_.memory());
        return items;
    }

    Corners corners_;
    const Parallel& parallel_;
    std::size_t triangles_;
    std::vector<std::vector<Vertex>> found_;  ///< by range
    std::vector<std::size_t> firsts_;         ///< by range: its first vertex among all that were found
    std::atomic<bool> joined_ = false;
};

}  // namespace lamella
