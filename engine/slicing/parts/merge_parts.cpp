#include "slicing/parts/merge_parts.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/parts/copies.hpp"
#include "slicing/regions/rules.hpp"

namespace lamella {

namespace {

constexpr std::size_t layers_a_task = 16;

std::uint64_t points_in(const SliceResult& part, std::size_t l) noexcept {
    const std::span<const Contour> contours = part.contours_of(part.layers[l]);
    return contours.empty() ? 0 : contours.back().first_point + contours.back().point_count - contours.front().first_point;
}

void move_points(const PartLayers& part, std::span<const Point> points, Point* to) noexcept {
    if (part.move == Point{}) {
        std::copy(points.begin(), points.end(), to);
        return;
    }
    std::transform(points.begin(), points.end(), to, [&part](Point point) { return part.moved(point); });
}

void number_origins(const PartLayers& part, std::span<const PointOrigin> origins, PointOrigin* to) noexcept {
    std::transform(origins.begin(), origins.end(), to, [&part](PointOrigin origin) {
        origin.part = origin.triangle == no_triangle ? std::uint16_t{0} : static_cast<std::uint16_t>(part.number);
        return origin;
    });
}

/// As its facets run: a role that overruled them has turned it.
Path as_given(const Contour& contour, std::span<const Point> points, const PointOrigin* origins,
              std::uint32_t part) noexcept {
    Path given = given_path(points, origins, contour.role != Role::open);
    given.segments = contour.segments;
    given.item.reverse =
        (contour.flags & orientation_overruled) != 0 && (contour.orientation > 0) != (contour.role == Role::outer);
    given.item.flags = static_cast<std::uint16_t>(contour.flags & ~orientation_overruled);
    given.item.part = part;
    return given;
}

/// A few layers are a band. Contours side by side have as many points as they had, so that those of a result are copied
/// straight to their place.
class Merging {
public:
    Merging(const PartsToMerge& given, const SliceCall& call, SliceInfo& merged)
        : given_(given),
          parts_(given.parts),
          united_(merged.options.unite_parts),
          are_copied_(!united_ && std::none_of(parts_.begin(), parts_.end(),
                                               [](const PartLayers& part) { return part.labelled != nullptr; })),
          call_(call),
          parallel_(*call.kept.parallel),
          merged_(merged),
          rules_{.region = &merged.options.region, .grid_mm = merged.grid_mm, .first_layer = merged.first_layer},
          builders_(static_cast<std::size_t>(parallel_.threads())) {}

    void run(LayerTarget& target, FunctionRef<void(double)> reach) {
        const std::vector<Band> tasks = cut_tasks();
        std::uint64_t points = 0;
        for (const Band& task : tasks) {
            points += task.segments;
        }
        const auto layer_at = [this](PlaneIndex plane) { return layer_of_all(plane); };
        OutputPlan plan{.layers = static_cast<PlaneIndex>(given_.layers.size()),
                        .layer_at = layer_at,
                        .segments = 0,
                        .cutting = 0,
                        .bands = tasks,
                        .parallel = parallel_,
                        .scratch = call_.kept.output,
                        .origins = merged_.options.origins,  // of some part: one that no plane meets has none
                        .info = merged_};
        if (given_.are_repeated) {
            for (const PartLayers& part : parts_) {
                plan.segments += part.alone->points.size();
                plan.cutting += part.alone->contours.size();
            }
            target.admit(plan, call_.memory_limit());
        }
        plan.segments = points;
        target.begin(plan);
        fill_bands(target, parallel_, 0, tasks.size(), [&](std::size_t task, int worker, BandOutput& output) {
            for (PlaneIndex layer = tasks[task].first; layer < tasks[task].last; ++layer) {
                append_stitches(layer, output);
                united_ ? unite(layer, worker, output) : append(layer, worker, output);
                output.finish_layer();
            }
            reach(static_cast<double>(task) / static_cast<double>(tasks.size()));
        });
        target.finish();
        for (const PartLayers& part : parts_) {
            merged_.cancelled_layers += part.alone->info.cancelled_layers;
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
        Vector<Point> points{worker.memory()};         ///< of given
        Vector<PointOrigin> origins{worker.memory()};  ///< of points
        Vector<std::int64_t> places{worker.memory()};  ///< in the output, of labelled contours
    };

    Builder& builder_of(int worker) {
        auto& builder = builders_[static_cast<std::size_t>(worker)];
        if (builder == nullptr) {
            builder = std::make_unique<Builder>(call_.kept);
            builder->layers.rules = &rules_;
        }
        return *builder;
    }

    /// Without contours.
    Layer layer_of_all(PlaneIndex plane) const noexcept {
        Layer layer = given_.layers[plane];
        for (const PartLayers& part : parts_) {
            layer.segments += part.alone->layers[plane].segments;
        }
        return layer;
    }

    /// Where all are copied, with how many points they have.
    std::vector<Band> cut_tasks() const {
        const std::size_t layers = given_.layers.size();
        std::vector<Band> tasks;
        tasks.reserve(layers / layers_a_task + 1);
        for (std::size_t l = 0; l < layers; ++l) {
            if (l % layers_a_task == 0) {
                parallel_.stop_if_asked();
                tasks.push_back({static_cast<PlaneIndex>(l), 0, 0});
            }
            tasks.back().last = static_cast<PlaneIndex>(l + 1);
            for (const PartLayers& part : parts_) {
                tasks.back().segments += are_copied_ ? points_in(*part.alone, l) : 0;
            }
        }
        return tasks;
    }

    void append_stitches(PlaneIndex l, BandOutput& output) const {
        for (const PartLayers& part : parts_) {
            if (part.alone->stitches.empty()) {
                continue;
            }
            for (const Stitch& stitch : (*part.alone)[l].stitches) {
                output.stitches.push_back({l - output.first_layer, part.moved(stitch.from), part.moved(stitch.to)});
            }
        }
    }

    void append(std::size_t l, int worker, BandOutput& output) {
        const std::size_t contours_before = output.contours.size();
        for (const PartLayers& part : parts_) {
            part.labelled == nullptr ? copy(part, l, output) : append_labelled(part, l, builder_of(worker).places, output);
        }
        output.layer_contours.push_back(static_cast<std::uint32_t>(output.contours.size() - contours_before));
    }

    static void copy(const PartLayers& part, std::size_t l, BandOutput& output) {
        if (part.alone->layers[l].contour_count == 0) {
            return;
        }
        const LayerView layer = (*part.alone)[l];
        move_points(part, layer.points, output.reserve_points(layer.points.size()));
        if (output.with_origins) {
            number_origins(part, layer.origins, output.origins + output.point_count);
        }
        const auto first = static_cast<std::int64_t>(output.contours.size());
        for (const Contour& own : layer.contours) {
            Contour& contour = output.contours.emplace_back(own);
            contour.first_point += output.point_count - layer.first_point;
            contour.parent += own.parent < 0 ? 0 : first - static_cast<std::int64_t>(layer.first_contour);
            contour.part = part.number;
            output.totals.add(contour);
        }
        output.point_count += layer.points.size();
    }

    /// Open contours stand among those of the label, so that parents are known when all are there.
    static void append_labelled(const PartLayers& part, std::size_t l, Vector<std::int64_t>& places, BandOutput& output) {
        places.clear();
        const std::size_t first = output.contours.size();
        part.each_contour(l, [&](const SliceResult& of, const Contour& own) {
            if (&of == part.labelled) {
                places.push_back(static_cast<std::int64_t>(output.contours.size()));
            }
            const std::span<const Point> points = of.points_of(own);
            move_points(part, points, output.reserve_points(points.size()));
            Contour& contour = output.contours.emplace_back(own);
            contour.first_point = output.point_count;
            contour.part = part.number;
            output.totals.add(own);
            output.point_count += points.size();
        });
        const std::span<const Contour> labelled = part.labelled_in(l);
        const auto first_labelled = static_cast<std::int64_t>(labelled.data() - part.labelled->contours.data());
        for (Contour& contour : std::span(output.contours).subspan(first)) {
            if (contour.parent >= 0 && contour.role != Role::open) {
                contour.parent = places[static_cast<std::size_t>(contour.parent - first_labelled)];
            } else {
                contour.parent = -1;
            }
        }
    }

    void unite(std::size_t l, int worker, BandOutput& output) {
        Builder& builder = builder_of(worker);
        const auto each_contour = [this, l](auto use) {
            for (const PartLayers& part : parts_) {
                if (!part.is_support) {
                    part.each_contour(l, [&](const SliceResult& of, const Contour& own) { use(part, of, own); });
                }
            }
        };
        std::size_t count = 0;
        each_contour([&](const PartLayers&, const SliceResult&, const Contour& own) { count += own.point_count; });
        builder.points.resize(count);
        builder.origins.resize(merged_.options.origins ? count : 0);
        builder.given.clear();
        std::size_t at = 0;
        each_contour([&](const PartLayers& part, const SliceResult& of, const Contour& own) {
            move_points(part, of.points_of(own), &builder.points[at]);
            PointOrigin* const origins = builder.origins.empty() ? nullptr : &builder.origins[at];
            if (origins != nullptr) {
                number_origins(part, of.origins_of(own), origins);
            }
            builder.given.push_back(as_given(own, {&builder.points[at], own.point_count}, origins, part.number));
            at += own.point_count;
        });
        builder.layers.read_given(builder.given);
        builder.layers.build(output);
    }

    const PartsToMerge& given_;
    std::span<const PartLayers> parts_;
    bool united_;
    bool are_copied_;  ///< contours stay as they are
    const SliceCall& call_;
    const Parallel& parallel_;
    SliceInfo& merged_;
    LayerRules rules_;
    std::vector<std::unique_ptr<Builder>> builders_;  ///< by worker
};

}  // namespace

void check_places(std::span<const Part> parts, const SliceOptions& options) {
    std::uint64_t copies = 0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        copies += moves_mm(parts, p, options.frame.transform).size();
    }
    constexpr std::size_t most_with_origins = std::numeric_limits<std::uint16_t>::max();
    if (options.origins && copies > most_with_origins) {
        throw Refused{{ErrorCode::invalid_argument, "origins name one of at most " + std::to_string(most_with_origins) +
                                                        " parts, not of " + std::to_string(copies)}};
    }
    if (copies >= several_parts) {
        throw Refused{{ErrorCode::invalid_argument, std::to_string(copies) + " copies of parts are more than 2^32 - 2"}};
    }
    if (options.share_copies && (options.unite_parts || options.origins)) {
        throw Refused{{ErrorCode::invalid_argument, options.origins ? "copies that share points have no origins"
                                                                    : "parts that are united share no points"}};
    }
}

void merge_parts(const PartsToMerge& given, const SliceCall& call, LayerTarget& target, SliceInfo& merged,
                 FunctionRef<void(double)> reach) {
    Merging(given, call, merged).run(target, reach);
}

}  // namespace lamella
