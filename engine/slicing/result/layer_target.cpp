#include "slicing/result/layer_target.hpp"

#include <algorithm>
#include <cassert>
#include <string>

#include "base/guard.hpp"
#include "base/words.hpp"

namespace lamella {

void ResultTarget::admit(const OutputPlan& plan, std::uint64_t memory_limit) const {
    const std::uint64_t point_bytes = sizeof(Point) + (plan.origins ? sizeof(PointOrigin) : 0);
    const std::uint64_t bytes = plan.segments * point_bytes + plan.layers * sizeof(Layer) +
                                plan.result.info.layer_of.size() * sizeof(std::uint64_t) + plan.cutting * sizeof(Contour);
    if (bytes > memory_limit) {
        throw Refused{{ErrorCode::result_too_large,
                       counted(plan.layers, "layer") + " with " + counted(plan.segments, "segment") + " need " +
                           std::to_string(bytes) + " bytes, more than the memory limit of " + std::to_string(memory_limit)}};
    }
}

/// A closed contour has at most as many points as segments; an open one has one more, for which there is some room. What
/// very many open polylines have beyond that is kept until the array is made larger.
BandTarget& ResultTarget::begin(const OutputPlan& plan) {
    plan.result.points.resize_discarding(plan.segments + plan.segments / 64 + 64);
    Placement& placement = plan.scratch.placement;
    placement.begin(plan.bands, plan.lead, plan.origins, plan.result, plan.parallel.stop());
    return placement;
}

void ResultTarget::finish(const OutputPlan& plan) {
    SliceResult& result = plan.result;
    result.layers.resize_discarding(plan.layers);
    fill_layers(plan, result.layers.span());
    plan.scratch.placement.finish(plan.parallel, result);
    set_counts(plan.scratch.placement.totals().counts, result);
}

void move_to(const Memory* memory, SliceResult& result) {
    if (result.points.memory() != memory) {
        result = SliceResult(memory);
    }
}

void fill_layers(const OutputPlan& plan, std::span<Layer> layers) {
    plan.parallel.run_ranges(layers.size(), 1 << 10, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            layers[i] = plan.layer_at(static_cast<PlaneIndex>(i));
        }
    });
}

void describe_plan(const PlaneSet& planes, bool list_heights, SliceInfo& info) {
    const Vector<PlaneIndex>& listed = planes.plane_of_listed();
    info.layer_of.assign(listed.begin(), listed.end());
    if (list_heights) {
        info.options.heights_mm.emplace(planes.listed_mm().begin(), planes.listed_mm().end());
    }
    info.layers = planes.size();
    info.first_layer = planes.first_kept();
    info.planned_layers = planes.planned();
}

void add_work(const SliceInfo& part, SliceInfo& sum) noexcept {
    sum.triangles += part.triangles;
    sum.degenerate += part.degenerate;
    sum.crossed += part.crossed;
    sum.segments += part.segments;
    sum.bands += part.bands;
    sum.ms.bucket += part.ms.bucket;
    sum.ms.sweep += part.ms.sweep;
    sum.ms.contours += part.ms.contours;
    sum.ms.nesting += part.ms.nesting;
    sum.ms.fill += part.ms.fill;
}

}  // namespace lamella
