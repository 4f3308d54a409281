#include "slicing/parts/merge_parts.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/clock.hpp"
#include "base/vector.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/result/placement.hpp"

namespace lamella {

namespace {

constexpr std::size_t layers_a_task = 16;

/// A layer's points, or their origins: those of its contours follow one another.
template <class T>
std::span<T> of_layer(Array<T>& elements, const SliceResult& part, std::size_t layer) {
    const std::span<const Contour> contours = part.contours_of(part.layers[layer]);
    if (contours.empty() || elements.empty()) {
        return {};
    }
    const std::uint64_t first = contours.front().first_point;
    return elements.span().subspan(first, contours.back().first_point + contours.back().point_count - first);
}

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

/// Layers are bands of a placement, a few a task. Contours side by side have as many points as they had, so that they are
/// copied straight to their place.
class Merging {
public:
    Merging(std::span<SliceResult> parts, bool united, const Parallel& parallel, SliceResult& merged)
        : parts_(parts),
          united_(united),
          parallel_(parallel),
          merged_(merged),
          builders_(static_cast<std::size_t>(parallel.threads())),
          placement_(parallel.memory()) {}

    void run(FunctionRef<void(double)> reach) {
        cut_tasks();
        const bool origins = merged_.info.options.origins;  // of some part: one that no plane meets has none
        const std::size_t lead = united_ ? tasks_.size() : 2 * static_cast<std::size_t>(parallel_.threads());
        placement_.begin(tasks_, lead, origins, merged_, parallel_.stop());
        parallel_.run(tasks_.size(), [&](std::size_t task, int worker) {
            fill_band(placement_, task, [&](BandOutput& output) {
                for (std::size_t layer = tasks_[task].first; layer < tasks_[task].last; ++layer) {
                    fill_layer(layer, worker, output);
                }
            });
            reach(static_cast<double>(task) / static_cast<double>(tasks_.size()));
        });
        placement_.finish(parallel_, merged_);
        ContourCounts counts = placement_.contour_counts();
        for (const SliceResult& part : parts_) {
            counts.cancelled_layers += part.info.cancelled_layers;
        }
        set_counts(counts, merged_);
    }

private:
    /// What a thread builds layers with.
    struct Builder {
        Builder(const Memory* memory, const StopCheck& stop) : worker(memory, stop), given(memory) {}
        Worker worker;
        LayerBuilder layers{worker};
        Vector<Path> given;
    };

    /// Layers without their contours, the tasks, and where none is united room for all points.
    void cut_tasks() {
        const std::size_t layers = parts_[0].layers.size();
        merged_.layers.resize_discarding(layers);
        std::uint64_t points = 0;
        for (std::size_t l = 0; l < layers; ++l) {
            Layer& layer = merged_.layers[l] = parts_[0].layers[l];
            layer.segments = 0;
            if (l % layers_a_task == 0) {
                parallel_.stop_if_asked();
                tasks_.push_back({static_cast<PlaneIndex>(l), 0, 0});
            }
            tasks_.back().last = static_cast<PlaneIndex>(l + 1);
            for (SliceResult& part : parts_) {
                assert(part.layers[l].plane == layer.plane);
                layer.segments += part.layers[l].segments;
                tasks_.back().segments += united_ ? 0 : of_layer(part.points, part, l).size();
            }
        }
        for (const Band& task : tasks_) {
            points += task.segments;
        }
        merged_.points.resize_discarding(points);
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
        const Layer& own = part.layers[layer];
        for (Contour& contour : part.contours.span().subspan(own.first_contour, own.contour_count)) {
            contour.part = static_cast<std::uint32_t>(part_number);
        }
        for (PointOrigin& origin : of_layer(part.origins, part, layer)) {
            origin.part = origin.triangle == no_triangle ? std::uint16_t{0} : static_cast<std::uint16_t>(part_number);
        }
    }

    void append(std::size_t l, BandOutput& output) {
        const std::size_t contours_before = output.contours.size();
        for (SliceResult& part : parts_) {
            const Layer& layer = part.layers[l];
            const std::span<const Point> points = of_layer(part.points, part, l);
            const std::span<const PointOrigin> origins = of_layer(part.origins, part, l);
            std::copy(points.begin(), points.end(), output.reserve_points(points.size()));
            if (output.with_origins) {
                std::copy(origins.begin(), origins.end(), output.origins + output.point_count);
            }
            const auto first = static_cast<std::int64_t>(output.contours.size());
            for (const Contour& own : part.contours_of(layer)) {
                Contour& contour = output.contours.emplace_back(own);
                contour.first_point += output.point_count - part.contours[layer.first_contour].first_point;
                contour.parent += own.parent < 0 ? 0 : first - static_cast<std::int64_t>(layer.first_contour);
                output.counts.add(contour);
            }
            output.point_count += points.size();
        }
        output.layer_contours.push_back(static_cast<std::uint32_t>(output.contours.size() - contours_before));
    }

    void unite(std::size_t l, int worker, BandOutput& output) {
        auto& builder = builders_[static_cast<std::size_t>(worker)];
        if (builder == nullptr) {
            builder = std::make_unique<Builder>(parallel_.memory(), parallel_.stop());
            const SliceInfo& info = merged_.info;
            builder->layers.rules = {
                .region = &info.options.region, .grid_mm = info.grid_mm, .first_layer = info.first_layer};
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
    SliceResult& merged_;
    std::vector<std::unique_ptr<Builder>> builders_;  ///< by worker
    std::vector<Band> tasks_;
    Placement placement_;
};

}  // namespace

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

void merge_parts(std::span<SliceResult> parts, bool united, const Parallel& parallel, FunctionRef<void(double)> reach,
                 SliceResult& merged) {
    assert(!parts.empty());
    const auto start = Clock::now();
    for (std::size_t p = 0; p < parts.size(); ++p) {
        add_part(parts[p].info, p, merged.info);
    }
    Merging(parts, united, parallel, merged).run(reach);
    double& ms = united ? merged.info.ms.fill : merged.info.ms.contours;
    ms += milliseconds_since(start);
}

}  // namespace lamella
