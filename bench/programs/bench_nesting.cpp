// Times nesting alone, on layers of 10 to 10,000 contours.
#include <cmath>
#include <vector>

#include "base/numbers.hpp"
#include "measure.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella::bench {

namespace {

constexpr std::int32_t steps = 16;  // points on each side

/// A square ring of 64 points: counter-clockwise, or as a hole the other way.
std::vector<Point> ring(Point low, std::int32_t length, bool hole) {
    std::vector<Point> points;
    points.reserve(4 * steps);
    for (std::int32_t at = 0; at < 4 * steps; ++at) {
        const std::int32_t along = at % steps * (length / steps);
        const Point turning[] = {{along, 0}, {length, along}, {length - along, length}, {0, length - along}};
        const auto [x, y] = turning[at / steps];
        points.push_back(hole ? Point{low.x + y, low.y + x} : Point{low.x + x, low.y + y});
    }
    return points;
}

/// Square rings on a square lattice, of which every second is the hole of the one before it.
Figures time_nesting(benchmark::State& state, std::uint32_t contours) {
    constexpr std::int32_t side = 64 * steps;
    const auto row = static_cast<std::int32_t>(std::ceil(std::sqrt(contours / 2)));
    std::vector<std::vector<Point>> rings;
    std::vector<NestItem> items(contours);
    rings.reserve(contours);
    for (NestItem& item : items) {
        const auto i = static_cast<std::int32_t>(rings.size());
        const bool hole = i % 2 == 1;
        const std::int32_t length = hole ? side / 2 : side;
        const Point low{i / 2 % row * 2 * side - length / 2, i / 2 / row * 2 * side - length / 2};
        item.points = rings.emplace_back(ring(low, length, hole)).data();
        item.count = 4 * steps;
        item.twice_area = to_integer128((hole ? -2 : 2) * Int128{length} * length);
        item.box = {low, {low.x + length, low.y + length}};
        item.closed = true;
    }
    lamella::Worker worker;
    Nester nester(worker);
    nester.nest(items);
    for (std::size_t i = 0; i < items.size(); ++i) {
        const bool hole = i % 2 == 1;
        if (items[i].parent != (hole ? static_cast<std::int64_t>(i) - 1 : -1) ||
            items[i].role != (hole ? Role::hole : Role::outer)) {
            fail("the rings are not nested as constructed");
        }
    }
    const auto without_answer = [&] {
        for (NestItem& item : items) {
            item.flags = 0;
            item.parent = -1;
        }
    };
    Figures figures = measure(state, without_answer, [&] { nester.nest(items); });
    figures["contours/s"] = rate_of(contours, figures);
    return figures;
}

}  // namespace

void add_nesting(const Options& options) {
    for (const std::uint32_t contours : {10U, 100U, 1'000U, 10'000U}) {
        add_benchmark(options, "nesting/rings_" + std::to_string(contours) + "/series", 1,
                      [=](benchmark::State& state) { return time_nesting(state, contours); });
    }
}

}  // namespace lamella::bench
