// A layer of a result, as sinks get layers.
#pragma once

#include <cstdint>

#include "lamella/result.hpp"
#include "lamella/sink.hpp"

namespace lamella {

/// Its points are all of the result's, as the contours count them; parents are those of the result, too.
inline LayerView view_of_layer(const SliceResult& result, std::uint64_t index) noexcept {
    const Layer& layer = result.layers[index];
    return {.index = index,
            .layer = layer,
            .contours = result.contours_of(layer),
            .points = {result.points.data(), result.points.size()},
            .origins = {},
            .closed_gaps = {},
            .unit_mm = result.unit_mm};
}

}  // namespace lamella
