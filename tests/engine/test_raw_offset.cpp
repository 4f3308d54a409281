// Raw offset curves against winding numbers counted by brute force: written-down answers, and random polygons.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "slicing/offset/raw_offset.hpp"

using lamella::Point;
using lamella::RawCurve;
using lamella::RawOffset;

namespace {

using Ring = std::vector<Point>;

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

Ring reversed(Ring ring) {
    std::reverse(ring.begin(), ring.end());
    return ring;
}

struct Place {
    double x, y;
};

double distance_to_edge(Place p, Point a, Point b) {
    const double dx = double(b.x) - a.x;
    const double dy = double(b.y) - a.y;
    const double along = ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy);
    const double t = std::clamp(along, 0.0, 1.0);
    return std::hypot(a.x + t * dx - p.x, a.y + t * dy - p.y);
}

double distance_to(const Ring& ring, Place p) {
    double nearest = 1e300;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        nearest = std::min(nearest, distance_to_edge(p, ring[i], ring[(i + 1) % ring.size()]));
    }
    return nearest;
}

int winding(const Ring& ring, Place p) {
    int turns = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i];
        const Point b = ring[(i + 1) % ring.size()];
        const double side = (double(b.x) - a.x) * (p.y - a.y) - (double(b.y) - a.y) * (p.x - a.x);
        if (a.y <= p.y) {
            turns += b.y > p.y && side > 0 ? 1 : 0;
        } else {
            turns -= b.y <= p.y && side < 0 ? 1 : 0;
        }
    }
    return turns;
}

/// The sign of the turn at b.
int turn(Point a, Point b, Point c) {
    const std::int64_t twice =
        (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - b.y) - (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - b.x);
    return twice > 0 ? 1 : (twice < 0 ? -1 : 0);
}

bool is_simple(const Ring& ring) {
    const std::size_t count = ring.size();
    for (std::size_t i = 0; i < count; ++i) {
        const Point a = ring[i];
        const Point b = ring[(i + 1) % count];
        for (std::size_t j = i + 1; j < count; ++j) {
            const Point c = ring[j];
            const Point d = ring[(j + 1) % count];
            if (a == c) {
                return false;
            }
            if (j > i + 1 && (j + 1) % count != i && turn(a, b, c) * turn(a, b, d) <= 0 &&
                turn(c, d, a) * turn(c, d, b) <= 0) {
                return false;
            }
        }
    }
    return true;
}

bool is_counter_clockwise(const Ring& ring) {
    double twice_area = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i];
        const Point b = ring[(i + 1) % ring.size()];
        twice_area += double(a.x) * b.y - double(a.y) * b.x;
    }
    return twice_area > 0;
}

class Polygons {
public:
    explicit Polygons(unsigned seed) : random_(seed) {}

    double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    bool coin() { return random_() % 2 == 0; }
    std::size_t below(std::size_t count) { return random_() % count; }

    Ring star(double least, double most) {
        std::vector<double> angles(3 + random_() % 12);
        std::generate(angles.begin(), angles.end(), [this] { return number(0, 6.283185307179586); });
        std::sort(angles.begin(), angles.end());
        Ring ring;
        for (const double angle : angles) {
            const double radius = number(least, most);
            ring.push_back(
                {std::int32_t(std::lround(radius * std::cos(angle))), std::int32_t(std::lround(radius * std::sin(angle)))});
        }
        return ring;
    }
    /// Corners on a lattice of 9 x 9, walked so that no two edges cross where that is found.
    Ring lattice(std::int32_t spacing) {
        Ring ring(3 + random_() % 12);
        for (Point& p : ring) {
            p = {(std::int32_t(random_() % 9) - 4) * spacing, (std::int32_t(random_() % 9) - 4) * spacing};
        }
        const std::size_t count = ring.size();
        const auto length = [&](std::size_t a, std::size_t b) {
            return std::hypot(double(ring[a].x) - ring[b % count].x, double(ring[a].y) - ring[b % count].y);
        };
        for (int round = 0; round < 40; ++round) {
            for (std::size_t i = 0; i < count; ++i) {
                for (std::size_t j = i + 2; j < count - (i == 0 ? 1 : 0); ++j) {
                    if (length(i, i + 1) + length(j, j + 1) > length(i, j) + length(i + 1, j + 1) + 1e-6) {
                        std::reverse(ring.begin() + std::ptrdiff_t(i) + 1, ring.begin() + std::ptrdiff_t(j) + 1);
                    }
                }
            }
        }
        return ring;
    }
    /// A slab whose lower side runs in steps of any length and direction to the right.
    Ring ragged(double size) {
        Ring ring;
        double y = 0;
        for (double x = -size; x < size && ring.size() < 30;) {
            ring.push_back({std::int32_t(std::lround(x)), std::int32_t(std::lround(y))});
            const double step = size * std::pow(10, number(-3, -0.4));
            const double angle = number(-1.5, 1.5);
            x += step * std::cos(angle);
            y += step * std::sin(angle);
        }
        ring.push_back({std::int32_t(1.4 * size), std::int32_t(8 * size)});
        ring.push_back({std::int32_t(-1.4 * size), std::int32_t(8 * size)});
        return ring;
    }
    /// Simple, of either orientation.
    Ring simple(double size) {
        for (;;) {
            const std::size_t kind = below(3);
            const Ring ring = kind == 0   ? star(0.2 * size, size)
                              : kind == 1 ? lattice(std::int32_t(size / 4))
                                          : ragged(size);
            if (ring.size() >= 3 && is_simple(ring)) {
                return coin() ? ring : reversed(ring);
            }
        }
    }

private:
    std::mt19937 random_;
};

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
            if (turn(a, v, b) * distance >= 0) {
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
Place sample(Polygons& random, const Curve& curve, double size, double distance) {
    if (curve.points.empty() || random.below(4) == 0) {
        return {random.number(-2 * size, 2 * size), random.number(-2 * size, 2 * size)};
    }
    const Point near = curve.points[random.below(curve.points.size())];
    const double reach = std::abs(distance) * std::pow(10, random.number(-2, 0.3));
    return {near.x + random.number(-reach, reach), near.y + random.number(-reach, reach)};
}

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

TEST_CASE("all forms of the offset's kernels agree with the portable form", "[engine][raw_offset][kernels]") {
    Polygons random(4);
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
            const Ring ring = random.simple(size);
            const double distance = random.number(-2, 2) * size;
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
    Polygons random(1);
    int mixed = 0;
    int inside = 0;
    for (int round = 0; round < 400; ++round) {
        const Ring ring = random.simple(size);
        const double distance = random.number(0.005, 0.3) * (random.coin() ? size : -size);
        const double limit = random.number(1.5, 4);
        const Curve curve = offset_of(ring, distance, limit);
        const Sum sum(ring, distance, limit);
        const int around = is_counter_clockwise(ring) ? 0 : 1;  // what a hole lies in
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

TEST_CASE("the positive region reaches as far as the distance, and no farther than the limit", "[engine][raw_offset]") {
    const double size = 1e6;
    Polygons random(2);
    int near = 0;
    int far = 0;
    for (int round = 0; round < 400; ++round) {
        const Ring ring = random.simple(size);
        const double reach = random.number(0.005, 0.3) * size;
        const double limit = random.number(1.5, 4);
        const int around = is_counter_clockwise(ring) ? 0 : 1;
        const Curve out = offset_of(ring, reach, limit);
        const Curve in = offset_of(ring, -reach, limit);
        for (int i = 0; i < 60; ++i) {
            const Place p = sample(random, random.coin() ? out : in, size, reach);
            const bool solid = winding(ring, p) + around > 0;
            const double away = distance_to(ring, p);
            if (solid || away < reach - 3) {
                CHECK(winding(out.points, p) + around > 0);
                near += solid ? 0 : 1;
            } else if (away > limit * reach + 3) {
                CHECK(winding(out.points, p) + around <= 0);
                ++far;
            }
            if (!solid || away < reach - 3) {
                CHECK(winding(in.points, p) + around <= 0);
            } else if (away > limit * reach + 3) {
                CHECK(winding(in.points, p) + around > 0);
            }
        }
    }
    CHECK(near > 1000);
    CHECK(far > 1000);
}

TEST_CASE("offset back by the distance, a curve that keeps directions and cuts nothing is the contour",
          "[engine][raw_offset]") {
    Polygons random(3);
    int compared = 0;
    for (int round = 0; round < 4000; ++round) {
        const double size = 1e8;
        const Ring ring = random.simple(size);
        const double distance = random.number(1e-4, 0.02) * (random.coin() ? size : -size);
        const Curve there = offset_of(ring, distance);
        const Curve back = offset_of(there.points, -distance);
        // Cut corners leave edges of length 0 on the way back, which rounding turns round.
        if (!there.facts.directions_kept || there.facts.reflex_cut || there.points.size() != ring.size()) {
            continue;
        }
        bool long_enough = true;  // against half a unit at both ends, which turns an edge by 1 / length
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = there.points[i];
            const Point b = there.points[(i + 1) % ring.size()];
            long_enough = long_enough && std::hypot(double(a.x) - b.x, double(a.y) - b.y) > 2 * std::abs(distance);
        }
        if (!long_enough) {
            continue;
        }
        ++compared;
        REQUIRE(back.points.size() == ring.size());
        CHECK(back.facts.directions_kept);
        for (std::size_t i = 0; i < ring.size(); ++i) {
            INFO("round " << round << ", distance " << distance << ", point " << i);
            CHECK(std::hypot(double(back.points[i].x) - ring[i].x, double(back.points[i].y) - ring[i].y) <= 3);
        }
    }
    CHECK(compared > 200);
}
