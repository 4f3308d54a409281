// Layers that were built apart, a few a task, put one on the other.
#pragma once

#include <memory>
#include <span>

#include "base/parallel.hpp"
#include "lamella/result.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

/// Moves the layers of `outputs`, whose first_layer ascends without gap from 0, to `result`: contours, points, origins where
/// `with_origins`, and where each layer's contours lie. Precondition: result.layers has a layer for each. Returns how many
/// contours there are. One call of run(). Throws std::bad_alloc.
ContourCounts stack_outputs(std::span<const std::unique_ptr<BandOutput>> outputs, bool with_origins,
                            const Parallel& parallel, SliceResult& result);

}  // namespace lamella
