// Slicing for callers within the library: from any source, for any target.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "lamella/source.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/repair/polylines.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slicer.hpp"
#include "slicing/tuning.hpp"

namespace lamella {

/// All that is asked and lent.
struct SliceCall {
    const SliceOptions& options;
    const Tuning& tuning;
    const Context& context;
    detail::SlicerImpl& kept;

    /// Of a result. What it admits can be addressed.
    std::uint64_t memory_limit() const noexcept {
        const std::uint64_t asked = context.memory_limit_bytes != 0 ? context.memory_limit_bytes : kept.usual_limit;
        return std::min<std::uint64_t>(asked, std::numeric_limits<std::size_t>::max());
    }
};

/// Refuses what no mesh can be sliced with.
void check_options(const SliceOptions& options, const Tuning& tuning);

// These throw Refused, Stopped, std::bad_alloc. Precondition: options were checked. `info` gets what is not in layers: where
// `target` is null, what is known before anything is cut.

/// A slice of `source`, which has the tools of `call.kept`. `first_index` is that of the first layer.
void slice_layers(TriangleSource& source, LayerTarget* target, const SliceCall& call, SliceInfo& info,
                  std::uint64_t first_index = 0);

/// Several meshes, each by itself, and their layers by roles, then side by side or united.
void slice_parts(std::span<const Part> parts, const SliceCall& call, LayerTarget* target, SliceInfo& info);

/// n triangles, m pieces, q points left of a layer when its edges between pieces have cancelled: O(n + k + m) for k uniform
/// planes, O(n log k + k + m) otherwise, and O(q log q) a layer. Memory: 8 bytes a piece, about 200 a piece of the largest
/// layer for each thread, and the result.
void slice_faces(const MeshView& mesh, const SliceCall& call, LayerTarget* target, SliceInfo& info);

/// Refuses sources that have no faces, and rules that pieces cannot have.
void check_faces(const Source& from, const SliceOptions& options);

// The grid and the box of what is sliced: from both come the planes. One choice for a mesh, for several parts of one result,
// for a prepared mesh and for a file.

/// For triangles within `bounds`, whose planes are rounded to `number`. Throws Refused.
inline SharedFrame choose_frame(const Bounds& bounds, Number number, const Frame& asked, const RegionRules& rules) {
    return {bounds, require(choose_unit_for(bounds, asked.grid_mm, asked.coarser_if_needed, rules)), number};
}

/// For one mesh. Without triangles, where that is allowed, the box is a point.
inline SharedFrame choose_frame(const MeshView& mesh, const Frame& asked, bool allow_empty, const RegionRules& rules,
                                const Parallel& parallel) {
    const Placing placing = placing_of(mesh, asked);
    Bounds bounds{};
    if (!allow_empty || mesh.triangle_count > 0) {
        BlockTable blocks(parallel.memory());
        bounds = require(measure_bounds(mesh, placing, asked.grid_mm, parallel, blocks));
    }
    return choose_frame(bounds, placed_number(mesh, placing), asked, rules);
}

/// The planes that are asked for within the frame's box, less the layers that are left out, above the mesh as it is read.
/// Throws Refused.
inline void build_planes(const SliceCall& call, const SharedFrame& frame, PlaneSet& planes) {
    planes.build(call.options, call.tuning.random_heights, frame, call.memory_limit());
    planes.keep(call.options.planes.first_layer, call.options.planes.end_layer);
    planes.lower(frame.raised);
}

inline Box box_of(const Bounds& bounds) noexcept {
    return {std::to_array(bounds.min_mm), std::to_array(bounds.max_mm)};
}

/// An option speaks for itself; of a mesh among several the message must say which.
inline Error blamed_on_part(Error error, std::size_t part) {
    if (error.triangle >= 0 || error.code == ErrorCode::empty_mesh || error.code == ErrorCode::bad_coordinate) {
        error.message = "part " + std::to_string(part) + ": " + error.message;
        error.part = static_cast<std::int64_t>(part);
    }
    return error;
}

/// What is known of a slice before its triangles are counted.
inline void begin_info(const SliceOptions& options, const Bounds& box, const ChosenUnit& unit, SliceInfo& info) {
    std::vector<std::uint64_t> layer_of = std::move(info.layer_of);  // keeps its memory
    SliceOptions asked = std::move(info.options);
    asked = options;
    info = {};
    info.options = std::move(asked);
    info.layer_of = std::move(layer_of);
    info.options.stitch_mm = gap_length_mm(options.stitch_mm, box);
    info.grid_mm = unit.mm;
    info.grid_doublings = unit.doublings;
    info.box = box_of(box);
}

/// For layers from number 0 on. Precondition: begin_info() was called; the options must stay.
inline LayerRules rules_for(const SliceOptions& options, const SliceInfo& info) noexcept {
    const double stitch_mm = info.options.stitch_mm;
    return {.region = &options.region,
            .grid_mm = info.grid_mm,
            .stitch = stitch_mm / info.grid_mm,
            .crossing_stitch = crossing_gap_mm(options.stitch_mm, stitch_mm) / info.grid_mm,
            .direction = options.stitch_direction};
}

}  // namespace lamella

namespace lamella::detail {

/// A source of another room, such as a file, as a Slicer sees it.
/// The functions throw Refused, Stopped, std::bad_alloc.
class SourceImpl {
public:
    virtual ~SourceImpl() = default;
    /// All layers, in ranges, after LayerTarget::announce(). Fills in `info`, where `target` is null as for an outline.
    virtual void slice(LayerTarget* target, const SliceCall& call, SliceInfo& info) const = 0;
};

}  // namespace lamella::detail
