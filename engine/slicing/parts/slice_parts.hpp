// Slicing several meshes at the planes of one plan.
#pragma once

#include <span>

#include "lamella/source.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

/// Preconditions: options were checked. Throws Refused, Stopped, std::bad_alloc.
void slice_parts(std::span<const Part> parts, const SliceCall& call, LayerTarget& target, SliceResult& result);

/// The layers of a slice that was made whole, of one part. `result` gets its summary. Throws Refused, Stopped,
/// std::bad_alloc.
void hand_over_whole(SliceResult& whole, const SliceCall& call, LayerTarget& target, SliceResult& result);

/// What is known before anything is cut: of all parts together.
void outline_parts(std::span<const Part> parts, const SliceCall& call, SliceInfo& info);

}  // namespace lamella
