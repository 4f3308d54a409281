// The results of several meshes, sliced at the same planes, as one result.
//
//     part 0    layer 0 [ a b ]   layer 1 [ c ]
//     part 1    layer 0 [ d ]     layer 1 [ e ]
//     merged    layer 0 [ a b d ] layer 1 [ c e ]       contours, and their points in the same order
#pragma once

#include <span>

#include "base/parallel.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Fills in all of `merged` but region, frame and plan. Preconditions: there is a part; all have the same planes. O(n + p k)
/// for n points and contours, p parts and k planes. Throws std::bad_alloc.
void merge_parts(std::span<const SliceResult> parts, const Parallel& parallel, SliceResult& merged);

}  // namespace lamella
