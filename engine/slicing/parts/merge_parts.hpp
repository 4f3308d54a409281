// The results of several meshes, sliced at the same planes, as one result.
//
//     part 0    layer 0 [ a b ]   layer 1 [ c ]
//     part 1    layer 0 [ d ]     layer 1 [ e ]
//     merged    layer 0 [ a b d ] layer 1 [ c e ]       contours, and their points in the same order
//     united    layer 0 [ region of a, b and d ] ...
#pragma once

#include <span>

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Fills in the layers of `merged` and the rest of its info, of which options, box and grid are set. `united`: makes regions
/// by the options' rules of the contours that all parts have in a layer, by the orientation of their facets; no layer's rule
/// may be `contours` then. Contours and origins of `parts` get the number of their part. Preconditions: there is a part; all
/// have the same planes. O(n + p k) for n points and contours, p parts and k planes, and for regions O(q log q) for a layer
/// of q points. `reach` is told the share of layers that are done. Throws std::bad_alloc, Stopped.
void merge_parts(std::span<SliceResult> parts, bool united, const Parallel& parallel, FunctionRef<void(double)> reach,
                 SliceResult& merged);

/// Adds to `sum` what part number `part` has.
void add_part(const SliceInfo& own, std::size_t part, SliceInfo& sum);

}  // namespace lamella
