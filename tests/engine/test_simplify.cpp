// Simplified contours keep what RegionRules::simplify_mm promises, by plain methods: how far they lie from what they
// replace, whether edges meet that did not, what lies in what, and where edges come from. Few steps are taken where contours
// are made to need many.
#include "cpu_time.hpp"
#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "slicing/simplify/simplifier.hpp"

using namespace lamella;
using namespace polygons;
using rings::Int128;

namespace {

using polygons::Ring;

/// A contour before, and what is left of it: indices of its points, from the start on.
struct Simplified {
    std::span<const Point> points;
    std::vector<std::size_t> left;
    bool closed = true;

    std::size_t edges() const { return left.size() - (closed ? 0 : 1); }
    std::size_t end_of(std::size_t edge) const { return edge + 1 < left.size() ? left[edge + 1] : points.size(); }
    bool is_line(std::size_t edge) const { return end_of(edge) - left[edge] > 1; }
    std::pair<Point, Point> operator[](std::size_t edge) const {
        return {points[left[edge]], points[end_of(edge) % points.size()]};
    }
};

/// The same points in the same order, from the same start. A contour must pass each point once.
Simplified match(std::span<const Point> before, std::span<const Point> after, bool closed) {
    Simplified contour{before, {}, closed};
    std::size_t next = 0;
    for (const Point p : after) {
        while (next < before.size() && before[next] != p) {
            ++next;
        }
        REQUIRE(next < before.size());
        contour.left.push_back(next++);
    }
    REQUIRE(contour.left.front() == 0);
    REQUIRE((closed || contour.left.back() + 1 == before.size()));
    CHECK((!closed || after.size() >= std::min<std::size_t>(3, before.size())));
    return contour;
}

Int128 dot(Point a, Point b, Point p) {
    return (Int128{b.x} - a.x) * (Int128{p.x} - a.x) + (Int128{b.y} - a.y) * (Int128{p.y} - a.y);
}

/// Exact for short lines, whose squares long double holds; `slack` is for the rounding of others.
bool is_within(Point p, std::pair<Point, Point> line, long double tolerance, long double slack = 1.0000001L) {
    const auto [a, b] = line;
    const Int128 along = dot(a, b, p);
    const Int128 length2 = dot(a, b, b);
    const bool beside = along > 0 && along < length2;
    const Point end = along <= 0 ? a : b;
    const auto distance = static_cast<long double>(beside ? rings::cross(a, b, p) : dot(end, p, p));
    const long double most2 = tolerance * tolerance * slack;
    return beside ? distance * distance <= most2 * static_cast<long double>(length2) : distance <= most2;
}

std::size_t points_beyond(const Simplified& contour, double tolerance) {
    std::size_t beyond = 0;
    for (std::size_t e = 0; e < contour.edges(); ++e) {
        for (std::size_t i = contour.left[e] + 1; i < contour.end_of(e); ++i) {
            beyond += !is_within(contour.points[i], contour[e], tolerance);
        }
    }
    return beyond;
}

/// True if two edges have a point in common other than a joint.
bool meet(const Simplified& one, std::size_t e, const Simplified& other, std::size_t f) {
    const auto [a, b] = one[e];
    const auto [c, d] = other[f];
    if (&one != &other) {
        return rings::meet(a, b, c, d);
    }
    const std::size_t last = one.edges() - 1;
    if (f == e + 1 || (one.closed && e == last && f == 0)) {
        return rings::lies_on(a, b, d) || rings::lies_on(c, d, a);
    }
    if (e == f + 1 || (one.closed && f == last && e == 0)) {
        return rings::lies_on(a, b, c) || rings::lies_on(c, d, b);
    }
    return e != f && rings::meet(a, b, c, d);
}

/// Pairs of edges that meet, one of them a line that replaces points.
std::size_t meeting_lines(const std::vector<Simplified>& contours) {
    std::size_t found = 0;
    for (const Simplified& one : contours) {
        for (std::size_t e = 0; e < one.edges(); ++e) {
            for (const Simplified& other : contours) {
                for (std::size_t f = 0; one.is_line(e) && f < other.edges(); ++f) {
                    found += meet(one, e, other, f);
                }
            }
        }
    }
    return found;
}

/// Counts pairs of a closed contour and another one whose start is no longer on the same side of it.
std::size_t starts_that_changed_sides(const std::vector<Simplified>& contours) {
    std::size_t moved = 0;
    for (const Simplified& around : contours) {
        Ring left;
        for (const std::size_t i : around.left) {
            left.push_back(around.points[i]);
        }
        for (const Simplified& other : contours) {
            const Point start = other.points.front();
            moved +=
                &other != &around && around.closed && rings::winding(around.points, start) != rings::winding(left, start);
        }
    }
    return moved;
}

/// Lines that replace points come from no triangle, nor does the end of a polyline after one; all other edges keep their
/// triangles.
void check_origins(const Simplified& contour, std::span<const PointOrigin> before, std::span<const PointOrigin> after) {
    for (std::size_t i = 0; i < after.size(); ++i) {
        const std::size_t edge = std::min(i, contour.edges() - 1);
        REQUIRE(after[i] == (contour.is_line(edge) ? PointOrigin() : before[contour.left[i]]));
    }
}

/// Counts of what was compared.
struct Comparison {
    std::size_t points_before = 0;
    std::size_t points_after = 0;
    std::size_t lines = 0;
    std::size_t recounted = 0;  ///< contours with other segments
};

/// Checks all promises of simplification, and adds to the counts.
void compare(const LayerView& before, const LayerView& after, double tolerance, FillRule rule, Comparison& found) {
    REQUIRE(before.contours.size() == after.contours.size());
    std::vector<Simplified> contours;
    found.points_before += before.points.size();
    found.points_after += after.points.size();
    for (std::size_t c = 0; c < before.contours.size(); ++c) {
        const Contour& old_one = before.contours[c];
        const Contour& new_one = after.contours[c];
        CHECK(old_one.role == new_one.role);
        // Where contours cross, which of those around is the smallest may change.
        CHECK((old_one.parent == new_one.parent || rule == FillRule::contours));
        CHECK(old_one.orientation == new_one.orientation);
        CHECK(old_one.flags == new_one.flags);
        CHECK((old_one.twice_area.high < 0) == (new_one.twice_area.high < 0));
        const Simplified& contour =
            contours.emplace_back(match(before.points_of(old_one), after.points_of(new_one), old_one.role != Role::open));
        CHECK(points_beyond(contour, tolerance) == 0);
        for (std::size_t e = 0; e < contour.edges(); ++e) {
            found.lines += contour.is_line(e);
        }
        if (!before.origins.empty()) {
            check_origins(contour, before.origins_of(old_one), after.origins_of(new_one));
        }
        found.recounted += new_one.segments != old_one.segments;
        CHECK((new_one.segments == old_one.segments || (contour.closed && new_one.segments == new_one.point_count)));
    }
    CHECK(meeting_lines(contours) == 0);
    CHECK(starts_that_changed_sides(contours) == 0);
}

/// Without simplification where `units` is 0.
SliceResult region_by(const Rings& rings, double units, FillRule rule = FillRule::contours) {
    const double tolerance_mm = units == 0 ? 0 : (units + 0.5) * default_grid_mm;
    return value_of(regions::region(rings, {.fill_rule = rule, .simplify_mm = tolerance_mm}));
}

/// Simplifies, compares with the plain region, and again from other starts and in another order of contours.
Comparison simplify(const Rings& rings, double units, FillRule rule = FillRule::contours) {
    const SliceResult after = region_by(rings, units, rule);
    CHECK(regions::same(after, region_by(regions::shuffled(rings, 5), units, rule)));
    Comparison found;
    compare(region_by(rings, 0, rule)[0], after[0], units, rule, found);
    CHECK((rule == FillRule::contours || regions::broken_promise(after) == ""));
    return found;
}

/// Around a centre, wavy and rough; passes each point once.
Ring wavy(std::mt19937& random, Point centre, double radius, int count, double wave, double rough) {
    const double turns = 3 + below(random, 9);
    Ring ring;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count;
        const double r = radius + wave * std::sin(turns * angle) + rough * between(random, -1, 1);
        const Point p = at_angle(centre, r, angle);
        if (std::find(ring.begin(), ring.end(), p) == ring.end()) {
            ring.push_back(p);
        }
    }
    return ring;
}

/// Two balls that overlap, rough by up to 0.05 mm, and a third one that lacks its upper side.
shapes::Soup rough_balls() {
    shapes::Soup soup = shapes::joined({shapes::octasphere({0, 0, 0}, 10, 5), shapes::octasphere({6, 1, 1}, 8, 5)});
    for (double& number : soup) {  // by the place, so that equal corners stay equal
        number += 0.05 * std::sin(number * 7919);
    }
    const shapes::Soup open = shapes::octasphere({20, 0, 0}, 5, 4);
    shapes::append(soup, shapes::only(open, 0, open.size() / 9 * 7 / 10));
    return soup;
}

SliceOptions simplified(double tolerance_mm, FillRule rule) {
    return {.layer_height_mm = 1.4, .origins = true, .region = {.fill_rule = rule, .simplify_mm = tolerance_mm}};
}

/// Teeth side by side below y = 0, and between each two of them a small contour.
Rings comb(int teeth) {
    Rings rings(1);
    for (int i = 0; i < teeth; ++i) {
        rings[0].insert(rings[0].end(), {{20 * i, 0}, {20 * i + 2, -50}, {20 * i + 4, 0}});
        rings.push_back({{20 * i + 10, -30}, {20 * i + 13, -30}, {20 * i + 13, -26}, {20 * i + 11, -25}});
    }
    rings[0].insert(rings[0].end(), {{20 * teeth, 0}, {20 * teeth, 9000}, {0, 9000}});
    return rings;
}

/// Needles across each other, as many one way as the other. The point in the middle of each one's tip could go.
Rings crossing_needles(int count) {
    Rings rings;
    const std::int32_t length = 100 * count;
    for (int i = 0; i < count; ++i) {
        const std::int32_t at = 100 * i + 50;
        rings.push_back({{-10, at}, {length, at}, {length - 1, at + 5}, {length, at + 10}, {-10, at + 10}});
        rings.push_back({{at, -10}, {at + 10, -10}, {at + 10, length}, {at + 5, length - 1}, {at, length}});
    }
    return rings;
}

TEST_CASE("contours close to one another, in crowds, and across one another keep every promise", "[engine][simplify]") {
    std::mt19937 random(5);
    const FillRule rules[] = {FillRule::contours, FillRule::non_zero, FillRule::even_odd};
    std::size_t fewer[3] = {0, 0, 0};
    for (unsigned turn = 0; turn < 120; ++turn) {
        const unsigned kind = turn % 3;
        Rings rings;
        const double apart = 50 + below(random, 400);
        for (int i = 0; i < 6 && kind == 0; ++i) {
            std::mt19937 wave(turn);  // the same with every ring, so that neighbours stay apart
            rings.push_back(wavy(wave, {3, 4}, 4000 + apart * i, 160, 900, apart / 3));
        }
        for (int i = 0; i < 5 && kind == 1; ++i) {
            rings.push_back(wavy(random, {below(random, 40), below(random, 40)}, 60, 90, 15, turn % 2 == 0 ? 30 : 3));
        }
        if (kind == 2) {  // under a tolerance larger than they are
            rings.push_back(wavy(random, {0, 0}, 3000, 300, 200, 60));
            for (int i = 0; i < 80; ++i) {
                rings.push_back(wavy(random, {below(random, 8000) - 4000, below(random, 8000) - 4000}, 60, 12, 20, 10));
            }
        }
        for (std::size_t i = 0; i < rings.size(); i += 2) {
            rings[i] = kind == 1 ? rings[i] : reversed(rings[i]);
        }
        const std::int32_t most[] = {1500, 12, 3000};
        const Comparison sizes = simplify(rings, 1 + below(random, most[kind]), kind == 2 ? rules[turn / 3 % 3] : rules[0]);
        fewer[kind] += sizes.points_after < sizes.points_before;
    }
    CHECK(std::min({fewer[0], fewer[1], fewer[2]}) > 20);
}

TEST_CASE("contours thinner than the tolerance keep their orientation", "[engine][simplify]") {
    std::mt19937 random(16);
    for (int round = 0; round < 100; ++round) {
        // There on a bent path, and back beside it.
        Ring thin;
        Point at{0, 0};
        Point step{below(random, 13) - 6, below(random, 13) - 6};
        for (int i = 0; i < 10; ++i) {
            thin.push_back(at);
            step = {step.x + below(random, 9) - 4, step.y + below(random, 9) - 4};
            at = {at.x + step.x, at.y + step.y};
        }
        for (std::size_t i = 10; i-- > 0;) {
            thin.push_back({thin[i].x + below(random, 4), thin[i].y + below(random, 4)});
        }
        simplify({thin}, 1 + below(random, 30), round % 2 == 0 ? FillRule::contours : FillRule::non_zero);
    }
}

TEST_CASE("contours as wide as the grid are simplified exactly, and a circle to about as many points as are needed",
          "[engine][simplify]") {
    const double needed = std::numbers::pi / std::acos(1 - 1000 / 1e6);  // of chords with a sagitta of the tolerance
    const auto left = static_cast<double>(simplify({round({0, 0}, 1e6, 5000)}, 1000).points_after);
    CHECK((left >= needed && left <= 2 * needed));
    constexpr std::int32_t far = grid_limit;
    const Ring square = {{-far, -far}, {0, -far + 1000}, {far, -far}, {far - 1000, 0},
                         {far, far},   {5, far - 1001},  {-far, far}};
    CHECK(simplify({square}, 1000).points_after == 5);
    CHECK(simplify({square}, 1001).points_after == 4);
    CHECK(simplify({square}, 999).points_after == 7);
}

TEST_CASE("slices are simplified as promised, and their edges keep their triangles, on any number of threads",
          "[engine][simplify][origins]") {
    const shapes::Soup inside_out = shapes::flipped(shapes::octasphere({0, 0, 0}, 10, 5));
    for (const shapes::Soup& soup : {rough_balls(), inside_out}) {
        for (const FillRule rule : {FillRule::contours, FillRule::non_zero, FillRule::even_odd}) {
            const SliceResult plain = sliced(soup, simplified(0, rule));
            CHECK((plain.info.open_contours > 0 || plain.info.overruled_contours > 0 || rule != FillRule::contours));
            Comparison all;
            for (const double tolerance : {0.001, 0.05, 0.5}) {
                SliceOptions options = simplified(tolerance, rule);
                const SliceResult result = sliced(soup, options);
                require_ok(audits::structure_of(result, view_of(soup)));
                for (std::size_t l = 0; l < plain.size(); ++l) {
                    compare(plain[l], result[l], std::floor(tolerance / plain.info.grid_mm), rule, all);
                }
                CHECK(result.points.size() < plain.points.size());
                options.origins = false;
                for (const int threads : {1, 2, 3}) {
                    CHECK(sliced(soup, options, {.threads = threads}).hash() == result.hash());
                }
            }
            CHECK(all.lines > 100);
            CHECK((all.recounted > 10) == (soup != inside_out && rule != FillRule::contours));
        }
    }
}

TEST_CASE("simplifying takes no square of time where a furthest point peels off one, nor where lines pass many contours",
          "[engine][simplify]") {
    constexpr int count = 300'000;
    Ring peeled;
    for (int i = 0; i < count; ++i) {
        peeled.push_back({i, (i % 2 == 0 ? 1 : -1) * (count - i)});
    }
    peeled.insert(peeled.end(), {{count, -2 * count}, {-5, -2 * count}});
    CHECK(simplify(comb(30), 100).points_after < 250);
    const double before = cpu_ms();
    CHECK(region_by({peeled}, 1).points.size() > count / 2);
    CHECK(region_by(comb(100'000), 100).contours[0].point_count < 50'000);
    CHECK(cpu_ms() - before < 6000);
}

TEST_CASE("layers of which far more edges cross than there are points stay whole", "[engine][simplify]") {
    CHECK(region_by(crossing_needles(10), 3).points.size() == 80);
    CHECK(region_by(crossing_needles(4000), 3).points.size() == 40'000);
}

}  // namespace
