// Which contours lie around which start points, for validate(): shares nothing with the nesting stage.
#pragma once

#include <cstddef>
#include <span>

#include "base/parallel.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Calls visit(contour, around) for every closed contour with area of `layer`, where `around` lists the closed contours with
/// area whose winding number about the contour's start is not zero and that do not pass through it. Both index the layer's
/// contours. By a ray through the edges in the start's row: O(m log m) and, for each contour, the edges in its row.
void for_each_enclosure(const SliceResult& result, const Layer& layer,
                        FunctionRef<void(std::size_t contour, std::span<const std::size_t> around)> visit);

}  // namespace lamella
