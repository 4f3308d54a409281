// Gaps: which ends of polylines are joined, compared with a sorted list of all pairs and a look at every edge that a joint
// may cross; what becomes of their points; lengths that are given or that the mesh gives; and what is left open.
#include <random>
#include <set>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"
#include "rings.hpp"
#include "slicing/repair/polylines.hpp"

using namespace lamella;
using namespace shapes;

namespace {

using Joint = std::pair<Point, Point>;
using Joints = std::vector<Joint>;

/// Closed or not, without equal points side by side.
struct Line {
    std::vector<Point> points;
    bool closed = false;
};

/// True where the edge meets the joint at a place that is no end of the joint, and does not run along it.
bool lies_between(const Joint& joint, Point c, Point d) {
    using rings::side;
    const auto [from, to] = joint;
    return side(from, to, c) * side(from, to, d) <= 0 && side(c, d, from) * side(c, d, to) < 0;
}

/// Joint by joint, edge by edge: without those that cross.
Joints uncrossed(const Joints& joints, const std::vector<Line>& lines, double crossing_reach) {
    Joints kept;
    for (const Joint& joint : joints) {
        bool crossed = std::any_of(kept.begin(), kept.end(),
                                   [&](const Joint& other) { return lies_between(other, joint.first, joint.second); });
        for (const auto& [points, closed] : lines) {
            for (std::size_t i = 0; i + (closed ? 0 : 1) < points.size(); ++i) {
                crossed = crossed || lies_between(joint, points[i], points[(i + 1) % points.size()]);
            }
        }
        if (!crossed || squared_distance(joint.first, joint.second) <= crossing_reach * crossing_reach) {
            kept.push_back(joint);
        }
    }
    return kept;
}

/// By a sorted list of all pairs of ends.
Joints nearest_first(const std::vector<Line>& lines, const GapRules& rules) {
    std::vector<Point> ends;  // first and last points in turn
    for (const Line& line : lines) {
        ends.insert(ends.end(), {line.points.front(), line.points.back()});
    }
    std::vector<std::tuple<double, bool, Point, Point, std::size_t, std::size_t>> all;
    for (std::size_t a = 0; a < ends.size(); ++a) {
        for (std::size_t b = 0; b < ends.size(); ++b) {
            const bool turns = a % 2 == b % 2;
            const bool listed =
                turns ? rules.sense == StitchDirection::any && std::pair(ends[a], a) < std::pair(ends[b], b) : a % 2 != 0;
            const double squared = squared_distance(ends[a], ends[b]);
            if (listed && !lines[a / 2].closed && !lines[b / 2].closed && squared <= rules.reach * rules.reach) {
                all.emplace_back(squared, turns, ends[a], ends[b], a, b);
            }
        }
    }
    std::sort(all.begin(), all.end());
    std::vector<bool> joined(ends.size(), false);
    Joints joints;
    for (const auto& [squared, turns, at_a, at_b, a, b] : all) {
        if (!joined[a] && !joined[b]) {
            joined[a] = joined[b] = true;
            joints.emplace_back(at_a, at_b);
        }
    }
    return joints;
}

/// The gaps that the engine closes.
Joints stitched(PolylineRepair& repair, std::vector<Line> lines, const GapRules& rules) {
    std::vector<Path> open;
    std::vector<Path> around;
    for (auto& [points, closed] : lines) {
        (closed ? around : open).push_back(closed ? closed_path(points, nullptr) : open_path(points, nullptr));
    }
    Vector<Stitch> stitches(nullptr);
    const bool any = repair.join(open, around, rules, 7, stitches);
    CHECK(any == !stitches.empty());
    Joints joints;
    for (const Stitch& stitch : stitches) {
        joints.emplace_back(stitch.from, stitch.to);
    }
    return joints;
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
Soup random_walls(std::mt19937& random) {
    const auto draw = [&] { return std::array<double, 2>{double(random() % 4000), double(random() % 4000)}; };
    Soup soup;
    for (std::size_t lines = 1 + random() % 30; lines > 0; --lines) {
        auto from = draw();
        for (std::size_t walls = 1 + random() % 4; walls > 0; --walls) {
            const auto to = draw();
            append(soup, wall(from, to));
            from = to;
        }
    }
    return soup;
}

using Edges = std::multiset<std::pair<Point, Point>>;

/// Directed edges of a contour from point to point.
Edges edges_of(const LayerView& layer, const Contour& contour) {
    Edges edges;
    const auto points = layer.points_of(contour);
    for (std::size_t i = contour.role == Role::open ? 1 : 0; i < points.size(); ++i) {
        edges.emplace(points[i > 0 ? i - 1 : points.size() - 1], points[i]);
    }
    return edges;
}

using Texts = std::vector<std::string>;

double length_mm(const SliceResult& result, const Stitch& stitch) {
    return std::hypot(double(stitch.to.x) - stitch.from.x, double(stitch.to.y) - stitch.from.y) * result.info.grid_mm;
}

OpenLayers open_of(const SliceResult& result, int threads = 1) {
    return value_of(audits::open_layers_of(result, {.threads = threads}));
}

/// A square tube of a metre whose lower wall lacks what lies between x = 495 and 505.
Soup cracked_tube() {
    return joined({wall({0, 0}, {495, 0}), wall({505, 0}, {1000, 0}), wall({1000, 0}, {1000, 1000}),
                   wall({1000, 1000}, {0, 1000}), wall({0, 1000}, {0, 0})});
}

SliceOptions stitched_by(double stitch_mm = stitch_by_mesh) {
    return {.heights_mm = {{3, 5}}, .stitch_mm = stitch_mm, .frame = {.grid_mm = coarse_unit_mm}};
}

TEST_CASE("the gaps that are closed, and their order, are those of a list of all pairs without joints that cross something",
          "[engine][gaps]") {
    std::mt19937 random(21);
    Worker worker;
    PolylineRepair repair(worker);
    std::size_t joined[2] = {0, 0};
    std::size_t left_open = 0;
    for (int turn = 0; turn < 3000; ++turn) {
        const std::int32_t side = 1 << random() % 9;  // few positions: many equal points and equal distances
        const std::int32_t step = turn % 3 == 0 ? (1 << 30) / side : 1 + turn % 2;
        const std::int32_t corner = turn % 3 == 1 ? 0 : -step * (side / 2);
        std::vector<Line> lines(random() % (turn % 50 == 0 ? 200 : 40));
        for (auto& [points, closed] : lines) {
            closed = turn % 2 == 0 && random() % 8 == 0;
            for (const PolylineEnds& ends : random_polylines(random, 2, corner, step, side)) {
                points.insert(points.end(), {ends.first, ends.last});
            }
            points.resize(points.size() - (closed ? 0 : random() % 3));
            points.back().x += turn % 11 == 0 && step < 3 ? 1 << 29 : 0;  // two distant clusters
            points.erase(std::unique(points.begin(), points.end()), points.end());
            if (points.size() == 1) {
                points.push_back({points[0].x + 1, points[0].y});
            }
        }
        const double steps = std::uniform_real_distribution(0.0, side * 1.5)(random);
        const double reach = turn % 7 == 0 ? 1e300 : step * (turn % 7 == 1 ? std::floor(steps) : steps);
        for (const StitchDirection sense : {StitchDirection::oriented, StitchDirection::any}) {
            const double crossing_reach = reach * (turn % 4) / 4;
            const Joints nearest = nearest_first(lines, {reach, reach, sense});
            const Joints expected = uncrossed(nearest, lines, crossing_reach);
            INFO("turn " << turn << ", " << lines.size() << " lines, sense " << static_cast<int>(sense));
            REQUIRE(stitched(repair, lines, {reach, crossing_reach, sense}) == expected);
            joined[static_cast<int>(sense)] += expected.size();
            left_open += nearest.size() - expected.size();
        }
    }
    CHECK(joined[0] > 20'000);
    CHECK(joined[1] > joined[0]);
    CHECK(left_open > 5'000);
}

TEST_CASE("closing gaps takes memory in proportion to the ends, not to their pairs", "[engine][gaps]") {
    std::mt19937 random(23);
    constexpr std::size_t count = 20'000;
    CountingMemory memory;
    Worker worker(&memory);
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
        const Soup walls = random_walls(random);
        SliceOptions options = at_heights({5});
        const SliceResult open = sliced(walls, options);
        options.stitch_mm = 100 + static_cast<double>(random() % 2000);
        options.stitch_direction = StitchDirection::any;
        const SliceResult result = sliced(walls, options);  // of which the audit finds that no segment is lost
        Edges before;
        for (const Contour& contour : open.contours) {
            before.merge(edges_of(open[0], contour));
        }
        std::size_t others = 0;
        for (const Contour& contour : result.contours) {
            std::size_t forwards = 0;
            std::size_t backwards = 0;
            for (const auto& [from, to] : edges_of(result[0], contour)) {
                const bool kept = before.count({from, to}) != 0;
                const bool turned = before.count({to, from}) != 0;
                forwards += kept;
                backwards += turned;
                others += !kept && !turned;
            }
            if ((contour.flags & orientation_overruled) != 0 && (contour.orientation > 0) != (contour.role == Role::outer)) {
                std::swap(forwards, backwards);  // turned round once more, as its role demands
            }
            REQUIRE(forwards >= backwards);
            REQUIRE(contour.segments == forwards + backwards);
            REQUIRE(((contour.flags & orientation_mixed) != 0) == (backwards != 0));
            mixed += backwards != 0;
        }
        REQUIRE(others == result.stitches.size());
    }
    CHECK(mixed > 500);
}

TEST_CASE("gaps up to the requested length are closed, and each is reported", "[engine][gaps]") {
    constexpr auto oriented = StitchDirection::oriented;
    constexpr auto any = StitchDirection::any;
    const Soup open = without(box({0, 0, 0}, {10, 10, 10}), 4, 2);
    const Soup alike = joined({wall({0, 0}, {20, 0}), wall({0, 10}, {20, 10})});  // run the same way
    const Soup agreeing = joined({wall({0, 0}, {10, 0}), wall({14, 0}, {24, 0}), wall({24, 8}, {0, 8})});
    const Texts left_open = {"open 0 x6 in -: 20,0 20,9 20,20 11,20 0,20 0,11 0,0"};
    const Texts apart = {"open 0 x2 in -: 0,0 18,0 40,0", "open 0 x2 in -: 0,20 18,20 40,20"};
    const Texts joined = {"outer + x6 in -: 0,0 9,0 20,0 28,0 37,0 48,0 48,16 26,16 0,16"};
    const std::tuple<Soup, double, StitchDirection, Texts, std::string> cases[] = {
        // a length, contours and stitches
        {open, 0, oriented, left_open, ""},
        {open, 9.9, oriented, left_open, ""},
        // The solid is on the left, so along the missing side the contour runs towards larger x.
        {open, 10, oriented, {"outer + x6 in -: 0,0 20,0 20,9 20,20 11,20 0,20 0,11"}, "0,0 20,0; "},
        {alike, 10, oriented, apart, ""},
        {alike, 9.9, any, apart, ""},
        {alike, 10, any, {"outer + x4 in - mixed: 0,0 18,0 40,0 40,20 18,20 0,20"}, "0,0 0,20; 40,0 40,20; "},
        {agreeing, 8, oriented, joined, "0,16 0,0; 20,0 28,0; 48,0 48,16; "},
        {agreeing, 8, any, joined, "0,16 0,0; 20,0 28,0; 48,0 48,16; "},
    };
    for (const auto& [soup, reach_mm, direction, contours, stitches] : cases) {
        INFO("case of " << reach_mm << " mm, any direction " << (direction == any));
        const SliceResult result = sliced(soup, {.heights_mm = {{5}},
                                                 .stitch_mm = reach_mm,
                                                 .stitch_direction = direction,
                                                 .frame = {.grid_mm = coarse_unit_mm}});
        CHECK(contours_at(result, 0) == contours);
        std::ostringstream text;
        for (const auto& [layer, from, to] : result.stitches) {
            text << from.x << ',' << from.y << ' ' << to.x << ',' << to.y << "; ";
        }
        CHECK(text.str() == stitches);
        CHECK(((result.contours[0].flags & lamella::stitched) != 0) == !stitches.empty());
        CHECK(result.info.options.stitch_direction == direction);
    }
}

TEST_CASE("a gap with a wall in it stays open by the mesh's length, and not by one that is given", "[engine][gaps]") {
    const Soup tube = joined({cracked_tube(), wall({500, -5}, {500, 5}), wall({500, 5}, {500, -5})});
    const SliceResult open = sliced(tube, stitched_by());
    CHECK(open.info.open_contours > 0);
    const SliceResult closed = sliced(tube, stitched_by(10));
    CHECK(std::any_of(closed.stitches.begin(), closed.stitches.end(),
                      [&](const Stitch& gap) { return length_mm(closed, gap) == 10; }));
    CHECK(std::none_of(open.stitches.begin(), open.stitches.end(),
                       [&](const Stitch& gap) { return length_mm(open, gap) == 10; }));
}

TEST_CASE("the length that closes what is left is no shorter than what was closed", "[engine][gaps][open_layers]") {
    const Soup walled = joined({wall({0, 2000}, {495, 2000}), wall({501, 2000}, {1000, 2000}), wall({1000, 2000}, {0, 2100}),
                                wall({0, 2100}, {0, 2000}), wall({498, 1990}, {498, 2010}), wall({498, 2010}, {498, 1990})});
    const SliceResult result = sliced(joined({cracked_tube(), walled}), stitched_by());
    const auto open = open_of(result);
    CHECK(open.layers == 2);
    CHECK(open.reach_mm == Approx(10));
}

TEST_CASE("the mesh's length is a hundredth of its box's diagonal, and that of each of several parts; it closes a crack",
          "[engine][gaps]") {
    const Soup tube = cracked_tube();
    const SliceResult whole = sliced(tube, stitched_by());
    CHECK(whole.info.options.stitch_mm == std::sqrt(1000.0 * 1000 + 1000 * 1000 + 10 * 10) / 100);
    CHECK(whole.info.open_contours == 0);
    REQUIRE(whole.stitches.size() == 2);
    CHECK(length_mm(whole, whole.stitches[0]) == 10);
    CHECK(whole[0].area_mm2() == 1e6);
    const Transform far{{1, 0, 0, 5000, 0, 1, 0, 0, 0, 0, 1, 0}};
    const std::vector<Part> parts = {{.mesh = view_of(tube)}, {.mesh = view_of(tube), .placement = far}};
    const SliceResult together = sliced(parts, stitched_by());
    CHECK(together.info.options.stitch_mm == whole.info.options.stitch_mm);
    CHECK(together.stitches.size() == 4);
    require_at_every_destination(together, parts, stitched_by());
}

TEST_CASE("open layers: their area is not known, and their share of the height is", "[engine][open_layers]") {
    const Soup closed = box({0, 0, 0}, {10, 20, 30});
    const Soup open = moved(without(closed, 10, 2), {0, 0, 30});
    const SliceResult result = sliced(joined({closed, open}), uniform(1));
    const OpenLayers found = open_of(result);
    CHECK(found.layers == 30);
    CHECK(found.crossed == 60);
    CHECK(found.share() == Approx(0.5));
    CHECK(result[3].area_mm2() == Approx(200));
    CHECK(std::isnan(result[40].area_mm2()));
    SliceOptions options = uniform(1);
    options.stitch_mm = found.reach_mm;
    const SliceResult joined = sliced(shapes::joined({closed, open}), options);
    CHECK(joined[40].area_mm2() == Approx(200));
    CHECK(open_of(joined).layers == 0);
}

TEST_CASE("open layers: the length closes all, and a little less does not", "[engine][open_layers]") {
    const Soup ball = octasphere({0, 0, 0}, 10, 3);
    Soup torn;
    for (std::size_t i = 0; i < ball.size() / 9; ++i) {  // but for every 13th triangle
        append(torn, i % 13 != 0 ? only(ball, i, 1) : Soup());
    }
    for (const StitchDirection sense : {StitchDirection::oriented, StitchDirection::any}) {
        SliceOptions options = uniform(0.3);
        options.stitch_direction = sense;
        const SliceResult result = sliced(torn, options);
        const OpenLayers found = open_of(result);
        REQUIRE(found.layers > 10);
        CHECK(open_of(result, 3).height_mm == found.height_mm);
        options.stitch_mm = found.reach_mm * 0.999;
        const OpenLayers left = open_of(sliced(torn, options));
        CHECK(left.layers > 0);
        CHECK(left.reach_mm == found.reach_mm);
        options.stitch_mm = found.reach_mm;
        CHECK(open_of(sliced(torn, options)).layers == 0);
    }
}

TEST_CASE("open layers: ends of two meshes are not joined", "[engine][open_layers]") {
    const Soup one = without(box({0, 0, 0}, {10, 10, 10}), 10, 2);
    const Soup other = moved(one, {1, 0, 0});
    const std::vector<Part> parts = {{.mesh = view_of(one)}, {.mesh = view_of(other)}};
    const SliceResult both = sliced(parts, uniform(1));
    CHECK(open_of(both).layers == 10);
    CHECK(open_of(both).reach_mm == open_of(sliced(one, uniform(1))).reach_mm);
}

TEST_CASE("open layers: the words name the length, rounded up to two digits", "[engine][open_layers]") {
    CHECK(describe({37, 412, 0, 8.1, 100, 0.7213}, "--stitch ") ==
          "37 of 412 layers (8.1 % of the height) have open contours: their area is not known; --stitch 0.73 would "
          "close them");
    CHECK(describe({1, 1, 0, 1, 1, 20}, "stitch=") ==
          "1 of 1 layer (100 % of the height) has open contours: its area is not known; stitch=20 would close it");
    CHECK(describe({2, 9, 1, 0, 9, 0.00034001}, "")
              .ends_with("(less than 0.1 % of the height) have open contours: their "
                         "area is not known; 0.00035 would close all but 1"));
    CHECK(describe({2, 9, 2, 0, 0, 1231}, "--stitch ").ends_with("no length of --stitch would close them"));
    CHECK(describe({2, 9, 0, 1, 2, 1231}, "").ends_with("; 1300 would close them"));
}

}  // namespace
