#include "slicing/result/result_output.hpp"

#include <algorithm>
#include <string>

#include "base/words.hpp"

namespace lamella {

Status ResultOutput::admit(const PlaneSet& planes, const Buckets& buckets, const SliceResult& /*result*/,
                           std::uint64_t memory_limit) {
    const auto cutting =
        std::count_if(buckets.segments.begin(), buckets.segments.end(), [](auto count) { return count > 0; });
    const std::uint64_t bytes = buckets.segment_count * point_bytes_ + planes.size() * sizeof(Layer) +
                                planes.plane_of_listed().size() * sizeof(std::uint64_t) +
                                static_cast<std::uint64_t>(cutting) * sizeof(Contour);
    if (bytes > memory_limit) {
        return Error{ErrorCode::result_too_large,
                     counted(planes.size(), "layer") + " with " + counted(buckets.segment_count, "segment") + " need " +
                         std::to_string(bytes) + " bytes, more than the memory limit of " + std::to_string(memory_limit)};
    }
    return {};
}

/// A closed contour has at most as many points as segments; an open one has one more, for which there is some room. A mesh
/// with very many open polylines needs more room and is swept again with the number of points counted.
Status ResultOutput::take_bands(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) {
    Placement& placement = input.scratch.placement;
    Array<Point>& points = input.result.points;
    Array<PointOrigin>& origins = input.result.origins;
    const std::uint64_t segments = input.buckets.segment_count;
    std::uint64_t room = segments + segments / 64 + 64;
    for (;;) {
        points.resize_discarding(room);
        origins.resize_discarding(input.origins ? room : 0);
        placement.begin(input.bands, input.parallel.threads(), segments, points.span(), input.progress,
                        input.parallel.stop(), origins.span());
        sweep(placement);
        const std::uint64_t needed = placement.point_count();
        if (needed <= room) {
            points.set_size(needed);
            origins.set_size(input.origins ? needed : 0);
            return {};
        }
        room = needed;
    }
}

Status ResultOutput::finish(const SweepInput& input) {
    const Placement& placement = input.scratch.placement;
    SliceResult& result = input.result;
    result.contours.resize_discarding(placement.contour_count());
    result.layers.resize_discarding(input.planes.size());
    result.closed_gaps.resize_discarding(placement.closed_gap_count());
    placement.write_closed_gaps(result.closed_gaps.span(), input.parallel.stop());
    fill_layers(input, result.layers.span());
    placement.write_contours(input.parallel, result.contours.span(), result.layers.span());
    set_counts(placement.contour_counts(), result);
    return {};
}

void fill_layers(const SweepInput& input, std::span<Layer> layers) {
    input.parallel.run_ranges(layers.size(), 1 << 10, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            layers[i] = describe_layer(input.planes, input.buckets, static_cast<PlaneIndex>(i));
        }
    });
}

}  // namespace lamella
