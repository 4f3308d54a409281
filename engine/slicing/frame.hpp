// The grid and the box of what is sliced: from both come the planes. One choice for a mesh, for several parts of one result,
// for a prepared mesh and for a file.
#pragma once

#include "base/guard.hpp"
#include "lamella/mesh.hpp"
#include "lamella/slice.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/regions/rules.hpp"

namespace lamella {

/// For triangles within `bounds`, whose planes are rounded to `number`. Throws Refused.
inline SharedFrame choose_frame(const Bounds& bounds, CoordinateType number, double asked_mm, UnitFit fit,
                                const RegionRules& rules) {
    return {bounds, require(choose_unit_for(bounds, asked_mm, fit, rules)), number};
}

/// For one mesh, by options that name a transform and a unit. Without triangles, where that is allowed, the box is a point.
template <class Options>
SharedFrame choose_frame(const MeshView& mesh, const Options& options, const RegionRules& rules, const Parallel& parallel) {
    Bounds bounds{};
    if (!options.allow_empty || mesh.triangle_count > 0) {
        BlockTable blocks(options.control.memory);
        bounds = require(measure_bounds(mesh, options.transform, options.unit_mm, parallel, blocks));
    }
    return choose_frame(bounds, placed_number(mesh, options.transform), options.unit_mm, options.unit_fit, rules);
}

/// The planes of `plan` within the frame's box, less those that `layers` leaves out. Throws Refused.
inline void build_planes(const LayerPlan& plan, const LayerRange& layers, const SharedFrame& frame,
                         std::uint64_t memory_limit, PlaneSet& planes) {
    require(planes.build(plan, frame.bounds, frame.unit.mm, frame.number, memory_limit));
    require(planes.keep(layers));
}

}  // namespace lamella
