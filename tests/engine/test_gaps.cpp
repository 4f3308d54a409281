// Which ends of polylines are joined, compared with a sorted list of all pairs.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "slicing/repair/gaps.hpp"

using lamella::Gap;
using lamella::GapCloser;
using lamella::GapRules;
using lamella::GapSense;
using lamella::Point;
using lamella::PolylineEnds;

namespace {

/// The numbers of two ends: twice the polyline's, and one more for its last point.
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pairs greedy(const std::vector<PolylineEnds>& polylines, const GapRules& rules) {
    const auto at = [&](std::uint32_t end) { return end % 2 != 0 ? polylines[end / 2].last : polylines[end / 2].first; };
    std::vector<std::tuple<double, bool, Point, Point, std::uint32_t, std::uint32_t>> all;
    const auto ends = static_cast<std::uint32_t>(2 * polylines.size());
    for (std::uint32_t a = 0; a < ends; ++a) {
        for (std::uint32_t b = 0; b < ends; ++b) {
            const bool turns = a % 2 == b % 2;
            const bool listed =
                turns ? rules.sense == GapSense::any && std::pair(at(a), a) < std::pair(at(b), b) : a % 2 != 0;
            const double dx = static_cast<double>(at(b).x) - at(a).x;
            const double dy = static_cast<double>(at(b).y) - at(a).y;
            if (listed && dx * dx + dy * dy <= rules.reach * rules.reach) {
                all.emplace_back(dx * dx + dy * dy, turns, at(a), at(b), a, b);
            }
        }
    }
    std::sort(all.begin(), all.end());
    std::vector<bool> joined(ends, false);
    Pairs pairs;
    for (const auto& [squared, turns, at_a, at_b, a, b] : all) {
        if (!joined[a] && !joined[b]) {
            joined[a] = true;
            joined[b] = true;
            pairs.emplace_back(a, b);
        }
    }
    return pairs;
}

Pairs closed(GapCloser& closer, const std::vector<PolylineEnds>& polylines, const GapRules& rules) {
    Pairs pairs;
    for (const Gap& gap : closer.close(polylines, rules)) {
        pairs.emplace_back(gap.from.number(), gap.to.number());
    }
    return pairs;
}

/// Whether joined_to() agrees with the pairs.
bool agree(const GapCloser& closer, const Pairs& pairs, std::size_t polylines) {
    std::vector<std::uint32_t> other(2 * polylines);
    std::iota(other.begin(), other.end(), 0U);
    for (const auto& [from, to] : pairs) {
        other[from] = to;
        other[to] = from;
    }
    for (std::uint32_t p = 0; p < polylines; ++p) {
        for (const bool last : {false, true}) {
            if (closer.joined_to({p, last}).number() != other[2 * p + (last ? 1 : 0)]) {
                return false;
            }
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
    lamella::Worker worker;
    GapCloser closer(worker);
    std::size_t joined[2] = {0, 0};
    for (int turn = 0; turn < 6000; ++turn) {
        const std::int32_t side = 1 << random() % 9;  // few positions: many equal points and equal distances
        const std::int32_t step = turn % 3 == 0 ? (1 << 30) / side : 1 + turn % 2;
        const std::size_t count = random() % (turn % 50 == 0 ? 200 : 40);
        const auto polylines = random_polylines(random, count, turn % 3 == 1 ? 0 : -step * (side / 2), step, side);
        const double steps = std::uniform_real_distribution(0.0, side * 1.5)(random);
        const double reach = turn % 7 == 0 ? 1e300 : step * (turn % 7 == 1 ? std::floor(steps) : steps);
        for (const GapSense sense : {GapSense::kept, GapSense::any}) {
            const Pairs expected = greedy(polylines, {reach, reach, sense});
            INFO("turn " << turn << ", " << count << " polylines, sense " << static_cast<int>(sense));
            REQUIRE(closed(closer, polylines, {reach, reach, sense}) == expected);
            REQUIRE(agree(closer, expected, count));
            joined[static_cast<int>(sense)] += expected.size();
        }
    }
    CHECK(joined[0] > 40'000);
    CHECK(joined[1] > joined[0]);
}

TEST_CASE("ends in two distant clusters are joined as from a list of all pairs", "[engine][gaps]") {
    std::mt19937 random(22);
    lamella::Worker worker;
    GapCloser closer(worker);
    for (const std::int32_t apart : {3, 100, 1 << 29}) {
        auto polylines = random_polylines(random, 300, 0, 1, 20);
        for (PolylineEnds& polyline : polylines) {
            polyline.last.x += apart;
        }
        for (const GapSense sense : {GapSense::kept, GapSense::any}) {
            CHECK(closed(closer, polylines, {1 << 30, 1 << 30, sense}) == greedy(polylines, {1 << 30, 1 << 30, sense}));
        }
    }
}

TEST_CASE("closing gaps takes memory in proportion to the ends, not to their pairs", "[engine][gaps]") {
    std::mt19937 random(23);
    constexpr std::size_t count = 20'000;
    CountingMemory memory;
    lamella::Worker worker(&memory);
    GapCloser closer(worker);
    for (const GapSense sense : {GapSense::kept, GapSense::any}) {
        const GapRules rules{1 << 30, 1 << 30, sense};
        CHECK(closer.close(random_polylines(random, count, 0, 1, 1 << 20), rules).size() == count);
        CHECK(closer.close(random_polylines(random, count, 0, 1, 3), rules).size() == count);  // all ends at sixteen points
    }
    CHECK(memory.peak() < 160 * count);
}
