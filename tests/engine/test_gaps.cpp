// The parts of repair: which ends of polylines are joined, compared with a sorted list of all pairs; what becomes of their
// points; and joints that meet something, compared with a look at every edge.
#include <algorithm>
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
#include "lamella/result.hpp"
#include "rings.hpp"
#include "slicing/repair/gaps.hpp"
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

struct Line {
    std::vector<Point> points;
    std::uint16_t flags = 0;
};

/// Three to six points each, all points apart from each other: no gap is as an edge.
std::vector<Line> random_lines(std::mt19937& random, std::size_t count) {
    std::set<Point> used;
    std::vector<Line> lines(count);
    for (Line& line : lines) {
        const std::size_t points = 3 + random() % 4;
        while (line.points.size() < points) {
            const Point point{static_cast<std::int32_t>(random() % 40), static_cast<std::int32_t>(random() % 40)};
            if (used.insert(point).second) {
                line.points.push_back(point);
            }
        }
    }
    return lines;
}

/// A joined polyline by content.
struct Whole {
    std::vector<Point> points;
    std::uint32_t segments = 0;
    unsigned flags = 0;
    bool closed = false;
    auto operator<=>(const Whole&) const = default;
};

struct Joined {
    std::vector<Whole> wholes;
    std::vector<std::pair<Point, Point>> gaps;
    bool operator==(const Joined&) const = default;
};

Joined joined(const std::vector<Line>& lines, double reach, StitchDirection sense) {
    std::vector<lamella::Path> polylines;
    for (const Line& line : lines) {
        lamella::Path& path = polylines.emplace_back(lamella::given_path(line.points, nullptr, false));
        path.segments = static_cast<std::uint32_t>(line.points.size() - 1);
        path.item.flags = line.flags;
    }
    lamella::Worker worker;
    lamella::PolylineRepair repair(worker);
    lamella::Vector<lamella::Stitch> gaps(nullptr);
    Joined result;
    if (repair.join(polylines, {}, {reach, reach, sense}, 0, gaps)) {
        for (const lamella::Path& whole : repair.joined()) {
            const lamella::NestItem& item = whole.item;
            result.wholes.push_back({{item.points, item.points + item.count}, whole.segments, item.flags, item.closed});
        }
    }
    for (const lamella::Stitch& gap : gaps) {
        result.gaps.emplace_back(gap.from, gap.to);
    }
    return result;
}

using Edges = std::multiset<std::pair<Point, Point>>;

/// Directed edges from point to point; of those that close a ring too.
Edges edges_of(const std::vector<Point>& points, bool closed) {
    Edges edges;
    for (std::size_t i = 0; i + 1 < points.size() + (closed ? 1 : 0); ++i) {
        edges.emplace(points[i], points[(i + 1) % points.size()]);
    }
    return edges;
}

bool has(const Edges& edges, Point a, Point b) {
    return edges.count({a, b}) != 0;
}

/// How many edges of `lines` the whole holds, forwards and backwards.
std::pair<std::uint32_t, std::uint32_t> senses_of(const Whole& whole, const std::vector<Line>& lines) {
    const Edges edges = edges_of(whole.points, whole.closed);
    std::pair<std::uint32_t, std::uint32_t> senses;
    for (const Line& line : lines) {
        for (const auto& [from, to] : edges_of(line.points, false)) {
            senses.first += has(edges, from, to) ? 1 : 0;
            senses.second += has(edges, to, from) ? 1 : 0;
        }
    }
    return senses;
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
        const auto polylines = random_polylines(random, count, turn % 3 == 1 ? 0 : -step * (side / 2), step, side);
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

TEST_CASE("ends in two distant clusters are joined as from a list of all pairs", "[engine][gaps]") {
    std::mt19937 random(22);
    lamella::Worker worker;
    GapCloser closer(worker);
    for (const std::int32_t apart : {3, 100, 1 << 29}) {
        auto polylines = random_polylines(random, 300, 0, 1, 20);
        for (PolylineEnds& polyline : polylines) {
            polyline.last.x += apart;
        }
        for (const StitchDirection sense : {StitchDirection::oriented, StitchDirection::any}) {
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
        const std::vector<Line> lines = random_lines(random, 1 + random() % 30);
        const Joined result = joined(lines, static_cast<double>(random() % 20), StitchDirection::any);
        if (result.gaps.empty()) {
            continue;
        }
        Edges all;
        std::uint32_t kept = 0;
        for (const Whole& whole : result.wholes) {
            const auto [forwards, backwards] = senses_of(whole, lines);
            REQUIRE(forwards >= backwards);
            REQUIRE(whole.segments == forwards + backwards);
            REQUIRE(((whole.flags & lamella::orientation_mixed) != 0) == (backwards != 0));
            mixed += backwards != 0 ? 1 : 0;
            kept += whole.segments;
            all.merge(edges_of(whole.points, whole.closed));
        }
        std::uint32_t given = 0;
        for (const Line& line : lines) {
            given += static_cast<std::uint32_t>(line.points.size() - 1);
        }
        REQUIRE(kept == given);
        REQUIRE(all.size() == given + result.gaps.size());
        for (const auto& [from, to] : result.gaps) {
            REQUIRE((has(all, from, to) || has(all, to, from)));
        }
    }
    CHECK(mixed > 500);
}

TEST_CASE("joined in any sense: the order of the polylines does not matter", "[engine][gaps]") {
    std::mt19937 random(32);
    for (int turn = 0; turn < 300; ++turn) {
        std::vector<Line> lines = random_lines(random, 1 + random() % 30);
        const std::vector<Line> again(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(lines.size() / 3));
        lines.insert(lines.end(), again.begin(), again.end());
        const auto reach = static_cast<double>(random() % 20);
        const Joined result = joined(lines, reach, StitchDirection::any);
        std::shuffle(lines.begin(), lines.end(), random);
        REQUIRE(joined(lines, reach, StitchDirection::any) == result);
    }
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
