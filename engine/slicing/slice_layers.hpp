// Slicing for callers within the library: from any source, for any target.
#pragma once

#include "lamella/slice.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/workspace.hpp"

namespace lamella {

/// Refuses what no mesh can be sliced with.
void check_options(const SliceOptions& options);

/// A slice of `source`, which has the tools of `kept`. `result` gets what is not in layers; `first_index` is that of the
/// first layer that a sink gets. Preconditions: options were checked. Throws Refused, Stopped, std::bad_alloc.
void slice_layers(TriangleSource& source, LayerTarget& target, const SliceOptions& options, detail::WorkspaceParts& kept,
                  SliceResult& result, std::uint64_t first_index = 0);

/// The stages up to the count of crossings, which leave planes and buckets in `kept`.
void count_layers(TriangleSource& source, const SliceOptions& options, detail::WorkspaceParts& kept, SliceResult& result);

}  // namespace lamella
