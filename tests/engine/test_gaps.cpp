// The parts of repair: which ends of polylines are joined, compared with a sorted list of all pairs; what becomes of their
// points; and joints that meet something, compared with a look at every edge.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"
#include "rings.hpp"
#include "slicing/repair/polylines.hpp"

using lamella::Gap;
using lamella::GapCloser;
using lamella::GapRules;
using lamella::Joint;
using lamella::Point;
using lamella::PolylineEnds;
using lamella::StitchDirection;

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
                turns ? rules.sense == StitchDirection::any && std::pair(at(a), a) < std::pair(at(b), b) : a % 2 != 0;
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

/// True where joined_to() agrees with the pairs.
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

/// Walls side by side and across one another, some of which lead on from each other. No two have an edge in common.
shapes::Soup random_walls(std::mt19937& random) {
    const auto draw = [&] { return std::array<double, 2>{double(random() % 4000), double(random() % 4000)}; };
    shapes::Soup soup;
    for (std::size_t lines = 1 + random() % 30; lines > 0; --lines) {
        auto from = draw();
        for (std::size_t walls = 1 + random() % 4; walls > 0; --walls) {
            const auto to = draw();
            shapes::append(soup, shapes::wall(from, to));
            from = to;
        }
    }
    return soup;
}

using Edges = std::multiset<std::pair<Point, Point>>;

/// Directed edges of a contour from point to point.
Edges edges_of(const lamella::LayerView& layer, const lamella::Contour& contour) {
    Edges edges;
    const auto points = layer.points_of(contour);
    for (std::size_t i = contour.role == lamella::Role::open ? 1 : 0; i < points.size(); ++i) {
        edges.emplace(points[i > 0 ? i - 1 : points.size() - 1], points[i]);
    }
    return edges;
}

/// True where the edge meets the joint at a place that is no end of the joint, and does not run along it.
bool lies_between(const Joint& joint, Point c, Point d) {
    using rings::side;
    const bool apart = side(joint.from, joint.to, c) * side(joint.from, joint.to, d) > 0;
    return !apart && side(c, d, joint.from) * side(c, d, joint.to) < 0;
}

struct Path {
    std::vector<Point> points;
    bool closed;
};

/// Joint by joint, edge by edge.
std::vector<std::uint8_t> crossed_by_all(const std::vector<Joint>& joints, std::size_t free,
                                         const std::vector<Path>& paths) {
    std::vector<std::uint8_t> crossed(joints.size(), 0);
    for (std::size_t j = free; j < joints.size(); ++j) {
        for (const Path& path : paths) {
            for (std::size_t i = 0; i + (path.closed ? 0 : 1) < path.points.size(); ++i) {
                crossed[j] |= lies_between(joints[j], path.points[i], path.points[(i + 1) % path.points.size()]) ? 1 : 0;
            }
        }
        for (std::size_t before = 0; before < j; ++before) {
            const bool meets = lies_between(joints[before], joints[j].from, joints[j].to);
            crossed[j] |= crossed[before] == 0 && meets ? 1 : 0;
        }
    }
    return crossed;
}

Point random_point(std::mt19937& random, std::uint32_t size) {
    return {static_cast<std::int32_t>(random() % size), static_cast<std::int32_t>(random() % size)};
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
        auto polylines = random_polylines(random, count, turn % 3 == 1 ? 0 : -step * (side / 2), step, side);
        for (PolylineEnds& polyline : polylines) {
            polyline.last.x += turn % 11 == 0 && step < 3 ? 1 << 29 : 0;  // two distant clusters
        }
        const double steps = std::uniform_real_distribution(0.0, side * 1.5)(random);
        const double reach = turn % 7 == 0 ? 1e300 : step * (turn % 7 == 1 ? std::floor(steps) : steps);
        for (const StitchDirection sense : {StitchDirection::oriented, StitchDirection::any}) {
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

TEST_CASE("closing gaps takes memory in proportion to the ends, not to their pairs", "[engine][gaps]") {
    std::mt19937 random(23);
    constexpr std::size_t count = 20'000;
    CountingMemory memory;
    lamella::Worker worker(&memory);
    GapCloser closer(worker);
    for (const StitchDirection sense : {StitchDirection::oriented, StitchDirection::any}) {
        const GapRules rules{1 << 30, 1 << 30, sense};
        CHECK(closer.close(random_polylines(random, count, 0, 1, 1 << 20), rules).size() == count);
        CHECK(closer.close(random_polylines(random, count, 0, 1, 3), rules).size() == count);  // all ends at sixteen points
    }
    CHECK(memory.peak() < 160 * count);
}

TEST_CASE("joined in any sense: each segment is kept once, and most run as before", "[engine][gaps]") {
    std::mt19937 random(31);
    std::size_t mixed = 0;
    for (int turn = 0; turn < 600; ++turn) {
        const shapes::Soup walls = random_walls(random);
        lamella::SliceOptions options = at_heights({5});
        const lamella::SliceResult open = sliced(walls, options);
        options.stitch_mm = 100 + static_cast<double>(random() % 2000);
        options.stitch_direction = StitchDirection::any;
        const lamella::SliceResult result = sliced(walls, options);  // of which the audit finds that no segment is lost
        Edges before;
        for (const lamella::Contour& contour : open.contours) {
            before.merge(edges_of(open[0], contour));
        }
        std::size_t others = 0;
        for (const lamella::Contour& contour : result.contours) {
            std::size_t forwards = 0;
            std::size_t backwards = 0;
            for (const auto& [from, to] : edges_of(result[0], contour)) {
                const bool kept = before.count({from, to}) != 0;
                const bool turned = before.count({to, from}) != 0;
                forwards += kept;
                backwards += turned;
                others += !kept && !turned;
            }
            if ((contour.flags & lamella::orientation_overruled) != 0 &&
                (contour.orientation > 0) != (contour.role == lamella::Role::outer)) {
                std::swap(forwards, backwards);  // turned round once more, as its role demands
            }
            REQUIRE(forwards >= backwards);
            REQUIRE(contour.segments == forwards + backwards);
            REQUIRE(((contour.flags & lamella::orientation_mixed) != 0) == (backwards != 0));
            mixed += backwards != 0;
        }
        REQUIRE(others == result.stitches.size());
    }
    CHECK(mixed > 500);
}

TEST_CASE("joints that meet something between their ends are those found edge by edge", "[engine][gaps]") {
    std::mt19937 random(77);
    lamella::Worker worker;
    lamella::CrossedJoints search(worker);
    std::size_t found = 0;
    for (int turn = 0; turn < 2000; ++turn) {
        const std::uint32_t size = turn % 2 == 0 ? 8 : 200;  // many touch, or few
        std::vector<Path> paths(random() % 5);
        std::vector<Joint> joints(1 + random() % 8);
        search.clear();
        for (Path& path : paths) {
            path.closed = random() % 2 == 0;
            path.points.resize(1 + random() % 12);
            std::generate(path.points.begin(), path.points.end(), [&] { return random_point(random, size); });
            search.add(path.points, path.closed);
        }
        std::generate(joints.begin(), joints.end(), [&] {
            return Joint{random_point(random, size), random_point(random, size)};
        });
        const std::size_t free = random() % 3;
        const std::span<const std::uint8_t> crossed = search.find(joints, free);
        const std::vector<std::uint8_t> expected = crossed_by_all(joints, free, paths);
        REQUIRE(std::equal(crossed.begin(), crossed.end(), expected.begin(), expected.end()));
        found += static_cast<std::size_t>(std::count(expected.begin(), expected.end(), 1));
    }
    CHECK(found > 1000);
}
