// Layers of all parts, put together.
//
//     part 0    layer 0 [ a b ]   layer 1 [ c ]
//     part 1    layer 0 [ d ]     layer 1 [ e ]
//     merged    layer 0 [ a b d ] layer 1 [ c e ]       contours, and their points in the same order
//     united    layer 0 [ region of a, b and d ] ...    by the options' rules; no layer's may be `contours` then
#pragma once

#include <span>

#include "base/function_ref.hpp"
#include "slicing/parts/part_layers.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

/// What is put together.
struct PartsToMerge {
    std::span<const Layer> layers;  ///< without contours
    std::span<const PartLayers> parts;
    bool are_repeated;  ///< parts share results, so that a limit holds for what they become
};

/// Throws Refused where there are too many copies, a place is none, or copies cannot share points as is asked.
void check_places(std::span<const Part> parts, const SliceOptions& options);

/// O(n + p k) for n points and contours, p parts and k planes, which all parts have, and for regions O(q log q) for a layer
/// of q points. `merged` has the summary but for what the target counts; its options say whether parts are united. `reach`
/// is told the share of layers that are done. Throws Refused, std::bad_alloc, Stopped.
void merge_parts(const PartsToMerge& given, const SliceCall& call, LayerTarget& target, SliceInfo& merged,
                 FunctionRef<void(double)> reach);

}  // namespace lamella
