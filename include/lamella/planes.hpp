// Where to cut.
//
//     lamella::SliceOptions options;
//     options.plan.spacing = lamella::UniformLayers{.layer_height_mm = 0.1};          // every 0.1 mm
//     options.plan.spacing = lamella::ExplicitPlanes{.heights_mm = {1.5, 2, 7.25}};   // or at these heights
//
// A layer is a slab of material with a bottom, a top and one plane between them, whose cross-section stands for the slab.
// Heights are absolute, in mm along the slicing direction.
//
// Rounding rule: every plane's height is computed by itself (z0 + i·h, never by adding rounded steps), rounded first exactly
// as a vertex of that height would be (to the mesh's number type, then to the even grid), then moved one unit down
// (PlaneSide::below, the default) or up. A flat face drawn at that very height is therefore always on the same side of it.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "lamella/experiments.hpp"

namespace lamella {

enum class PlaneSide : std::uint8_t { below, above };

enum class Datum : std::uint8_t {
    mesh_min,  ///< heights count from the mesh's lowest vertex
    zero,      ///< heights count from z = 0
};

/// Layers of one height from the datum up, the plane in the middle of each or, with `first_height_mm`, the first plane at
/// that height above the datum and the rest one layer height apart. Only planes strictly inside the mesh's z range are kept.
struct UniformLayers {
    double layer_height_mm = 0.2;
    std::optional<double> first_height_mm{};
    Datum datum = Datum::mesh_min;
};

/// Planes at the given absolute heights, in any order. Heights that round to one plane share one layer, whose
/// `Layer::plane_mm` is the least of them: layers stay ascending and distinct, and SliceResult::layer_of names the layer of
/// each height. Heights outside the mesh give empty layers (beyond the grid's reach, `Layer::plane` only keeps their order).
/// A layer reaches from the middle between its plane and the one below to the middle between it and the one above.
struct ExplicitPlanes {
    std::vector<double> heights_mm;
};

/// Layers [first, end) of a plan, counted from 0.
struct LayerRange {
    std::uint64_t first = 0;
    std::uint64_t end = std::numeric_limits<std::uint64_t>::max();  ///< one past the last; may lie beyond the plan's end
    friend constexpr bool operator==(const LayerRange&, const LayerRange&) = default;
};

struct LayerPlan {
    std::variant<UniformLayers, ExplicitPlanes, RandomLayers> spacing = UniformLayers{};
    PlaneSide side = PlaneSide::below;
};

}  // namespace lamella
