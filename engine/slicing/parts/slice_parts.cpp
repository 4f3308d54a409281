// Slicing several meshes, as the list of its stages:
//
//     choose_frame       the box of all parts, and from it one grid and one set of planes
//     slice_all          each part by itself, by all threads
//     Merging            contours of all parts, side by side in each layer, or one region of them

#include <algorithm>
#include <cassert>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/function_ref.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

constexpr std::size_t layers_a_task = 16;

/// As its facets run: a role that overruled them has turned it.
Path as_given(const SliceResult& part, const Contour& contour) noexcept {
    const PointOrigin* const origins = part.origins.empty() ? nullptr : part.origins_of(contour).data();
    Path given = given_path(part.points_of(contour), origins, contour.role != Role::open);
    given.segments = contour.segments;
    given.item.reverse =
        (contour.flags & orientation_overruled) != 0 && (contour.orientation > 0) != (contour.role == Role::outer);
    given.item.flags = static_cast<std::uint16_t>(contour.flags & ~orientation_overruled);
    given.item.part = contour.part;
    return given;
}

/// Hands over the layers of all parts.
///
///     part 0    layer 0 [ a b ]   layer 1 [ c ]
///     part 1    layer 0 [ d ]     layer 1 [ e ]
///     merged    layer 0 [ a b d ] layer 1 [ c e ]       contours, and their points in the same order
///     united    layer 0 [ region of a, b and d ] ...    by the options' rules; no layer's may be `contours` then
///
/// O(n + p k) for n points and contours, p parts and k planes, which all parts have, and for regions O(q log q) for a layer
/// of q points. A few layers are a band. Contours side by side have as many points as they had, so that those of a result
/// are copied straight to their place.
class Merging {
public:
    /// `merged` has the summary but for what the target counts.
    Merging(std::span<const SliceResult> parts, bool united, const SliceCall& call, SliceInfo& merged)
        : parts_(parts),
          united_(united),
          call_(call),
          parallel_(*call.kept.parallel),
          merged_(merged),
          rules_{.region = &merged.options.region, .grid_mm = merged.grid_mm, .first_layer = merged.first_layer},
          builders_(static_cast<std::size_t>(parallel_.threads())) {}

    /// `reach` is told the share of layers that are done. Throws Refused, std::bad_alloc, Stopped.
    void run(LayerTarget& target, FunctionRef<void(double)> reach) {
        const std::vector<Band> tasks = cut_tasks();
        std::uint64_t points = 0;
        for (const Band& task : tasks) {
            points += task.segments;
        }
        const auto layer_at = [this](PlaneIndex plane) { return layer_of_all(plane); };
        const OutputPlan plan{.layers = static_cast<PlaneIndex>(parts_[0].layers.size()),
                              .layer_at = layer_at,
                              .segments = points,
                              .cutting = 0,
                              .bands = tasks,
                              .parallel = parallel_,
                              .scratch = call_.kept.output,
                              .origins = merged_.options.origins,  // of some part: one that no plane meets has none
                              .info = merged_};
        target.begin(plan);
        fill_bands(target, parallel_, 0, tasks.size(), [&](std::size_t task, int worker, BandOutput& output) {
            for (PlaneIndex layer = tasks[task].first; layer < tasks[task].last; ++layer) {
                for (const SliceResult& part : parts_) {
                    for (const Stitch& stitch : part[layer].stitches) {
                        output.stitches.push_back({layer - output.first_layer, stitch.from, stitch.to});
                    }
                }
                united_ ? unite(layer, worker, output) : append(layer, output);
                output.finish_layer();
            }
            reach(static_cast<double>(task) / static_cast<double>(tasks.size()));
        });
        target.finish();
        for (const SliceResult& part : parts_) {
            merged_.cancelled_layers += part.info.cancelled_layers;
        }
    }

private:
    /// What a thread builds layers with.
    struct Builder {
        explicit Builder(const detail::SlicerImpl& kept)
            : worker(kept.parallel->memory(), kept.parallel->stop(), kept.instructions) {}
        Worker worker;
        LayerBuilder layers{worker};
        Vector<Path> given{worker.memory()};
    };

    /// Without contours.
    Layer layer_of_all(PlaneIndex plane) const noexcept {
        Layer layer = parts_[0].layers[plane];
        layer.first_contour = layer.contour_count = layer.segments = 0;
        for (const SliceResult& part : parts_) {
            assert(part.layers[plane].plane == layer.plane);
            layer.segments += part.layers[plane].segments;
        }
        return layer;
    }

    /// Where none is united, with how many points they have.
    std::vector<Band> cut_tasks() const {
        std::vector<Band> tasks;
        tasks.reserve(parts_[0].layers.size() / layers_a_task + 1);
        for (std::size_t l = 0; l < parts_[0].layers.size(); ++l) {
            if (l % layers_a_task == 0) {
                parallel_.stop_if_asked();
                tasks.push_back({static_cast<PlaneIndex>(l), 0, 0});
            }
            tasks.back().last = static_cast<PlaneIndex>(l + 1);
            for (const SliceResult& part : parts_) {
                tasks.back().segments += united_ ? 0 : part[l].points.size();
            }
        }
        return tasks;
    }

    void append(std::size_t l, BandOutput& output) const {
        const std::size_t contours_before = output.contours.size();
        for (const SliceResult& part : parts_) {
            const LayerView layer = part[l];
            std::copy(layer.points.begin(), layer.points.end(), output.reserve_points(layer.points.size()));
            if (output.with_origins) {
                std::copy(layer.origins.begin(), layer.origins.end(), output.origins + output.point_count);
            }
            const auto first = static_cast<std::int64_t>(output.contours.size());
            for (const Contour& own : layer.contours) {
                Contour& contour = output.contours.emplace_back(own);
                contour.first_point += output.point_count - layer.first_point;
                contour.parent += own.parent < 0 ? 0 : first - static_cast<std::int64_t>(layer.first_contour);
                output.totals.add(contour);
            }
            output.point_count += layer.points.size();
        }
        output.layer_contours.push_back(static_cast<std::uint32_t>(output.contours.size() - contours_before));
    }

    void unite(std::size_t l, int worker, BandOutput& output) {
        auto& builder = builders_[static_cast<std::size_t>(worker)];
        if (builder == nullptr) {
            builder = std::make_unique<Builder>(call_.kept);
            builder->layers.rules = &rules_;
        }
        builder->given.clear();
        for (const SliceResult& part : parts_) {
            for (const Contour& contour : part.contours_of(part.layers[l])) {
                builder->given.push_back(as_given(part, contour));
            }
        }
        builder->layers.read_given(builder->given);
        builder->layers.build(output);
    }

    std::span<const SliceResult> parts_;
    bool united_;
    const SliceCall& call_;
    const Parallel& parallel_;
    SliceInfo& merged_;
    LayerRules rules_;
    std::vector<std::unique_ptr<Builder>> builders_;  ///< by worker
};

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
            require(check_every_layer(call.options.region, "uniting parts"));
        }
    }

    void slice(LayerTarget* target, SliceInfo& info) {
        choose_frame();
        const Bounds box = frame_.bounds;
        slice_all(box, target, info);
        if (info.degenerate == info.triangles) {
            frame_.bounds = {};  // the box of nothing must not choose planes
            sliced_.clear();
            slice_all(box, target, info);
        }
        if (target == nullptr) {
            return;
        }
        const auto start = Clock::now();
        const auto reach = [this](double share) { progress_.reach(sliced_share() + (0.99 - sliced_share()) * share); };
        Merging(sliced_, united_, call_, info).run(*target, reach);
        (united_ ? info.ms.fill : info.ms.contours) += milliseconds_since(start);
        progress_.finish();
    }

private:
    /// The progress when all parts are sliced.
    double sliced_share() const noexcept { return united_ ? 0.5 : 0.95; }

    Placing placing_of(const Part& part) const noexcept {
        return lamella::placing_of(part.mesh, call_.options.frame, part.placement);
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
                throw Refused{blamed_on_part(own.error(), p)};
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

    /// Once the target has admitted what the frame says of the whole. Without a target, parts are counted only.
    void slice_all(const Bounds& box, LayerTarget* target, SliceInfo& info) {
        begin_info(call_.options, box, frame_.unit, info);
        build_planes(call_, frame_, call_.kept.planes);
        describe_plan(call_.kept.planes, call_.tuning.random_heights.has_value(), info);
        info.options.stitch_mm = 0;
        info.part_count = parts_.size();
        info.threads = parallel_.threads();
        if (target != nullptr) {
            target->admit_layers(info.layers, info);
        }
        std::uint64_t before = 0;  // triangles of the parts before
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            slice_part(p, before, target != nullptr);
            const SliceInfo& own = sliced_.back().info;
            info.options.stitch_mm = std::max(info.options.stitch_mm, own.options.stitch_mm);
            add_work(own, info);
            before += parts_[p].mesh.triangle_count;
        }
    }

    /// In the frame of all. Its contours and origins get the part's number.
    void slice_part(std::size_t p, std::uint64_t before, bool whole) {
        const MeshView& mesh = parts_[p].mesh;
        const auto share = [this](std::uint64_t triangles) {
            return sliced_share() * static_cast<double>(triangles) /
                   static_cast<double>(std::max<std::uint64_t>(1, triangles_));
        };
        auto report = [&](double fraction) noexcept {
            progress_.reach(share(before) + share(mesh.triangle_count) * fraction);
        };
        SliceOptions options = call_.options;
        if (united_) {
            options.region = {};
        }
        Context context = call_.context;
        context.progress = report;
        context.memory_limit_bytes = memory_left();
        SliceResult& own = sliced_.emplace_back(call_.context.memory);
        ResultTarget target(own);
        try {
            AnySource source;
            slice_layers(source_of(mesh, placing_of(parts_[p]), &frame_, call_.kept.source_tools(), source),
                         whole ? &target : nullptr, {options, call_.tuning, context, call_.kept}, own.info);
        } catch (Refused& refused) {
            throw Refused{blamed_on_part(std::move(refused.error), p)};
        }
        for (Contour& contour : own.contours) {
            contour.part = static_cast<std::uint32_t>(p);
        }
        parallel_.run_ranges(own.origins.size(), std::size_t{1} << 16, [&](std::size_t begin, std::size_t end, int) {
            for (PointOrigin& origin : own.origins.span().subspan(begin, end - begin)) {
                origin.part = origin.triangle == no_triangle ? std::uint16_t{0} : static_cast<std::uint16_t>(p);
            }
        });
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

void slice_parts(std::span<const Part> parts, const SliceCall& call, LayerTarget* target, SliceInfo& info) {
    PartSlicing(parts, call).slice(target, info);
}

}  // namespace lamella
