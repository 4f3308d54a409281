// Open polylines joined whatever their sense: what becomes of their points, and what slices show.
#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "slicing/repair/polylines.hpp"

using lamella::GapSense;
using lamella::Point;
using lamella::Role;
using lamella::SliceResult;

namespace {

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

Joined joined(const std::vector<Line>& lines, double reach, GapSense sense) {
    std::vector<lamella::Path> polylines;
    for (const Line& line : lines) {
        lamella::Path& path = polylines.emplace_back(lamella::given_path(line.points, nullptr, false));
        path.segments = static_cast<std::uint32_t>(line.points.size() - 1);
        path.item.flags = line.flags;
    }
    lamella::Worker worker;
    lamella::PolylineRepair repair(worker);
    lamella::Vector<lamella::ClosedGap> gaps(nullptr);
    Joined result;
    if (repair.join(polylines, {}, {reach, reach, sense}, 0, gaps)) {
        for (const lamella::Path& whole : repair.joined()) {
            const lamella::NestItem& item = whole.item;
            result.wholes.push_back({{item.points, item.points + item.count}, whole.segments, item.flags, item.closed});
        }
    }
    for (const lamella::ClosedGap& gap : gaps) {
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

/// Along the x axis at this height in y, 10 mm tall; it runs from x0 to x1.
shapes::Soup wall(double x0, double x1, double y) {
    return shapes::joined(
        {shapes::triangle({x0, y, 0}, {x1, y, 0}, {x1, y, 10}), shapes::triangle({x0, y, 0}, {x1, y, 10}, {x0, y, 10})});
}

SliceResult cut(const shapes::Soup& soup, double reach_mm, GapSense sense) {
    lamella::SliceOptions options = at_heights({5});
    options.close_gaps_mm = reach_mm;
    options.gap_sense = sense;
    return sliced(soup, options);
}

}  // namespace

TEST_CASE("joined in any sense: each segment is kept once, and most run as before", "[engine][gaps]") {
    std::mt19937 random(31);
    std::size_t mixed = 0;
    for (int turn = 0; turn < 600; ++turn) {
        const std::vector<Line> lines = random_lines(random, 1 + random() % 30);
        const Joined result = joined(lines, static_cast<double>(random() % 20), GapSense::any);
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
        const Joined result = joined(lines, reach, GapSense::any);
        std::shuffle(lines.begin(), lines.end(), random);
        REQUIRE(joined(lines, reach, GapSense::any) == result);
    }
}

TEST_CASE("two walls that run the same way close in any sense only", "[engine][gaps]") {
    const shapes::Soup soup = shapes::joined({wall(0, 20, 0), wall(0, 20, 10)});
    const SliceResult kept = cut(soup, 10, GapSense::kept);
    CHECK(kept.summary.open_contours == 2);
    CHECK(kept.closed_gaps.empty());
    const SliceResult any = cut(soup, 10, GapSense::any);
    REQUIRE(any.contours.size() == 1);
    CHECK(any.contours[0].role == Role::outer);
    CHECK(any.contours[0].flags == (lamella::gap_closed | lamella::orientation_mixed));
    CHECK(any.contours[0].segments == 4);
    CHECK(any.area_mm2(any.layers[0]) == 200);
    CHECK(any.gap_sense == GapSense::any);
    REQUIRE(any.closed_gaps.size() == 2);
    CHECK(any.closed_gaps[0].from == Point{0, 0});
    CHECK(any.closed_gaps[0].to == Point{0, 20});
    CHECK(any.closed_gaps[1].from == Point{40, 0});
    CHECK(any.closed_gaps[1].to == Point{40, 20});
    CHECK(cut(soup, 9.9, GapSense::any).closed_gaps.empty());
}

TEST_CASE("a wall against two others is the one that is turned", "[engine][gaps]") {
    const shapes::Soup soup = shapes::joined({wall(0, 20, 0), wall(40, 21, 0), wall(41, 60, 0)});
    const SliceResult any = cut(soup, 1, GapSense::any);
    REQUIRE(any.contours.size() == 1);
    CHECK(any.contours[0].role == Role::open);
    CHECK((any.contours[0].flags & lamella::orientation_mixed) != 0);
    const auto points = any.points_of(any.contours[0]);
    CHECK(points.front() == Point{0, 0});
    CHECK(points.back() == Point{120, 0});
    const SliceResult mirrored = cut(shapes::joined({wall(20, 0, 0), wall(21, 40, 0), wall(60, 41, 0)}), 1, GapSense::any);
    REQUIRE(mirrored.contours.size() == 1);
    CHECK(mirrored.points_of(mirrored.contours[0]).front() == Point{120, 0});
}

TEST_CASE("walls that agree are joined alike in both senses", "[engine][gaps]") {
    const shapes::Soup soup = shapes::joined({wall(0, 10, 0), wall(14, 24, 0), wall(24, 0, 8)});
    const SliceResult any = cut(soup, 8, GapSense::any);
    CHECK(hash_result(any) == hash_result(cut(soup, 8, GapSense::kept)));
    CHECK(any.contours[0].flags == lamella::gap_closed);
}

TEST_CASE("gaps in any sense: threads, bands and triangle order do not change the bytes", "[engine][gaps][threads]") {
    shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 4);
    std::mt19937 random(8);
    for (int lost = 0; lost < 120; ++lost) {
        const auto t = static_cast<std::ptrdiff_t>(random() % (soup.size() / 9));
        soup.erase(soup.begin() + 9 * t, soup.begin() + 9 * t + 9);
    }
    for (std::size_t t = 0; t < soup.size() / 9; ++t) {
        if (random() % 3 == 0) {
            std::swap_ranges(&soup[9 * t], &soup[9 * t] + 3, &soup[9 * t] + 3);
        }
    }
    lamella::SliceOptions options = uniform(0.05);
    options.close_gaps_mm = 1;
    const SliceResult kept = sliced(soup, options);
    options.gap_sense = GapSense::any;
    const SliceResult closed = sliced(soup, options);
    CHECK(closed.closed_gaps.size() > kept.closed_gaps.size());
    CHECK(closed.summary.open_contours < kept.summary.open_contours);
    for (int turn = 0; turn < 3; ++turn) {
        options.control.threads = turn + 1;
        options.tuning.band_planes = turn * 9;
        options.tuning.form = turn == 1 ? lamella::ContourForm::assembled : lamella::ContourForm::swept;
        soup = shapes::shuffled(soup, random());
        const SliceResult again = sliced(soup, options);
        CHECK(hash_result(again) == hash_result(closed));
        CHECK(std::equal(
            again.closed_gaps.begin(), again.closed_gaps.end(), closed.closed_gaps.begin(), closed.closed_gaps.end(),
            [](const auto& a, const auto& b) { return a.layer == b.layer && a.from == b.from && a.to == b.to; }));
    }
}
