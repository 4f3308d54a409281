// Raw offset curves. Of few corners: points, facts and winding numbers are written down. Of random polygons: against
// rectangles and wedges one by one.
#include <catch2/catch.hpp>

#include "engine/polygons.hpp"
#include "rings.hpp"
#include "slicing/offset/raw_offset.hpp"

using namespace lamella;
using namespace polygons;

namespace {

using Place = rings::PlaceOf<double>;

struct Curve {
    RawCurve facts;
    Ring points;
};

Curve offset_of(const Ring& ring, double distance, double miter_limit = 3) {
    lamella::Worker worker;
    RawOffset offset(worker);
    const RawCurve facts = offset.append(ring, distance, {.limit = miter_limit});
    const auto points = offset.points_of(facts);
    return {facts, {points.begin(), points.end()}};
}

double distance_to(const Ring& ring, Place p) {
    double nearest = 1e300;
    rings::each_edge(ring, [&](Point a, Point b) { nearest = std::min(nearest, rings::distance(a, b, p)); });
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
        Ring ring = kind == 2 ? ragged(random, size) : star(random, 3 + random() % 12, 0.2 * size, size);
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

TEST_CASE("raw offsets of a few corners are known", "[engine][raw_offset]") {
    constexpr std::int32_t far = grid_limit;
    const Ring large{{-far, -far}, {far, -far}, {far, far}, {-far, far}};
    const Ring needle{{0, -200}, {100000, 0}, {0, 200}};
    const Ring spiked{{0, 0}, {4000, 0}, {4000, 2000}, {9000, 2000}, {4000, 2000}, {4000, 4000}, {0, 4000}};
    // Fibonacci numbers: the triangle's doubled area is 1, its longest edges differ in direction by 2e-18.
    const Ring thin{{0, 0}, {701408733, 433494437}, {267914296, 165580141}};
    enum Facts : std::uint8_t { turned, kept, cut, beyond };  // `cut`: on the way back, with directions kept
    struct Case {
        const char* name;
        Ring ring;
        double distance;
        double limit;
        Facts facts;
        Ring points{};  ///< that the curve has, in any order
        std::size_t count = 0;
    };
    const Case cases[] = {
        {"a notch whose floor goes: walls do not meet", notched, 2000, 3, turned, {{4500, 6500}, {4500, 7000}}, 11},
        {"a sliver of 0.4 units", {{0, 0}, {1000000, 0}, {1000000, 4}, {0, 4}}, -1.8, 3, kept, {}, 0},
        {"a corner cut at the distance", needle, 1000, 3, kept, {{101000, -998}, {101000, 998}}, 4},
        {"its miter: 1000 / sin 2 mrad", needle, 1000, 1000, kept, {{600001, 0}}, 3},
        {"a corner that the way back cuts", reversed(needle), 10, 3, cut},
        {"the same within the limit", reversed(needle), 10, 1000, kept},
        {"a right angle within the limit", square, 1000, 1.4143, kept, {}, 4},
        {"a right angle beyond the limit", square, 1000, 1.4142, kept, {}, 8},
        {"a right angle eroded", square, -1000, 1.4143, kept},
        {"a right angle eroded beyond the limit", square, -1000, 1.4142, cut},
        {"the cap of a spike", spiked, 500, 3, kept, {{9500, 1500}, {9500, 2500}}},
        {"a turn of nearly 180 degrees", thin, 1000, 3, kept},
        {"the other way round", reversed(thin), -1000, 3, kept},
        {"the low end of the grid", {{-far, 0}, {0, -100}, {0, 100}}, 1, 3, beyond},
        {"the high end", {{far, 0}, {0, 100}, {0, -100}}, 1, 3, beyond},
        {"all ends", large, 0.6, 3, beyond},
        {"far beyond", large, 2.0 * far, 3, beyond},
        {"inside out", large, -2.5 * far, 3, beyond},
        {"not yet", large, 0.4, 3, kept},
        {"inwards", large, -0.6, 3, kept},
        {"nearly all", large, -1.0 * far + 10, 3, kept},
        {"the notch, its floor last",
         {notched[5], notched[6], notched[7], notched[0], notched[1], notched[2], notched[3], notched[4]},
         2000,
         3,
         turned,
         {{4500, 6500}, {4500, 7000}},
         11}};
    for (const auto& [name, ring, distance, limit, facts, points, count] : cases) {
        INFO(name);
        const Curve curve = offset_of(ring, distance, limit);
        CHECK(curve.facts.beyond_grid == (facts == beyond));
        if (facts != beyond) {
            CHECK(curve.facts.directions_kept == (facts != turned));
            CHECK((curve.facts.reflex_cut == (facts == cut) || facts == turned));
        }
        CHECK((count == 0 || curve.points.size() == count));
        for (const Point& p : points) {
            CHECK(std::count(curve.points.begin(), curve.points.end(), p) >= 1);
        }
    }
    CHECK(offset_of(cases[1].ring, -1.8).points.empty());
    CHECK(offset_of(thin, -1000).facts.reflex_cut);
    CHECK(winding(offset_of(spiked, 500).points, {9400, 2000}) == 1);
    CHECK(winding(offset_of(spiked, -500).points, {6000, 2000}) < 0);
    CHECK(winding(offset_of(spiked, -500).points, {2000, 2000}) == 1);
}

TEST_CASE("points are moved alike wherever they stand", "[engine][raw_offset]") {
    for (const std::int32_t far : {0, 1 << 28, -(1 << 28), (1 << 30) - 8, 8 - (1 << 30)}) {
        const double nearly = 0.5 + 0x1p-19;
        CHECK(moved_on_grid({far, far + 1}, nearly, nearly) == Point{far + 1, far + 2});
        CHECK(moved_on_grid({far, far + 1}, -nearly, -nearly) == Point{far - 1, far});
        CHECK(moved_on_grid({far, far + 1}, 0.5, 0.5 + 0x1p-40) == Point{far, far + 2});  // ties go to even numbers
        CHECK(moved_on_grid({far, far}, 1e30, -1e30) == Point{grid_limit + 1, -grid_limit - 1});
    }
}

TEST_CASE("the positive region of a curve is solid, rectangles and wedges up to the distance", "[engine][raw_offset]") {
    const double size = 1e6;
    std::mt19937 random(1);
    int mixed = 0;
    int inside = 0;
    int beyond = 0;
    for (int round = 0; round < 400; ++round) {
        const Ring ring = simple_ring(random, size);
        const double distance = between(random, 0.005, 0.3) * (random() % 2 == 0 ? size : -size);
        const double limit = between(random, 1.5, 4);
        const Curve curve = offset_of(ring, distance, limit);
        const Sum sum(ring, distance, limit);
        const int around = rings::twice_area(ring) > 0 ? 0 : 1;  // what a hole lies in
        mixed += !curve.facts.directions_kept && curve.points.size() < 2 * ring.size() ? 1 : 0;
        for (int i = 0; i < 60; ++i) {
            const Place p = place_near(random, curve.points, size, std::abs(distance));
            if (curve.points.empty() || distance_to(curve.points, p) < 3 || distance_to(ring, p) < 3) {
                continue;
            }
            const bool positive = winding(curve.points, p) + around > 0;
            inside += positive ? 1 : 0;
            INFO("round " << round << ", distance " << distance << ", limit " << limit << ", " << p.x << ' ' << p.y);
            if (positive != (sum.at_place(p) + around > 0)) {  // wedges of edges that are gone reach beyond the distance
                ++beyond;
                REQUIRE(positive == (distance < 0));
                REQUIRE(distance_to(ring, p) > std::abs(distance) - 2);
            }
        }
    }
    CHECK(mixed > 100);
    CHECK(inside > 5000);
    CHECK(beyond < 400);
}

}  // namespace
