// Slicing several meshes, as the list of its stages:
//
//     choose_frame       the box of all parts, and from it one grid and one set of planes
//     slice_all          each part by itself, by all threads
//     merge_parts        contours of all parts, side by side in each layer, or one region of them
#include "lamella/parts.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/frame.hpp"
#include "slicing/parts/merge_parts.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

class PartSlicing {
public:
    PartSlicing(std::span<const Part> parts, const SliceOptions& options, PartRegions regions)
        : parts_(parts),
          options_(options),
          regions_(regions),
          parallel_(options.control),
          progress_(options.control.progress) {}

    SliceResult run() {
        check_options(options_);
        if (united()) {
            require(check_uniting(options_.region));
        }
        choose_frame();
        slice_all();
        if (nothing_left()) {  // its box must not choose planes
            frame_.bounds = {};
            sliced_.clear();
            slice_all();
        }
        SliceResult merged(options_.control.memory);
        merged.region = options_.region;
        merged.frame = options_.transform;
        merged.plan = options_.plan;
        const auto reach = [this](double share) { progress_.reach(sliced_share() + (0.99 - sliced_share()) * share); };
        merge_parts(sliced_, regions_, options_.control, parallel_, reach, merged);
        std::copy_n(frame_.bounds.min_mm, 3, merged.summary.min_mm);
        std::copy_n(frame_.bounds.max_mm, 3, merged.summary.max_mm);
        progress_.finish();
        return merged;
    }

private:
    bool united() const noexcept { return regions_ == PartRegions::united; }
    /// The progress when all parts are sliced.
    double sliced_share() const noexcept { return united() ? 0.5 : 0.95; }

    /// A part's own progress, as a share of the whole.
    struct Share {
        ProgressMeter& whole;
        double from;
        double length;
        void operator()(double fraction) const noexcept { whole.reach(from + length * fraction); }
    };

    Transform transform_of(const Part& part) const noexcept { return options_.transform * part.transform; }

    /// An option speaks for itself; of a mesh the message must say which.
    static Error blame(Error error, std::size_t part) {
        if (error.triangle >= 0 || error.code == ErrorCode::empty_mesh || error.code == ErrorCode::bad_coordinate) {
            error.message = "part " + std::to_string(part) + ": " + error.message;
        }
        return error;
    }

    void choose_frame() {
        BlockTable table(options_.control.memory);
        Bounds bounds = Bounds::empty();
        CoordinateType number = CoordinateType::f32;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const Transform transform = transform_of(parts_[p]);
            if (options_.allow_empty && parts_[p].mesh.triangle_count == 0) {
                continue;
            }
            const Result<Bounds> own = measure_bounds(parts_[p].mesh, transform, options_.unit_mm, parallel_, table);
            if (!own) {
                throw Refused{blame(own.error(), p)};
            }
            bounds.add(*own);
            if (placed_number(parts_[p].mesh, transform) == CoordinateType::f64) {
                number = CoordinateType::f64;
            }
            triangles_ += parts_[p].mesh.triangle_count;
        }
        frame_ = lamella::choose_frame(triangles_ == 0 ? Bounds{} : bounds, number, options_.unit_mm, options_.unit_fit,
                                       options_.region);
    }

    void slice_all() {
        SliceOptions options = options_;
        options.control.stop = parallel_.stop();  // the host's, asked no more often for many parts
        if (united()) {
            options.region = {};
        }
        Workspace workspace;
        std::uint64_t before = 0;  // triangles of the parts before
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const auto share = [&](std::size_t triangles) {
                return sliced_share() * static_cast<double>(triangles) /
                       static_cast<double>(std::max<std::uint64_t>(1, triangles_));
            };
            const Share sink{progress_, share(before), share(parts_[p].mesh.triangle_count)};
            options.transform = transform_of(parts_[p]);
            options.control.progress = Progress::to(sink);
            options.memory_limit_bytes = memory_left();
            SliceResult& result = sliced_.emplace_back(options_.control.memory);
            try {
                detail::WorkspaceParts& kept = detail::WorkspaceParts::of(workspace, options.control);
                AnyMeshSource source(parts_[p].mesh, options.transform, &frame_, kept.source_tools());
                ResultTarget target;
                slice_layers(source, target, options, kept, result);
            } catch (Refused& refused) {
                throw Refused{blame(std::move(refused.error), p)};
            }
            before += parts_[p].mesh.triangle_count;
        }
    }

    bool nothing_left() const noexcept {
        return std::all_of(sliced_.begin(), sliced_.end(),
                           [](const SliceResult& part) { return part.summary.degenerate == part.summary.triangles; });
    }

    /// The rest of the limit that was asked for; where none was, each part has its own.
    std::uint64_t memory_left() const noexcept {
        std::uint64_t left = options_.memory_limit_bytes;
        for (const SliceResult& result : sliced_) {
            const std::uint64_t bytes = result.points.size() * sizeof(Point) + result.contours.size() * sizeof(Contour) +
                                        result.origins.size() * sizeof(PointOrigin);
            left = left > bytes ? left - bytes : std::min<std::uint64_t>(left, 1);
        }
        return left;
    }

    std::span<const Part> parts_;
    const SliceOptions& options_;
    PartRegions regions_;
    Parallel parallel_;
    ProgressMeter progress_;
    SharedFrame frame_{};
    std::uint64_t triangles_ = 0;
    std::vector<SliceResult> sliced_;
};

}  // namespace

Result<SliceResult> slice_parts(std::span<const Part> parts, const SliceOptions& options, PartRegions regions) noexcept {
    return guarded(options.control, [&]() -> Result<SliceResult> {
        if (parts.empty()) {
            return Error{ErrorCode::invalid_argument, "there are no parts to slice"};
        }
        if (constexpr std::size_t most = std::numeric_limits<std::uint16_t>::max(); options.origins && parts.size() > most) {
            return Error{ErrorCode::invalid_argument, "origins name one of at most " + std::to_string(most) +
                                                          " parts, not of " + std::to_string(parts.size())};
        }
        return PartSlicing(parts, options, regions).run();
    });
}

}  // namespace lamella
