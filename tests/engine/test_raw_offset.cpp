// Raw offset curves of few corners: points, facts and winding numbers are written down.
#include <algorithm>
#include <cstdint>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/raw_offsets.hpp"

using raw_offsets::Curve;
using raw_offsets::offset_of;
using raw_offsets::Point;
using raw_offsets::RawCurve;
using raw_offsets::RawOffset;
using raw_offsets::reversed;
using raw_offsets::Ring;
using raw_offsets::winding;

namespace {

const Ring square{{0, 0}, {4000, 0}, {4000, 4000}, {0, 4000}};
/// 8 wide and 6 high, with a notch 3 wide and 1 deep in its upper side (in thousands).
const Ring notched{{0, 0}, {8000, 0}, {8000, 6000}, {6000, 6000}, {6000, 5000}, {3000, 5000}, {3000, 6000}, {0, 6000}};

}  // namespace

TEST_CASE("an offset square has its corners on the miters", "[engine][raw_offset]") {
    const Curve out = offset_of(square, 1000);
    CHECK(out.points == Ring{{-1000, -1000}, {5000, -1000}, {5000, 5000}, {-1000, 5000}});
    CHECK(out.facts.directions_kept);
    CHECK_FALSE(out.facts.reflex_cut);
    CHECK_FALSE(out.facts.beyond_grid);
    const Curve in = offset_of(square, -1000);
    CHECK(in.points == Ring{{1000, 1000}, {3000, 1000}, {3000, 3000}, {1000, 3000}});
    CHECK(in.facts.directions_kept);
    CHECK(offset_of(reversed(square), -1000).points == reversed(out.points));
    CHECK(offset_of(reversed(square), 1000).points == reversed(in.points));
}

TEST_CASE("both kinds of corners of an L move along their bisectors", "[engine][raw_offset]") {
    const Ring ell{{0, 0}, {6000, 0}, {6000, 2000}, {2000, 2000}, {2000, 6000}, {0, 6000}};
    const Curve out = offset_of(ell, 500);
    CHECK(out.points == Ring{{-500, -500}, {6500, -500}, {6500, 2500}, {2500, 2500}, {2500, 6500}, {-500, 6500}});
    CHECK(out.facts.directions_kept);
    const Curve in = offset_of(ell, -500);
    CHECK(in.points == Ring{{500, 500}, {5500, 500}, {5500, 1500}, {1500, 1500}, {1500, 5500}, {500, 5500}});
    CHECK(in.facts.directions_kept);
}

TEST_CASE("a notch whose floor turns round gets joints and is filled", "[engine][raw_offset]") {
    const Curve out = offset_of(notched, 2000);
    CHECK_FALSE(out.facts.directions_kept);
    CHECK_FALSE(out.facts.reflex_cut);
    CHECK(out.points == Ring{{-2000, -2000},
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
    CHECK(winding(out.points, {4500, 5500}) == 3);  // two walls and the floor
    CHECK(winding(out.points, {3500, 5500}) == 2);  // one wall and the floor
    CHECK(winding(out.points, {4500, 7500}) == 2);  // two walls' miters
    CHECK(winding(out.points, {4500, 8100}) == 0);
    const Curve little = offset_of(notched, 1000);
    CHECK(little.facts.directions_kept);
    CHECK(little.points == Ring{{-1000, -1000},
                                {9000, -1000},
                                {9000, 7000},
                                {5000, 7000},
                                {5000, 6000},
                                {4000, 6000},
                                {4000, 7000},
                                {-1000, 7000}});
}

TEST_CASE("a square shrunk by more than half has no positive winding number", "[engine][raw_offset]") {
    const Curve gone = offset_of(square, -3000);
    CHECK_FALSE(gone.facts.directions_kept);
    CHECK(gone.points.size() == 12);
    int least = 0;
    for (double x = -4050; x < 8000; x += 100) {
        for (double y = -4050; y < 8000; y += 100) {
            const int number = winding(gone.points, {x, y});
            REQUIRE(number <= 0);
            least = std::min(least, number);
        }
    }
    CHECK(least == -3);  // solid, under all four rectangles
    CHECK(offset_of(square, -2000).facts.directions_kept == false);
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

TEST_CASE("a spike has a cap for either sign, and points inside edges stay", "[engine][raw_offset]") {
    const Ring spiked{{0, 0}, {4000, 0}, {4000, 2000}, {9000, 2000}, {4000, 2000}, {4000, 4000}, {0, 4000}};
    const Curve out = offset_of(spiked, 500);
    CHECK(std::count(out.points.begin(), out.points.end(), Point{9500, 1500}) == 1);
    CHECK(std::count(out.points.begin(), out.points.end(), Point{9500, 2500}) == 1);
    CHECK(winding(out.points, {9400, 2000}) == 1);
    const Curve in = offset_of(spiked, -500);
    CHECK(winding(in.points, {6000, 2000}) < 0);
    CHECK(winding(in.points, {2000, 2000}) == 1);
    const Ring collinear{{0, 0}, {1000, 0}, {4000, 0}, {4000, 4000}, {0, 4000}};
    CHECK(offset_of(collinear, 100).points == Ring{{-100, -100}, {1000, -100}, {4100, -100}, {4100, 4100}, {-100, 4100}});
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
