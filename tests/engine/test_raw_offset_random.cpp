// Raw offset curves of random polygons: against rectangles and wedges one by one, distances, and the way back.
#include <algorithm>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/raw_offsets.hpp"
#include "slicing/offset/offset_kernels.hpp"

using raw_offsets::Curve;
using raw_offsets::distance_to;
using raw_offsets::is_counter_clockwise;
using raw_offsets::offset_of;
using raw_offsets::Place;
using raw_offsets::Point;
using raw_offsets::Polygons;
using raw_offsets::Ring;
using raw_offsets::winding;

namespace {

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
Place sample(Polygons& random, const Curve& curve, double size, double distance) {
    if (curve.points.empty() || random.below(4) == 0) {
        return {random.number(-2 * size, 2 * size), random.number(-2 * size, 2 * size)};
    }
    const Point near = curve.points[random.below(curve.points.size())];
    const double reach = std::abs(distance) * std::pow(10, random.number(-2, 0.3));
    return {near.x + random.number(-reach, reach), near.y + random.number(-reach, reach)};
}

}  // namespace

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
