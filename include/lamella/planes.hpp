// Where to cut. A layer is a slab of material with a bottom, a top and one plane between them; the plane's cross-section
// stands for the slab. Heights are absolute, in mm along the slicing direction.
//
// Rounding rule: every plane's height is computed by itself (z0 + i·h, never by adding rounded steps), rounded first exactly
// as a vertex of that height would be (to the mesh's number type, then to the even grid), then moved one unit down
// (Side::below, the default) or up. A flat face drawn at that very height is therefore always on the same side of it.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

namespace lamella {

enum class Side : std::uint8_t { below, above };

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

/// Planes at the given absolute heights, ascending and distinct after rounding. Heights outside the mesh give empty layers
/// (beyond the grid's reach, `Layer::plane` only keeps their order).
/// A layer reaches from the middle between its plane and the one below to the middle between it and the one above.
struct ExplicitPlanes {
    std::vector<double> heights_mm;
};

/// Steps drawn uniformly from [min, max] by seed, from the mesh's lowest vertex up: the paper's adaptive experiment
/// (section 5). The generator is our own, so the same seed gives the same planes on every platform.
struct RandomLayers {
    double min_height_mm = 0.016;
    double max_height_mm = 0.032;
    std::uint64_t seed = 1;
};

struct LayerPlan {
    std::variant<UniformLayers, ExplicitPlanes, RandomLayers> spacing = UniformLayers{};
    Side side = Side::below;
};

}  // namespace lamella
