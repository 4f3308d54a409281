// Raw offset curves. Of few corners: points, facts and winding numbers are written down. Of random polygons: against
// rectangles and wedges one by one.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/polygons.hpp"
#include "rings.hpp"
#include "slicing/offset/raw_offset.hpp"

using lamella::RawCurve;
using lamella::RawOffset;
using polygons::between;
using polygons::Point;
using polygons::ragged;
using polygons::reversed;
using polygons::Ring;
using polygons::rounded;

namespace {

using Place = rings::PlaceOf<double>;

struct Curve {
    RawCurve facts;
    Ring points;
};

Curve offset_of(const Ring& ring, double distance, double miter_limit = 3) {
    RawOffset offset(nullptr);
    const RawCurve facts = offset.append(ring, distance, miter_limit);
    const auto points = offset.points_of(facts);
    return {facts, {points.begin(), points.end()}};
}

double distance_to(const Ring& ring, Place p) {
    double nearest = 1e300;
    rings::each_edge(ring, [&](Point a, Point b) {
        const double dx = double(b.x) - a.x;
        const double dy = double(b.y) - a.y;
        const double along = std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
        nearest = std::min(nearest, std::hypot(a.x + along * dx - p.x, a.y + along * dy - p.y));
    });
    return nearest;
}

int winding(const Ring& ring, Place p) {
    return rings::winding(ring, p).value_or(0);
}

/// No two edges have a point in common but for joints.
bool is_simple(const Ring& ring) {
    const std::size_t count = ring.size();
    const auto at = [&](std::size_t i) { return ring[i % count]; };
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = i + 1; j < count; ++j) {
            const bool joined = j == i + 1 || j + 1 == i + count;
            if (at(i) == at(j) || (!joined && rings::meet(at(i), at(i + 1), at(j), at(j + 1)))) {
                return false;
            }
        }
    }
    return true;
}

/// Simple, of either orientation: a star, one with its corners on a lattice of 9 x 9, or a ragged slab.
Ring simple_ring(std::mt19937& random, double size) {
    for (;;) {
        const std::uint32_t kind = random() % 3;
        Ring ring = kind == 2 ? ragged(random, size) : polygons::star(random, 3 + random() % 12, 0.2 * size, size);
        for (Point& p : ring) {
            const double step = kind == 1 ? size / 4 : 1;
            p = {rounded(step * std::round(p.x / step)), rounded(step * std::round(p.y / step))};
        }
        if (is_simple(ring)) {
            return random() % 2 == 0 ? ring : reversed(ring);
        }
    }
}

const Ring square{{0, 0}, {4000, 0}, {4000, 4000}, {0, 4000}};
/// 8 wide and 6 high, with a notch 3 wide and 1 deep in its upper side (in thousands).
const Ring notched{{0, 0}, {8000, 0}, {8000, 6000}, {6000, 6000}, {6000, 5000}, {3000, 5000}, {3000, 6000}, {0, 6000}};

/// The sum that the curve has to be if every inner corner has the joint, from rectangles and wedges one by one.
class Sum {
public:
    Sum(const Ring& ring, double distance, double limit) : ring_(ring), sign_(distance > 0 ? 1 : -1) {
        const std::size_t count = ring.size();
        for (std::size_t i = 0; i < count; ++i) {
            const Point a = ring[i];
            const Point v = ring[(i + 1) % count];
            const Point b = ring[(i + 2) % count];
            const Place u1 = unit(a, v);
            const Place u2 = unit(v, b);
            const Place n1{distance * u1.y, -distance * u1.x};
            const Place n2{distance * u2.y, -distance * u2.x};
            convex_.push_back({at(a), {a.x + n1.x, a.y + n1.y}, {v.x + n1.x, v.y + n1.y}, at(v)});
            if (rings::side(a, v, b) * distance >= 0) {
                std::vector<Place> wedge{at(v), {v.x + n1.x, v.y + n1.y}};
                add_tip(wedge, v, u1, u2, n1, n2, distance, limit);
                wedge.push_back({v.x + n2.x, v.y + n2.y});
                convex_.push_back(wedge);
            }
        }
    }
    /// How many rectangles and wedges cover p, subtracted where they erode, and the contour's own winding number.
    int at_place(Place p) const {
        int sum = winding(ring_, p);
        for (const auto& part : convex_) {
            sum += covers(part, p) ? sign_ : 0;
        }
        return sum;
    }

private:
    static Place at(Point p) { return {double(p.x), double(p.y)}; }
    static Place unit(Point a, Point b) {
        const double length = std::hypot(double(b.x) - a.x, double(b.y) - a.y);
        return {(double(b.x) - a.x) / length, (double(b.y) - a.y) / length};
    }
    /// The miter, or the two points of the cut, from the angle itself.
    static void add_tip(std::vector<Place>& wedge, Point v, Place u1, Place u2, Place n1, Place n2, double distance,
                        double limit) {
        const double half = 0.5 * std::abs(std::atan2(u1.x * u2.y - u1.y * u2.x, u1.x * u2.x + u1.y * u2.y));
        if (1 <= limit * std::cos(half)) {
            const double far = 1 / (2 * std::cos(half) * std::cos(half));
            wedge.push_back({v.x + far * (n1.x + n2.x), v.y + far * (n1.y + n2.y)});
            return;
        }
        const double on = std::abs(distance) * std::tan(half / 2);
        wedge.push_back({v.x + n1.x + on * u1.x, v.y + n1.y + on * u1.y});
        wedge.push_back({v.x + n2.x - on * u2.x, v.y + n2.y - on * u2.y});
    }
    bool covers(const std::vector<Place>& part, Place p) const {
        for (std::size_t i = 0; i < part.size(); ++i) {
            const Place a = part[i];
            const Place b = part[(i + 1) % part.size()];
            if (sign_ * ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) < 0) {
                return false;
            }
        }
        return true;
    }

    const Ring& ring_;
    int sign_;
    std::vector<std::vector<Place>> convex_;
};

/// A place anywhere around the ring, or near a point of the curve.
Place sample(std::mt19937& random, const Curve& curve, double size, double distance) {
    if (curve.points.empty() || random() % 4 == 0) {
        return {between(random, -2 * size, 2 * size), between(random, -2 * size, 2 * size)};
    }
    const Point near = curve.points[random() % curve.points.size()];
    const double reach = std::abs(distance) * std::pow(10, between(random, -2, 0.3));
    return {near.x + between(random, -reach, reach), near.y + between(random, -reach, reach)};
}

}  // namespace

TEST_CASE("a notch whose floor turns round gets joints", "[engine][raw_offset]") {
    const Curve filled = offset_of(notched, 2000);
    CHECK_FALSE(filled.facts.directions_kept);
    CHECK(filled.points == Ring{{-2000, -2000},
                                {10000, -2000},
                                {10000, 8000},
                                {4000, 8000},
                                {4000, 5000},
                                {6000, 5000},
                                {6000, 7000},
                                {3000, 7000},
                                {3000, 5000},
                                {5000, 5000},
                                {5000, 8000},
                                {-2000, 8000}});
}

TEST_CASE("a curve that rounding closes to a line has no points", "[engine][raw_offset]") {
    const Ring sliver{{0, 0}, {1000000, 0}, {1000000, 4}, {0, 4}};
    const Curve curve = offset_of(sliver, -1.8);
    CHECK(curve.facts.directions_kept);  // 0.4 units are left, which round to 0
    CHECK(curve.facts.count == 0);
}

TEST_CASE("a corner beyond the miter limit is cut at the distance", "[engine][raw_offset]") {
    const Ring needle{{0, -200}, {100000, 0}, {0, 200}};
    const Curve out = offset_of(needle, 1000);
    CHECK(out.points.size() == 4);
    CHECK(out.points[1].x == 101000);
    CHECK(out.points[2].x == 101000);
    CHECK(out.points[1].y == -out.points[2].y);
    CHECK(out.points[1].y == -998);  // the line 1000 below the edge, at x = 101000
    CHECK(out.facts.directions_kept);
    CHECK_FALSE(out.facts.reflex_cut);
    CHECK(offset_of(needle, 1000, 1000).points[1] == Point{600001, 0});  // 1000 / sin 2 mrad
    // As a hole it is the way back that cuts.
    const Curve hole = offset_of(reversed(needle), 10);
    CHECK(hole.facts.reflex_cut);
    CHECK(hole.facts.directions_kept);
    CHECK_FALSE(offset_of(reversed(needle), 10, 1000).facts.reflex_cut);
}

TEST_CASE("a right-angled corner is cut from a limit of the square root of two down", "[engine][raw_offset]") {
    CHECK(offset_of(square, 1000, 1.4143).points.size() == 4);
    CHECK(offset_of(square, 1000, 1.4142).points.size() == 8);
    CHECK_FALSE(offset_of(square, -1000, 1.4143).facts.reflex_cut);
    CHECK(offset_of(square, -1000, 1.4142).facts.reflex_cut);
}

TEST_CASE("a spike has a cap for either sign", "[engine][raw_offset]") {
    const Ring spiked{{0, 0}, {4000, 0}, {4000, 2000}, {9000, 2000}, {4000, 2000}, {4000, 4000}, {0, 4000}};
    const Curve out = offset_of(spiked, 500);
    CHECK(std::count(out.points.begin(), out.points.end(), Point{9500, 1500}) == 1);
    CHECK(std::count(out.points.begin(), out.points.end(), Point{9500, 2500}) == 1);
    CHECK(winding(out.points, {9400, 2000}) == 1);
    const Curve in = offset_of(spiked, -500);
    CHECK(winding(in.points, {6000, 2000}) < 0);
    CHECK(winding(in.points, {2000, 2000}) == 1);
}

TEST_CASE("turns of nearly 180 degrees take their side from the points", "[engine][raw_offset]") {
    // Fibonacci numbers: the triangle's doubled area is 1, its longest edges differ in direction by 2e-18.
    const Ring thin{{0, 0}, {701408733, 433494437}, {267914296, 165580141}};
    for (const double distance : {1000.0, -1000.0}) {
        const Curve curve = offset_of(thin, distance);
        CHECK(curve.facts.reflex_cut == (distance < 0));
        CHECK(curve.facts.directions_kept == (distance > 0));
        CHECK(offset_of(reversed(thin), distance).facts.reflex_cut == (distance > 0));
    }
}

TEST_CASE("points beyond the grid are reported", "[engine][raw_offset]") {
    const std::int32_t far = lamella::grid_limit;
    const Ring large{{-far, -far}, {far, -far}, {far, far}, {-far, far}};
    CHECK(offset_of(large, 0.6).facts.beyond_grid);
    CHECK(offset_of(large, 2.0 * far).facts.beyond_grid);
    CHECK_FALSE(offset_of(large, -0.6).facts.beyond_grid);
    CHECK(offset_of({{-far, 0}, {0, -100}, {0, 100}}, 1).facts.beyond_grid);
    CHECK(offset_of({{far, 0}, {0, 100}, {0, -100}}, 1).facts.beyond_grid);
    CHECK_FALSE(offset_of(large, 0.4).facts.beyond_grid);
    CHECK_FALSE(offset_of(large, -1.0 * far + 10).facts.beyond_grid);
    CHECK(offset_of(large, -2.5 * far).facts.beyond_grid);
}

TEST_CASE("curves of a layer stand one after the other, in the host's memory", "[engine][raw_offset]") {
    CountingMemory memory;
    RawOffset offset(&memory);
    const RawCurve first = offset.append(notched, 2000, 3);
    CHECK(memory.held() > 12 * sizeof(Point));
    const RawCurve second = offset.append(square, 1000, 3);
    CHECK(first.first_point == 0);
    CHECK(first.count == 12);
    CHECK(second.first_point == 12);
    CHECK(offset.points().size() == 16);
    CHECK(offset.points_of(second)[0] == Point{-1000, -1000});
    offset.clear();
    CHECK(offset.append(square, 1000, 3).first_point == 0);
    CHECK(offset.points().size() == 4);
}

TEST_CASE("all forms of the offset's kernels agree with the portable form", "[engine][raw_offset][kernels]") {
    std::mt19937 random(4);
    struct Measured {
        explicit Measured(std::size_t count) : numbers(5 * (count + 1)), miters(count) {}
        std::vector<double> numbers;
        Ring miters;
        double least = 0;
    };
    const auto measured = [](const lamella::OffsetKernels& form, const Ring& ring, double distance) {
        const std::size_t each = ring.size() + 1;
        Measured result(ring.size());
        double* const at = result.numbers.data();
        const lamella::OffsetEdges edges{at, at + each, at + 2 * each};
        form.edges(ring.data(), ring.size(), edges);
        result.least =
            form.corners(ring.data(), ring.size(), edges, distance, {at + 3 * each, at + 4 * each, result.miters.data()});
        return result;
    };
    for (const auto& [needs, form] : lamella::supported(lamella::offset_kernel_forms())) {
        for (int round = 0; round < 300; ++round) {
            const double size = round % 2 == 0 ? 1e3 : 1e8;
            const Ring ring = simple_ring(random, size);
            const double distance = between(random, -2, 2) * size;
            const Measured result = measured(form, ring, distance);
            const Measured expected = measured(lamella::portable_of(lamella::offset_kernel_forms()), ring, distance);
            CHECK(result.numbers == expected.numbers);
            CHECK(result.miters == expected.miters);
            CHECK(result.least == expected.least);
        }
    }
}

TEST_CASE("the positive region of a curve is solid, rectangles and wedges", "[engine][raw_offset]") {
    const double size = 1e6;
    std::mt19937 random(1);
    int mixed = 0;
    int inside = 0;
    for (int round = 0; round < 400; ++round) {
        const Ring ring = simple_ring(random, size);
        const double distance = between(random, 0.005, 0.3) * (random() % 2 == 0 ? size : -size);
        const double limit = between(random, 1.5, 4);
        const Curve curve = offset_of(ring, distance, limit);
        const Sum sum(ring, distance, limit);
        const int around = rings::twice_area(ring) > 0 ? 0 : 1;  // what a hole lies in
        mixed += !curve.facts.directions_kept && curve.points.size() < 2 * ring.size() ? 1 : 0;
        for (int i = 0; i < 60; ++i) {
            const Place p = sample(random, curve, size, distance);
            if (curve.points.empty() || distance_to(curve.points, p) < 3 || distance_to(ring, p) < 3) {
                continue;
            }
            const bool positive = winding(curve.points, p) + around > 0;
            inside += positive ? 1 : 0;
            INFO("round " << round << ", distance " << distance << ", limit " << limit << ", " << p.x << ' ' << p.y);
            REQUIRE(positive == (sum.at_place(p) + around > 0));
        }
    }
    CHECK(mixed > 100);
    CHECK(inside > 5000);
}
