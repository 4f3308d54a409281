// slice_to() for callers within the library: on a grid and at planes that are chosen already.
#pragma once

#include "lamella/sink.hpp"
#include "slicing/part_slicer.hpp"

namespace lamella {

/// As slice_to().
Result<SliceTotals> hand_over(const LayerSink& sink, const detail::SliceInput& input, const SliceOptions& options,
                              Workspace& workspace) noexcept;

}  // namespace lamella
