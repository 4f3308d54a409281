// Slicing several meshes, as the list of its stages:
//
//     choose_frame       the box of all parts, and from it one grid and one set of planes
//     slice_all          each part by itself, by all threads
//     merge_parts        contours of all parts, side by side in each layer, or one region of them
#include "slicing/parts/slice_parts.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/parts/merge_parts.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

class PartSlicing {
public:
    PartSlicing(std::span<const Part> parts, const SliceCall& call)
        : parts_(parts),
          call_(call),
          united_(call.options.unite_parts),
          parallel_(*call.kept.parallel),
          progress_(call.context.progress) {
        if (parts.empty()) {
            throw Refused{{ErrorCode::invalid_argument, "there are no parts to slice"}};
        }
        constexpr std::size_t most = std::numeric_limits<std::uint16_t>::max();
        if (call.options.origins && parts.size() > most) {
            throw Refused{{ErrorCode::invalid_argument, "origins name one of at most " + std::to_string(most) +
                                                            " parts, not of " + std::to_string(parts.size())}};
        }
        if (united_) {
            require(check_uniting(call.options.region));
        }
    }

    void slice(SliceResult& merged) {
        choose_frame();
        const Bounds box = frame_.bounds;
        slice_all();
        if (std::all_of(sliced_.begin(), sliced_.end(),
                        [](const SliceResult& part) { return part.info.degenerate == part.info.triangles; })) {
            frame_.bounds = {};  // the box of nothing must not choose planes
            sliced_.clear();
            slice_all();
        }
        begin_info(call_.options, box, frame_.unit, merged.info);
        const auto reach = [this](double share) { progress_.reach(sliced_share() + (0.99 - sliced_share()) * share); };
        merge_parts(sliced_, united_, parallel_, reach, merged);
        progress_.finish();
    }

    void outline(SliceInfo& info) {
        choose_frame();
        const Bounds box = frame_.bounds;
        count_all(box, info);
        if (info.degenerate == info.triangles) {
            frame_.bounds = {};
            count_all(box, info);
        }
    }

private:
    void count_all(const Bounds& box, SliceInfo& info) {
        begin_info(call_.options, box, frame_.unit, info);
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            SliceInfo own;
            with_part(p, {}, call_.context.memory_limit_bytes,
                      [&](TriangleSource& source, const SliceCall& call) { count_layers(source, call, own); });
            add_part(own, p, info);
        }
    }

    /// The progress when all parts are sliced.
    double sliced_share() const noexcept { return united_ ? 0.5 : 0.95; }

    /// A part's own progress, as a share of the whole.
    struct Share {
        ProgressMeter& whole;
        double from;
        double length;
        void operator()(double fraction) noexcept { whole.reach(from + length * fraction); }
    };

    Placing placing_of(const Part& part) const noexcept {
        return lamella::placing_of(part.mesh, call_.options.frame, part.placement);
    }

    /// An option speaks for itself; of a mesh the message must say which.
    static Error blame(Error error, std::size_t part) {
        if (error.triangle >= 0 || error.code == ErrorCode::empty_mesh || error.code == ErrorCode::bad_coordinate) {
            error.message = "part " + std::to_string(part) + ": " + error.message;
            error.part = static_cast<std::int64_t>(part);
        }
        return error;
    }

    void choose_frame() {
        BlockTable table(parallel_.memory());
        Bounds bounds = Bounds::empty();
        Number number = Number::f32;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const MeshView& mesh = parts_[p].mesh;
            const Placing placing = placing_of(parts_[p]);
            if (call_.options.allow_empty && mesh.triangle_count == 0) {
                continue;
            }
            const Result<Bounds> own = measure_bounds(mesh, placing, call_.options.frame.grid_mm, parallel_, table);
            if (!own) {
                throw Refused{blame(own.error(), p)};
            }
            bounds.add(*own);
            if (placed_number(mesh, placing) == Number::f64) {
                number = Number::f64;
            }
            triangles_ += mesh.triangle_count;
        }
        frame_ =
            lamella::choose_frame(triangles_ == 0 ? Bounds{} : bounds, number, call_.options.frame, call_.options.region);
    }

    /// Calls use(source, call) for a part in the frame of all.
    template <class Use>
    void with_part(std::size_t p, const Callback<void(double)>& progress, std::uint64_t memory_limit, Use use) {
        SliceOptions options = call_.options;
        if (united_) {
            options.region = {};
        }
        Context context = call_.context;
        context.progress = progress;
        context.memory_limit_bytes = memory_limit;
        try {
            AnyMeshSource source(parts_[p].mesh, placing_of(parts_[p]), &frame_, call_.kept.source_tools());
            use(source, SliceCall{options, call_.tuning, context, call_.kept});
        } catch (Refused& refused) {
            throw Refused{blame(std::move(refused.error), p)};
        }
    }

    void slice_all() {
        std::uint64_t before = 0;  // triangles of the parts before
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const auto share = [&](std::size_t triangles) {
                return sliced_share() * static_cast<double>(triangles) /
                       static_cast<double>(std::max<std::uint64_t>(1, triangles_));
            };
            Share progress{progress_, share(before), share(parts_[p].mesh.triangle_count)};
            SliceResult& result = sliced_.emplace_back(call_.context.memory);
            with_part(p, progress, memory_left(), [&](TriangleSource& source, const SliceCall& call) {
                ResultTarget target;
                slice_layers(source, target, call, result);
            });
            before += parts_[p].mesh.triangle_count;
        }
    }

    /// The rest of the limit that was asked for; where none was, each part has its own.
    std::uint64_t memory_left() const noexcept {
        std::uint64_t left = call_.context.memory_limit_bytes;
        for (const SliceResult& result : sliced_) {
            const std::uint64_t bytes = result.points.size() * sizeof(Point) + result.contours.size() * sizeof(Contour) +
                                        result.origins.size() * sizeof(PointOrigin);
            left = left > bytes ? left - bytes : std::min<std::uint64_t>(left, 1);
        }
        return left;
    }

    std::span<const Part> parts_;
    const SliceCall& call_;
    bool united_;
    const Parallel& parallel_;
    ProgressMeter progress_;
    SharedFrame frame_{};
    std::uint64_t triangles_ = 0;
    std::vector<SliceResult> sliced_;
};

}  // namespace

void slice_parts(std::span<const Part> parts, const SliceCall& call, SliceResult& result) {
    PartSlicing(parts, call).slice(result);
}

void outline_parts(std::span<const Part> parts, const SliceCall& call, SliceInfo& info) {
    PartSlicing(parts, call).outline(info);
}

}  // namespace lamella
