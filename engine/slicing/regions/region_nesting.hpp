// Parents and roles of a region's contours.
//
// Contours that were clipped together may touch, so that a start says nothing about what encloses them: clipping reports
// which of them lies directly in which. The outermost ones of a cluster all have the same parent, which nesting finds for
// the first of them to start. Contours that were not clipped touch nothing, and nesting alone decides.
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/fill.hpp"

namespace lamella {

/// One per thread; scratch is kept.
class RegionNesting {
public:
    explicit RegionNesting(const Memory* memory) : item_of_(memory), cluster_parent_(memory) {}

    /// Fills in the outputs of `items`, which are by start. region_of[i]: the contour of `region` that item i is, -1 for an
    /// open polyline. False if roles do not alternate from parent to child. O(q log q). Throws std::bad_alloc.
    bool nest(std::span<NestItem> items, std::span<const std::int64_t> region_of, std::span<const RegionContour> region,
              std::size_t clusters, Nester& nester);

private:
    Vector<std::int32_t> item_of_;         // of each contour of the region
    Vector<std::int32_t> cluster_parent_;  // of each cluster, once the first of it has come
};

}  // namespace lamella
