// A layer of a result, as sinks get layers.
#pragma once

#include <algorithm>
#include <cstdint>

#include "lamella/result.hpp"
#include "lamella/sink.hpp"

namespace lamella {

/// The gaps that were closed in a layer. O(log gaps).
inline std::span<const ClosedGap> closed_gaps_of(const SliceResult& result, std::uint64_t layer) noexcept {
    const auto before = [](const ClosedGap& gap, std::uint64_t other) { return gap.layer < other; };
    const ClosedGap* const end = result.closed_gaps.end();
    const ClosedGap* const first = std::lower_bound(result.closed_gaps.begin(), end, layer, before);
    return {first, std::lower_bound(first, end, layer + 1, before)};
}

/// Its points are all of the result's, as the contours count them; parents are those of the result, too.
inline LayerView view_of_layer(const SliceResult& result, std::uint64_t index) noexcept {
    const Layer& layer = result.layers[index];
    return {.index = index,
            .layer = layer,
            .contours = result.contours_of(layer),
            .points = {result.points.data(), result.points.size()},
            .origins = {},
            .closed_gaps = closed_gaps_of(result, index),
            .unit_mm = result.unit_mm};
}

}  // namespace lamella
