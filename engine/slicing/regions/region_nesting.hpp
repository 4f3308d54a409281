// Parents and roles of a region's contours.
//
// Contours that were made may touch in points, so that a start may lie on what encloses it, and nesting finds something
// larger. Only an outer one can: a hole touches nothing that its own piece of solid ends at, since it would be part of it.
// What it touches at its start then says where it lies, as nothing solid is between them: within a hole, or beside an outer
// one that has the same parent.
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/regions.hpp"

namespace lamella {

/// One per thread; scratch is kept.
class RegionNesting {
public:
    explicit RegionNesting(const Memory* memory) : item_of_(memory), is_settled_(memory) {}

    /// Fills in the outputs of `items`, which are by start. ring_of[i]: the one of `rings` that item i is, -1 for an
    /// open polyline. O(q log q). Throws std::bad_alloc.
    void nest(std::span<NestItem> items, std::span<const std::int64_t> ring_of, std::span<const Ring> rings, Nester& nester);

private:
    Vector<std::uint32_t> item_of_;    // of each ring
    Vector<std::uint8_t> is_settled_;  // of each item: its parent is what it lies in
};

}  // namespace lamella
