// Times region_of() on layers whose contours lie beside or across each other by the thousand, each of a known area; slicing
// with regions beside the plain slice; layers with their neighbours; and the regions of a slice's layers beside those of the
// clipping library. Slices are warm. Regions of single layers run on one thread.
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <polyclipping/clipper.hpp>

#include "engine/counting_memory.hpp"
#include "lamella/layers.hpp"
#include "lamella/overlay.hpp"
#include "measure.hpp"

namespace lamella::bench {

namespace {

struct Layer2d {
    std::vector<std::vector<Point>> contours;
    double non_zero = 0;  ///< areas, square grid units
    double even_odd = 0;

    std::vector<std::span<const Point>> spans() const { return {contours.begin(), contours.end()}; }
    void add_box(Point low, Point high) { contours.push_back({low, {high.x, low.y}, high, {low.x, high.y}}); }
};

constexpr std::int32_t step = 10'000;  // grid units, 0.01 mm

/// `side` x `side` squares, `gap` units apart.
Layer2d boxes(std::int32_t side, std::int32_t gap) {
    Layer2d layer;
    for (std::int32_t i = 0; i < side * side; ++i) {
        const Point low{i % side * step, i / side * step};
        layer.add_box(low, {low.x + step - gap, low.y + step - gap});
    }
    layer.non_zero = layer.even_odd = static_cast<double>(side) * side * (step - gap) * (step - gap);
    return layer;
}

/// `count` bars along x and as many along y, half as wide as the gaps between them.
Layer2d bars(std::int32_t count) {
    constexpr std::int32_t width = step / 3;
    Layer2d layer;
    const std::int32_t length = count * step;
    for (std::int32_t i = 0; i < count; ++i) {
        layer.add_box({-step, i * step}, {length, i * step + width});
        layer.add_box({i * step, -step}, {i * step + width, length});
    }
    const double each = static_cast<double>(length + step) * width * count;
    const double twice_covered = static_cast<double>(count) * count * width * width;
    layer.non_zero = 2 * each - twice_covered;
    layer.even_odd = 2 * each - 2 * twice_covered;
    return layer;
}

/// Teeth on one base, each of which touches it along a line and its neighbours in points.
Layer2d comb(std::int32_t teeth) {
    constexpr std::int32_t height = 10'000'000;
    Layer2d layer;
    layer.add_box({0, -step}, {teeth * step, 0});
    for (std::int32_t i = 0; i < teeth; ++i) {
        layer.contours.push_back({{i * step, 0}, {(i + 1) * step, 0}, {i * step + step / 2, height}});
    }
    layer.non_zero = layer.even_odd = static_cast<double>(teeth) * step * (step + height / 2.0);
    return layer;
}

Figures time_region(benchmark::State& state, const Layer2d& layer, FillRule rule) {
    const RegionRules rules{.fill_rule = rule};
    constexpr double unit_mm = 1;  // so that areas are in square grid units
    const std::vector<std::span<const Point>> contours = layer.spans();
    CountingMemory memory;
    if (checked(region_of(contours, rules, unit_mm, {.memory = &memory}))[0].area_mm2() !=
        (rule == FillRule::non_zero ? layer.non_zero : layer.even_odd)) {
        fail("the region has not the known area");
    }
    Figures figures = measure(state, [&] { checked(region_of(contours, rules, unit_mm)); });
    figures["peak_bytes"] = static_cast<double>(memory.peak());
    return figures;
}

constexpr SliceOptions layers{.layer_height_mm = 0.2};
constexpr int region_threads = 2;
constexpr double closing_mm = 0.049;
constexpr double offset_mm = 0.2;
constexpr double units_apart = 6;  // of two areas, along the contours

RegionRules non_zero(double closing = 0, double offset = 0) {
    return {.fill_rule = FillRule::non_zero, .closing_mm = closing, .offset_mm = offset};
}

/// Slices with the region into memory of its own, which stays warm.
std::function<void()> slicing(const MeshView& mesh, const RegionRules& region) {
    SliceOptions options = layers;
    options.region = region;
    const auto slicer = std::make_shared<Slicer>();
    const auto result = std::make_shared<SliceResult>();
    return [=] { checked(slicer->slice_to(*result, mesh, options, {.threads = region_threads})); };
}

Figures time_slices(const MeshView& mesh, int rounds) {
    return medians_of({{"plain", slicing(mesh, {})},
                       {"non_zero", slicing(mesh, non_zero())},
                       {"closing", slicing(mesh, non_zero(closing_mm))},
                       {"offset", slicing(mesh, non_zero(0, offset_mm))}},
                      rounds);
}

ClipperLib::Paths grown(const ClipperLib::Paths& paths, double by) {
    ClipperLib::ClipperOffset offset(RegionRules{}.miter_limit);
    offset.AddPaths(paths, ClipperLib::jtMiter, ClipperLib::etClosedPolygon);
    ClipperLib::Paths region;
    offset.Execute(region, by);
    return region;
}

/// By ClipperLib 6.4, which the slicers of the Slic3r family use. As they close: united by non-zero, grown by so many grid
/// units with miter joins, then shrunk by as many.
ClipperLib::Paths closed(const ClipperLib::Paths& contours, double radius) {
    ClipperLib::Clipper clipper;
    clipper.AddPaths(contours, ClipperLib::ptSubject, true);
    ClipperLib::Paths region;
    if (!clipper.Execute(ClipperLib::ctUnion, region, ClipperLib::pftNonZero, ClipperLib::pftNonZero)) {
        fail("the library fails");
    }
    return radius > 0 ? grown(grown(region, radius), -radius) : region;
}

/// A layer's contours, also in the library's own form, so that only its work is timed.
struct BothForms {
    std::vector<std::span<const Point>> ours;
    ClipperLib::Paths theirs;
    double length = 0;  // of the contours, grid units
};

BothForms both_forms(const LayerView& layer) {
    BothForms both;
    for (const Contour& contour : layer.contours) {
        if (contour.role == Role::open) {
            continue;
        }
        const std::span<const Point> points = both.ours.emplace_back(layer.points_of(contour));
        ClipperLib::Path& path = both.theirs.emplace_back();
        Point last = points.back();
        for (const Point& point : points) {
            path.emplace_back(point.x, point.y);
            both.length += std::hypot(static_cast<double>(point.x) - last.x, static_cast<double>(point.y) - last.y);
            last = point;
        }
    }
    return both;
}

void require_same_area(const BothForms& layer, double closing, double unit_mm) {
    double difference = checked(region_of(layer.ours, non_zero(closing), unit_mm))[0].area_mm2() / (unit_mm * unit_mm);
    for (const ClipperLib::Path& path : closed(layer.theirs, closing / unit_mm)) {
        difference -= ClipperLib::Area(path);
    }
    if (std::abs(difference) > units_apart * layer.length) {
        fail("a region differs from the library's by " + std::to_string(difference) + " square units, " +
             std::to_string(difference / layer.length) + " units along its contours");
    }
}

Figures time_layers(const MeshView& mesh, int rounds) {
    const SliceResult result = checked(slice(mesh, layers));
    const double unit_mm = result.info.grid_mm;
    std::vector<BothForms> all;
    for (const LayerView layer : result) {
        all.push_back(both_forms(layer));
        require_same_area(all.back(), 0, unit_mm);
        require_same_area(all.back(), closing_mm, unit_mm);
    }
    const auto ours = [&](double closing) {
        for (const BothForms& layer : all) {
            checked(region_of(layer.ours, non_zero(closing), unit_mm));
        }
    };
    const auto theirs = [&](double closing) {
        for (const BothForms& layer : all) {
            closed(layer.theirs, closing / unit_mm);
        }
    };
    return medians_of({{"union", [&] { ours(0); }},
                       {"library_union", [&] { theirs(0); }},
                       {"closing", [&] { ours(closing_mm); }},
                       {"library_closing", [&] { theirs(closing_mm); }}},
                      rounds);
}

SliceResult united_layers(const MeshView& mesh) {
    SliceOptions options = layers;
    options.region = non_zero();
    return checked(slice(mesh, options));
}

/// Combines a stack with itself by `rule`, into memory of its own, which stays warm.
std::function<void()> combining(const SliceResult& stack, LayerSet neighbours, const Rule& rule, int threads) {
    neighbours.layers = stack;
    const auto overlay = std::make_shared<Overlay>();
    const auto result = std::make_shared<SliceResult>();
    return [=, &stack] {
        const LayerSet sets[] = {{.layers = stack}, neighbours};
        checked(overlay->combine(*result, sets, rule, {}, {.threads = threads}));
    };
}

/// What the layers above leave uncovered, and what reaches beyond the layers below by more than `offset_mm`.
Figures time_stacks(const MeshView& mesh, int rounds) {
    const SliceResult stack = united_layers(mesh);
    const LayerSet above{.from = 1, .to = 1};
    return medians_of(
        {{"plain", slicing(mesh, {})},
         {"top", combining(stack, above, subtract, region_threads)},
         {"overhang", combining(stack, {.from = -1, .to = -1, .grow_mm = offset_mm}, subtract, region_threads)}},
        rounds);
}

/// The first without the second.
ClipperLib::Paths difference(const ClipperLib::Paths& of, const ClipperLib::Paths& without) {
    ClipperLib::Clipper clipper;
    clipper.AddPaths(of, ClipperLib::ptSubject, true);
    clipper.AddPaths(without, ClipperLib::ptClip, true);
    ClipperLib::Paths region;
    clipper.Execute(ClipperLib::ctDifference, region, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
    return region;
}

/// The same top surfaces by the library, on one thread.
Figures time_tops(const MeshView& mesh, int rounds) {
    const SliceResult stack = united_layers(mesh);
    std::vector<BothForms> all;
    for (const LayerView layer : stack) {
        all.push_back(both_forms(layer));
    }
    all.emplace_back();
    const LayerSet sets[] = {{.layers = stack}, {.layers = stack, .from = 1, .to = 1}};
    SliceResult tops;
    checked(Overlay().combine(tops, sets, subtract));
    const double unit_mm2 = tops.info.grid_mm * tops.info.grid_mm;
    for (std::size_t n = 0; n < tops.size(); ++n) {
        double apart = tops[n].area_mm2() / unit_mm2;
        for (const ClipperLib::Path& path : difference(all[n].theirs, all[n + 1].theirs)) {
            apart -= ClipperLib::Area(path);
        }
        if (std::abs(apart) > units_apart * (all[n].length + all[n + 1].length)) {
            fail("top surfaces differ from the library's by " + std::to_string(apart) + " square units");
        }
    }
    const auto theirs = [&] {
        for (std::size_t n = 0; n + 1 < all.size(); ++n) {
            difference(all[n].theirs, all[n + 1].theirs);
        }
    };
    return medians_of({{"top", combining(stack, {.from = 1, .to = 1}, subtract, 1)}, {"library_top", theirs}}, rounds);
}

}  // namespace

void add_regions(const Options& options) {
    const std::int32_t less = options.quick ? 10 : 1;
    const auto add = [&](const std::string& name, auto make) {
        for (const FillRule rule : {FillRule::non_zero, FillRule::even_odd}) {
            add_benchmark(options, "region/" + name + "/" + std::string(lamella::name_of(rule)), 1,
                          [=](benchmark::State& state) { return time_region(state, make(), rule); });
        }
    };
    add("boxes_40000_apart", [=] { return boxes(200 / less, step / 2); });
    add("boxes_40000_touching", [=] { return boxes(200 / less, 0); });
    add("rods_240x240", [=] { return bars(240 / less); });
    add("comb_16000", [=] { return comb(16'000 / less); });
    add("bars_500x500", [=] { return bars(500 / less); });
    add("bars_1000x1000", [=] { return bars(1'000 / less); });
}

void add_slices_with_regions(const Options& options, const Case& wanted) {
    const int rounds = options.quick ? 1 : 3;
    add_benchmark(options, "regions/" + wanted.name + "/slices", region_threads,
                  [=](benchmark::State&) { return time_slices(prepared(wanted).mesh->view(), 3 * rounds); });
    add_benchmark(options, "regions/" + wanted.name + "/stacks", region_threads,
                  [=](benchmark::State&) { return time_stacks(prepared(wanted).mesh->view(), 3 * rounds); });
    add_benchmark(options, "regions/" + wanted.name + "/tops", 1,
                  [=](benchmark::State&) { return time_tops(prepared(wanted).mesh->view(), rounds); });
    add_benchmark(options, "regions/" + wanted.name + "/layers", 1,
                  [=](benchmark::State&) { return time_layers(prepared(wanted).mesh->view(), rounds); });
}

}  // namespace lamella::bench
