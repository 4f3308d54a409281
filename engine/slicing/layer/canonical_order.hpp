// The order of a layer's contours in the result, whatever the order of the walk: by start, each outer followed by its holes.
//
//     contours      c0   c1   c2   c3          as walked
//     items         c2   c0   c3   c1          by start; nested in this order
//     result        c2 [ c3 ] | c0 [ c1 ]      outers with their holes
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "slicing/nesting/order.hpp"
#include "slicing/nesting/path.hpp"

namespace lamella {

/// One per thread; scratch is kept.
class CanonicalOrder {
public:
    explicit CanonicalOrder(Worker& worker) noexcept : worker_(worker) {}

    /// Sorts by the start point, then by its edge, then by content, origins last. Contours equal in all of that are
    /// interchangeable. O(q log q). Throws std::bad_alloc.
    void sort_by_start(std::span<const Path> contours);
    /// The path that comes `item`-th by start.
    std::uint32_t path_of(std::size_t item) const noexcept { return by_start_[item].index; }
    std::size_t size() const noexcept { return by_start_.size(); }

    /// Finds the place in the result of each item; `items` are by start and nested. O(q). Throws std::bad_alloc.
    void put_holes_after_outers(std::span<const NestItem> items);
    std::uint32_t place_of(std::size_t item) const noexcept { return place_of_[item]; }
    /// The items in the order of the result.
    std::span<const std::uint32_t> items() const noexcept { return item_at_; }

private:
    Worker& worker_;
    Vector<nesting::SortKey> by_start_{worker_.memory()}, spare_keys_{worker_.memory()};
    Vector<std::uint32_t> leader_of_{
        worker_.memory()};  // of each item: the outer of its group; see put_holes_after_outers()
    Vector<std::uint32_t> group_size_{worker_.memory()};  // of each leader
    Vector<std::uint32_t> next_place_{worker_.memory()};  // of each leader: where the next of its group goes
    Vector<std::uint32_t> place_of_{worker_.memory()};    // of each item
    Vector<std::uint32_t> item_at_{worker_.memory()};     // at each place
};

}  // namespace lamella
