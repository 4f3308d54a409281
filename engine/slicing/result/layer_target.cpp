#include "slicing/result/layer_target.hpp"

#include <algorithm>
#include <cassert>
#include <string>

#include "base/guard.hpp"
#include "base/words.hpp"

namespace lamella {

void ResultTarget::admit(const SweepInput& input, std::uint64_t memory_limit) {
    const std::uint64_t segments = input.buckets.segment_count;
    const std::uint64_t point_bytes = sizeof(Point) + (input.origins ? sizeof(PointOrigin) : 0);
    const auto cutting = std::count_if(input.buckets.segments.begin(), input.buckets.segments.end(),
                                       [](std::uint32_t count) { return count > 0; });
    const std::uint64_t bytes = segments * point_bytes + input.planes.size() * sizeof(Layer) +
                                input.planes.plane_of_listed().size() * sizeof(std::uint64_t) +
                                static_cast<std::uint64_t>(cutting) * sizeof(Contour);
    if (bytes > memory_limit) {
        throw Refused{{ErrorCode::result_too_large,
                       counted(input.planes.size(), "layer") + " with " + counted(segments, "segment") + " need " +
                           std::to_string(bytes) + " bytes, more than the memory limit of " + std::to_string(memory_limit)}};
    }
}

/// A closed contour has at most as many points as segments; an open one has one more, for which there is some room. What
/// very many open polylines have beyond that is kept until the array is made larger.
BandTarget& ResultTarget::begin(const SweepInput& input) {
    const std::uint64_t segments = input.buckets.segment_count;
    input.result.points.resize_discarding(segments + segments / 64 + 64);
    Placement& placement = input.scratch.placement;
    placement.begin(input.bands, input.lead(), input.origins, input.result, input.parallel.stop());
    return placement;
}

void ResultTarget::finish(const SweepInput& input) {
    SliceResult& result = input.result;
    result.layers.resize_discarding(input.planes.size());
    fill_layers(input, result.layers.span());
    input.scratch.placement.finish(input.parallel, result);
    set_counts(input.scratch.placement.contour_counts(), result);
}

void ResultTarget::take_whole(SliceResult& /*whole*/, const Parallel& /*parallel*/) {
    assert(false);
}

void move_to(const Memory* memory, SliceResult& result) {
    if (result.points.memory() != memory) {
        result = SliceResult(memory);
    }
}

void fill_layers(const SweepInput& input, std::span<Layer> layers) {
    input.parallel.run_ranges(layers.size(), 1 << 10, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            layers[i] = describe_layer(input.planes, static_cast<PlaneIndex>(i), input.buckets.segments[i]);
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
