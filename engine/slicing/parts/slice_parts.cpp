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
    Merging(std::span<SliceResult> parts, bool united, const SliceCall& call, SliceResult& merged)
        : parts_(parts),
          united_(united),
          parallel_(*call.kept.parallel),
          scratch_(call.kept.output),
          merged_(merged),
          rules_{
              .region = &merged.info.options.region, .grid_mm = merged.info.grid_mm, .first_layer = merged.info.first_layer},
          builders_(static_cast<std::size_t>(parallel_.threads())) {}

    /// `reach` is told the share of layers that are done. Throws Refused, std::bad_alloc, Stopped.
    void run(LayerTarget& target, FunctionRef<void(double)> reach) {
        cut_tasks();
        const auto layer_at = [this](PlaneIndex plane) { return layers_[plane]; };
        const OutputPlan plan{.layers = static_cast<PlaneIndex>(layers_.size()),
                              .layer_at = layer_at,
                              .segments = points_,
                              .cutting = 0,
                              .bands = tasks_,
                              .parallel = parallel_,
                              .scratch = scratch_,
                              .origins = merged_.info.options.origins,  // of some part: one that no plane meets has none
                              .result = merged_,
                              .lead = united_ ? tasks_.size() : usual_lead(parallel_)};
        BandTarget& bands = target.begin(plan);
        parallel_.run(tasks_.size(), [&](std::size_t task, int worker) {
            fill_band(bands, task, [&](BandOutput& output) {
                for (PlaneIndex layer = tasks_[task].first; layer < tasks_[task].last; ++layer) {
                    fill_layer(layer, worker, output);
                    output.finish_layer();
                }
            });
            reach(static_cast<double>(task) / static_cast<double>(tasks_.size()));
        });
        target.finish(plan);
        for (const SliceResult& part : parts_) {
            merged_.info.cancelled_layers += part.info.cancelled_layers;
        }
    }

private:
    /// What a thread builds layers with.
    struct Builder {
        Builder(const Memory* memory, const StopCheck& stop) : worker(memory, stop), given(memory) {}
        Worker worker;
        LayerBuilder layers{worker};
        Vector<Path> given;
    };

    /// Layers without their contours, the tasks, and where none is united how many points they have.
    void cut_tasks() {
        layers_.resize_discarding(parts_[0].layers.size());
        for (std::size_t l = 0; l < layers_.size(); ++l) {
            Layer& layer = layers_[l] = parts_[0].layers[l];
            layer.first_contour = layer.contour_count = layer.segments = 0;
            if (l % layers_a_task == 0) {
                parallel_.stop_if_asked();
                tasks_.push_back({static_cast<PlaneIndex>(l), 0, 0});
            }
            tasks_.back().last = static_cast<PlaneIndex>(l + 1);
            for (SliceResult& part : parts_) {
                assert(part.layers[l].plane == layer.plane);
                layer.segments += part.layers[l].segments;
                tasks_.back().segments += united_ ? 0 : part[l].points.size();
            }
        }
        for (const Band& task : tasks_) {
            points_ += task.segments;
        }
    }

    void fill_layer(std::size_t layer, int worker, BandOutput& output) {
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            number(layer, p);
            for (const Stitch& stitch : parts_[p][layer].stitches) {
                output.stitches.push_back({layer - output.first_layer, stitch.from, stitch.to});
            }
        }
        if (united_) {
            unite(layer, worker, output);
        } else {
            append(layer, output);
        }
    }

    /// Gives a layer's contours and origins the number of their part.
    void number(std::size_t layer, std::size_t part_number) {
        SliceResult& part = parts_[part_number];
        const LayerView own = part[layer];
        for (Contour& contour : part.contours.span().subspan(own.first_contour, own.contour_count)) {
            contour.part = static_cast<std::uint32_t>(part_number);
        }
        for (PointOrigin& origin :
             part.origins.span().subspan(own.origins.empty() ? 0 : own.first_point, own.origins.size())) {
            origin.part = origin.triangle == no_triangle ? std::uint16_t{0} : static_cast<std::uint16_t>(part_number);
        }
    }

    void append(std::size_t l, BandOutput& output) {
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
                output.counts.add(contour);
            }
            output.point_count += layer.points.size();
        }
        output.layer_contours.push_back(static_cast<std::uint32_t>(output.contours.size() - contours_before));
    }

    void unite(std::size_t l, int worker, BandOutput& output) {
        auto& builder = builders_[static_cast<std::size_t>(worker)];
        if (builder == nullptr) {
            builder = std::make_unique<Builder>(parallel_.memory(), parallel_.stop());
            builder->layers.rules = &rules_;
        }
        builder->given.clear();
        for (const SliceResult& part : parts_) {
            for (const Contour& contour : part.contours_of(part.layers[l])) {
                builder->given.push_back(as_given(part, contour));
            }
        }
        builder->layers.build_given(builder->given, output);
    }

    std::span<SliceResult> parts_;
    bool united_;
    const Parallel& parallel_;
    OutputScratch& scratch_;
    SliceResult& merged_;
    LayerRules rules_;
    std::vector<std::unique_ptr<Builder>> builders_;  ///< by worker
    Array<Layer> layers_{parallel_.memory()};
    std::vector<Band> tasks_;
    std::uint64_t points_ = 0;
};

/// Adds what part number `part` has.
void add_part(const SliceInfo& own, std::size_t part, SliceInfo& sum) {
    if (part == 0) {
        sum.layers = own.layers;
        sum.layer_of = own.layer_of;
        sum.first_layer = own.first_layer;
        sum.planned_layers = own.planned_layers;
        sum.options.heights_mm = own.options.heights_mm;
        sum.options.stitch_mm = 0;
        sum.part_count = 0;
        sum.threads = own.threads;
    }
    ++sum.part_count;
    sum.options.stitch_mm = std::max(sum.options.stitch_mm, own.options.stitch_mm);
    add_work(own, sum);
}

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

    void slice(LayerTarget& target, SliceResult& merged) {
        choose_frame();
        const Bounds box = frame_.bounds;
        slice_all(box, target, merged);
        if (std::all_of(sliced_.begin(), sliced_.end(),
                        [](const SliceResult& part) { return part.info.degenerate == part.info.triangles; })) {
            frame_.bounds = {};  // the box of nothing must not choose planes
            sliced_.clear();
            slice_all(box, target, merged);
        }
        const auto reach = [this](double share) { progress_.reach(sliced_share() + (0.99 - sliced_share()) * share); };
        const auto start = Clock::now();
        for (std::size_t p = 0; p < sliced_.size(); ++p) {
            add_part(sliced_[p].info, p, merged.info);
        }
        Merging(sliced_, united_, call_, merged).run(target, reach);
        (united_ ? merged.info.ms.fill : merged.info.ms.contours) += milliseconds_since(start);
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
            with_mesh_source(parts_[p].mesh, placing_of(parts_[p]), &frame_, call_.kept.source_tools(),
                             [&](TriangleSource& source) {
                                 use(source, SliceCall{options, call_.tuning, context, call_.kept});
                             });
        } catch (Refused& refused) {
            throw Refused{blame(std::move(refused.error), p)};
        }
    }

    /// Once the target has admitted what the frame says of the whole.
    void slice_all(const Bounds& box, LayerTarget& target, SliceResult& merged) {
        begin_info(call_.options, box, frame_.unit, merged.info);
        build_planes(call_, frame_, call_.kept.planes);
        target.admit_layers(call_.kept.planes.size(), merged.info);
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

void slice_parts(std::span<const Part> parts, const SliceCall& call, LayerTarget& target, SliceResult& result) {
    PartSlicing(parts, call).slice(target, result);
}

void hand_over_whole(SliceResult& whole, const SliceCall& call, LayerTarget& target, SliceResult& result) {
    result.info = whole.info;
    target.admit_layers(whole.layers.size(), result.info);
    Merging({&whole, 1}, false, call, result).run(target, [](double) {});
    result.info.cancelled_layers = whole.info.cancelled_layers;
}

void outline_parts(std::span<const Part> parts, const SliceCall& call, SliceInfo& info) {
    PartSlicing(parts, call).outline(info);
}

}  // namespace lamella
