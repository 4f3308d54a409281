// Which ends of polylines are joined, compared with a sorted list of all pairs.
#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "slicing/repair/gaps.hpp"

using lamella::Gap;
using lamella::GapCloser;
using lamella::Point;
using lamella::PolylineEnds;

namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pairs greedy(const std::vector<PolylineEnds>& polylines, double reach) {
    std::vector<std::tuple<double, Point, Point, std::uint32_t, std::uint32_t>> all;
    for (std::uint32_t from = 0; from < polylines.size(); ++from) {
        for (std::uint32_t to = 0; to < polylines.size(); ++to) {
            const Point end = polylines[from].last;
            const Point start = polylines[to].first;
            const double dx = static_cast<double>(start.x) - end.x;
            const double dy = static_cast<double>(start.y) - end.y;
            if (dx * dx + dy * dy <= reach * reach) {
                all.emplace_back(dx * dx + dy * dy, end, start, from, to);
            }
        }
    }
    std::sort(all.begin(), all.end());
    std::vector<bool> left(polylines.size(), true);
    std::vector<bool> entered(polylines.size(), false);
    Pairs pairs;
    for (const auto& [squared, end, start, from, to] : all) {
        if (left[from] && !entered[to]) {
            left[from] = false;
            entered[to] = true;
            pairs.emplace_back(from, to);
        }
    }
    return pairs;
}

Pairs closed(GapCloser& closer, const std::vector<PolylineEnds>& polylines, double reach) {
    Pairs pairs;
    for (const Gap& gap : closer.close(polylines, reach)) {
        pairs.emplace_back(gap.from, gap.to);
    }
    return pairs;
}

/// Whether next() and follows() agree with the pairs.
bool agree(const GapCloser& closer, const Pairs& pairs, std::size_t polylines) {
    std::vector<std::int64_t> next(polylines, -1);
    std::vector<bool> follows(polylines, false);
    for (const auto& [from, to] : pairs) {
        next[from] = to;
        follows[to] = true;
    }
    for (std::uint32_t p = 0; p < polylines; ++p) {
        if (closer.next(p) != next[p] || closer.follows(p) != follows[p]) {
            return false;
        }
    }
    return true;
}

/// Each coordinate is `corner` plus 0 to `side` multiples of `step`.
std::vector<PolylineEnds> random_polylines(std::mt19937& random, std::size_t count, std::int32_t corner, std::int32_t step,
                                           std::int32_t side) {
    std::uniform_int_distribution<std::int32_t> cell(0, side);
    const auto draw = [&] { return corner + step * cell(random); };
    std::vector<PolylineEnds> polylines(count);
    for (PolylineEnds& polyline : polylines) {
        polyline = {{draw(), draw()}, {draw(), draw()}};
    }
    return polylines;
}

}  // namespace

TEST_CASE("the joined pairs and their order are those of a list of all pairs", "[engine][gaps]") {
    std::mt19937 random(21);
    GapCloser closer(nullptr);
    std::size_t joined = 0;
    for (int turn = 0; turn < 6000; ++turn) {
        const std::int32_t side = 1 << random() % 9;  // few positions: many equal points and equal distances
        const std::int32_t step = turn % 3 == 0 ? (1 << 30) / side : 1 + turn % 2;
        const std::size_t count = random() % (turn % 50 == 0 ? 200 : 40);
        const auto polylines = random_polylines(random, count, turn % 3 == 1 ? 0 : -step * (side / 2), step, side);
        const double steps = std::uniform_real_distribution(0.0, side * 1.5)(random);
        const double reach = turn % 7 == 0 ? 1e300 : step * (turn % 7 == 1 ? std::floor(steps) : steps);
        const Pairs expected = greedy(polylines, reach);
        INFO("turn " << turn << ", " << count << " polylines");
        REQUIRE(closed(closer, polylines, reach) == expected);
        REQUIRE(agree(closer, expected, count));
        joined += expected.size();
    }
    CHECK(joined > 40'000);
}

TEST_CASE("ends in two distant clusters are joined as from a list of all pairs", "[engine][gaps]") {
    std::mt19937 random(22);
    GapCloser closer(nullptr);
    for (const std::int32_t apart : {3, 100, 1 << 29}) {
        auto polylines = random_polylines(random, 300, 0, 1, 20);
        for (PolylineEnds& polyline : polylines) {
            polyline.last.x += apart;
        }
        CHECK(closed(closer, polylines, 1 << 30) == greedy(polylines, 1 << 30));
    }
}

TEST_CASE("closing gaps takes memory in proportion to the ends, not to their pairs", "[engine][gaps]") {
    std::mt19937 random(23);
    constexpr std::size_t count = 20'000;
    CountingMemory memory;
    GapCloser closer(&memory);
    CHECK(closer.close(random_polylines(random, count, 0, 1, 1 << 20), 1 << 30).size() == count);
    CHECK(closer.close(random_polylines(random, count, 0, 1, 3), 1 << 30).size() == count);  // all ends at sixteen points
    CHECK(memory.peak() < 160 * count);
}
