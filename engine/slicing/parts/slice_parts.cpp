// Slicing several meshes, as the list of its stages:
//
//     choose_frame       the box of all parts, and from it one grid and one set of planes
//     slice_all          each part by itself, by all threads
//     merge_parts        contours of all parts, side by side in each layer
//     unite_parts        one region of them, on request
#include "lamella/parts.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/grid/blocks.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/parts/merge_parts.hpp"
#include "slicing/parts/unite_parts.hpp"
#include "slicing/planes/shared_frame.hpp"
#include "slicing/regions/rules.hpp"

namespace lamella {

namespace {

class PartSlicing {
public:
    PartSlicing(std::span<const Part> parts, const SliceOptions& options, PartRegions regions)
        : parts_(parts),
          options_(options),
          united_(regions == PartRegions::united),
          parallel_(options.control),
          progress_(options.control.progress) {}

    Result<SliceResult> run() {
        if (Status status = check_rules(options_.region); !status) {
            return status.error();
        }
        if (Status status = united_ ? check_uniting(options_.region) : Status(); !status) {
            return status.error();
        }
        if (Status status = choose_frame(); !status) {
            return status.error();
        }
        if (Status status = slice_all(); !status) {
            return status.error();
        }
        if (nothing_left()) {  // its box must not choose planes
            frame_.bounds = {};
            sliced_.clear();
            if (Status status = slice_all(); !status) {
                return status.error();
            }
        }
        const auto start = Clock::now();
        SliceResult merged(options_.control.memory);
        merge_parts(sliced_, parallel_, merged);
        std::copy_n(frame_.bounds.min_mm, 3, merged.summary.min_mm);
        std::copy_n(frame_.bounds.max_mm, 3, merged.summary.max_mm);
        merged.summary.ms.contours += milliseconds_since(start);
        sliced_.clear();
        SliceResult result = united_ ? unite(merged) : std::move(merged);
        result.region = options_.region;
        result.frame = options_.transform;
        result.plan = options_.plan;
        progress_.finish();
        return result;
    }

private:
    /// Of the progress, when all parts are sliced.
    double sliced_share() const noexcept { return united_ ? 0.5 : 0.95; }

    /// What a part's own progress is of the whole.
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

    Status choose_frame() {
        BlockTable table(options_.control.memory);
        constexpr double infinity = std::numeric_limits<double>::infinity();
        frame_.bounds = {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
        frame_.number = CoordinateType::f32;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const Transform transform = transform_of(parts_[p]);
            if (options_.allow_empty && parts_[p].mesh.triangle_count == 0) {
                continue;
            }
            const Result<Bounds> own = measure_bounds(parts_[p].mesh, transform, options_.unit_mm, parallel_, table);
            if (!own) {
                return blame(own.error(), p);
            }
            for (int axis = 0; axis < 3; ++axis) {
                frame_.bounds.min_mm[axis] = std::min(frame_.bounds.min_mm[axis], own->min_mm[axis]);
                frame_.bounds.max_mm[axis] = std::max(frame_.bounds.max_mm[axis], own->max_mm[axis]);
            }
            if (placed_number(parts_[p].mesh, transform) == CoordinateType::f64) {
                frame_.number = CoordinateType::f64;
            }
            triangles_ += parts_[p].mesh.triangle_count;
        }
        if (triangles_ == 0) {
            frame_.bounds = {};
        }
        const Result<ChosenUnit> unit = choose_unit_for(frame_.bounds, options_.unit_mm, options_.unit_fit, options_.region);
        if (!unit) {
            return unit.error();
        }
        frame_.unit = *unit;
        return {};
    }

    Status slice_all() {
        SliceOptions options = options_;
        options.control.stop = parallel_.stop();  // the host's, asked no more often for many parts
        if (united_) {
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
            if (Status status = detail::PartSlicer::slice({parts_[p].mesh, &frame_}, options, workspace, result); !status) {
                return blame(status.error(), p);
            }
            before += parts_[p].mesh.triangle_count;
        }
        return {};
    }

    bool nothing_left() const noexcept {
        return std::all_of(sliced_.begin(), sliced_.end(),
                           [](const SliceResult& part) { return part.summary.degenerate == part.summary.triangles; });
    }

    SliceResult unite(const SliceResult& apart) {
        SliceResult united(options_.control.memory);
        united.region = options_.region;
        const auto reach = [this](double share) { progress_.reach(sliced_share() + (0.99 - sliced_share()) * share); };
        unite_parts(apart, options_.control, parallel_, reach, united);
        return united;
    }

    /// Of the limit that was asked for; where none was, each part has its own.
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
    bool united_;
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
