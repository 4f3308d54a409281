// region_of() on layers whose contours lie beside or across each other by the thousand. Each region's area is known.
#include <span>
#include <vector>

#include "engine/counting_memory.hpp"
#include "lamella/layers.hpp"
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

Figures time_region(const Options& options, const Layer2d& layer, FillRule rule) {
    const RegionRules rules{.fill_rule = rule};
    constexpr double unit_mm = 1;  // so that areas are in square grid units
    const std::vector<std::span<const Point>> contours = layer.spans();
    CountingMemory memory;
    if (checked(region_of(contours, rules, unit_mm, {.memory = &memory}))[0].area_mm2() !=
        (rule == FillRule::non_zero ? layer.non_zero : layer.even_odd)) {
        fail("the region has not the known area");
    }
    Figures figures = measure(options, [&] { checked(region_of(contours, rules, unit_mm)); });
    figures["peak_bytes"] = static_cast<double>(memory.peak());
    return figures;
}

}  // namespace

void run_regions(const Options& options) {
    const std::int32_t less = options.quick ? 10 : 1;
    const auto run = [&](const std::string& name, const auto& make) {
        for (const FillRule rule : {FillRule::non_zero, FillRule::even_odd}) {
            benchmark(options, "region/" + name + "/" + std::string(lamella::name_of(rule)), 1,
                      [&] { return time_region(options, make(), rule); });
        }
    };
    run("boxes_40000_apart", [=] { return boxes(200 / less, step / 2); });
    run("boxes_40000_touching", [=] { return boxes(200 / less, 0); });
    run("rods_240x240", [=] { return bars(240 / less); });
    run("comb_16000", [=] { return comb(16'000 / less); });
    run("bars_500x500", [=] { return bars(500 / less); });
    run("bars_1000x1000", [=] { return bars(1'000 / less); });
}

}  // namespace lamella::bench
