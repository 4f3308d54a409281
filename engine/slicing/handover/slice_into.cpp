#include "lamella/host_output.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "lamella/prepare.hpp"
#include "slicing/handover/host_points.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/prepared_parts.hpp"

namespace lamella {

namespace {

/// A bound on the coordinates of contours, in grid units.
double farthest_units(const SliceResult& result) noexcept {
    double farthest_mm = 0;
    for (int axis = 0; axis < 2; ++axis) {
        farthest_mm = std::max({farthest_mm, std::abs(result.summary.min_mm[axis]), std::abs(result.summary.max_mm[axis])});
    }
    // Vertices are rounded by a unit at most, points of regions by another. Miters reach as far as check_reach() says.
    const RegionRules& rules = result.region;
    const double reach_mm = std::max(2.0, rules.miter_limit) * (rules.close_mm + std::abs(rules.offset_mm));
    return std::min(std::ceil((farthest_mm + reach_mm) / result.unit_mm) + 2, double{grid_limit});
}

class HostArrays final : public SliceOutput {
public:
    explicit HostArrays(const HostOutput& host) : host_(host), writer_(host) {}

    Status admit(const PlaneSet& planes, const Buckets& /*buckets*/, const SliceResult& result,
                 std::uint64_t /*memory_limit*/) override {
        if (planes.size() > host_.layer_capacity) {
            return Error{ErrorCode::result_too_large, "the slice has " + counted(planes.size(), "layer") +
                                                          ", but there is memory for " +
                                                          std::to_string(host_.layer_capacity)};
        }
        return check_scale(host_, farthest_units(result));
    }

    Status take_bands(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) override {
        Placement& placement = input.scratch.placement;
        const bool plain = is_plain(host_);
        std::span<Point> points;
        if (plain && host_.point_capacity > 0) {
            points = {static_cast<Point*>(host_.points), host_.point_capacity};
        }
        std::span<PointOrigin> origins;
        if (input.origins && host_.origins != nullptr) {
            origins = {host_.origins, host_.point_capacity};
        }
        placement.begin(input.bands, input.parallel.threads(), input.buckets.segment_count, points, input.progress,
                        input.parallel.stop(), origins, plain ? nullptr : &writer_);
        sweep(placement);
        return check_room(input);
    }

    Status finish(const SweepInput& input) override {
        const Placement& placement = input.scratch.placement;
        const std::span<Layer> layers(host_.layers, input.planes.size());
        const std::span<Contour> contours(host_.contours, placement.contour_count());
        fill_layers(input, layers);
        placement.write_contours(input.parallel, contours, layers);
        if (host_.closed_gaps != nullptr) {
            placement.write_closed_gaps({host_.closed_gaps, placement.closed_gap_count()}, input.parallel.stop());
        }
        set_counts(placement.contour_counts(), layers, input.result);
        layers_ = layers.size();
        contours_ = contours.size();
        points_ = placement.point_count();
        closed_gaps_ = placement.closed_gap_count();
        return {};
    }

    SliceTotals totals(SliceResult& result) const {
        return {layers_,
                contours_,
                points_,
                closed_gaps_,
                result.unit_mm,
                result.close_gaps_mm,
                result.first_layer,
                result.all_layers,
                std::move(result.layer_of),
                result.summary};
    }

private:
    Status check_room(const SweepInput& input) const {
        const Placement& placement = input.scratch.placement;
        const std::uint64_t gaps = host_.closed_gaps == nullptr ? 0 : placement.closed_gap_count();
        if (placement.point_count() <= host_.point_capacity && placement.contour_count() <= host_.contour_capacity &&
            gaps <= host_.closed_gap_capacity) {
            return {};
        }
        return Error{ErrorCode::result_too_large, "the slice has " + counted(placement.contour_count(), "contour") + ", " +
                                                      counted(placement.point_count(), "point") + " and " +
                                                      counted(placement.closed_gap_count(), "closed gap") +
                                                      ", but there is memory for " + std::to_string(host_.contour_capacity) +
                                                      ", " + std::to_string(host_.point_capacity) + " and " +
                                                      std::to_string(host_.closed_gap_capacity)};
    }

    const HostOutput& host_;
    HostPoints writer_;
    std::uint64_t layers_ = 0;
    std::uint64_t contours_ = 0;
    std::uint64_t points_ = 0;
    std::uint64_t closed_gaps_ = 0;
};

/// Admits everything and keeps the numbers.
class Counting final : public SliceOutput {
public:
    Status admit(const PlaneSet& planes, const Buckets& buckets, const SliceResult& result,
                 std::uint64_t /*memory_limit*/) override {
        bounds_ = {.layers = planes.size(),
                   .contours = buckets.segment_count,
                   .points = 2 * buckets.segment_count,
                   .segments = buckets.segment_count,
                   .are_certain = result.region.keeps_contours(),
                   .unit_mm = result.unit_mm};
        return {};
    }
    Status take_bands(const SweepInput& /*input*/, FunctionRef<void(BandTarget&)> /*sweep*/) override { return {}; }
    Status finish(const SweepInput& /*input*/) override { return {}; }

    const OutputBounds& bounds() const noexcept { return bounds_; }

private:
    OutputBounds bounds_;
};

Result<OutputBounds> count(const detail::SliceInput& input, const SliceOptions& options, Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<OutputBounds> {
        Counting counting;
        SliceResult result(options.control.memory);
        if (Status status = detail::PartSlicer::admit(counting, input, options, workspace, result); !status) {
            return status.error();
        }
        return counting.bounds();
    });
}

Result<SliceTotals> write_into(const HostOutput& output, const detail::SliceInput& input, const SliceOptions& options,
                               Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<SliceTotals> {
        if (Status status = check_host(output); !status) {
            return status.error();
        }
        HostArrays arrays(output);
        SliceResult result(options.control.memory);
        if (Status status = detail::PartSlicer::slice_for(arrays, input, options, workspace, result); !status) {
            return status.error();
        }
        return arrays.totals(result);
    });
}

}  // namespace

Result<OutputBounds> bound_output(const MeshView& mesh, const SliceOptions& options, Workspace& workspace) noexcept {
    return count({mesh}, options, workspace);
}

Result<OutputBounds> bound_output(const PreparedMesh& mesh, const SliceOptions& options, Workspace& workspace) noexcept {
    const detail::PreparedParts& prepared = mesh.parts();
    return count({prepared.counted, &prepared.frame, &prepared}, options, workspace);
}

Result<OutputBounds> bound_output(const MeshView& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return bound_output(mesh, options, workspace);
}

Result<OutputBounds> bound_output(const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return bound_output(mesh, options, workspace);
}

Result<SliceTotals> slice_into(const HostOutput& output, const MeshView& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept {
    return write_into(output, {mesh}, options, workspace);
}

Result<SliceTotals> slice_into(const HostOutput& output, const PreparedMesh& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept {
    const detail::PreparedParts& prepared = mesh.parts();
    return write_into(output, {prepared.counted, &prepared.frame, &prepared}, options, workspace);
}

Result<SliceTotals> slice_into(const HostOutput& output, const MeshView& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return slice_into(output, mesh, options, workspace);
}

Result<SliceTotals> slice_into(const HostOutput& output, const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return slice_into(output, mesh, options, workspace);
}

}  // namespace lamella
