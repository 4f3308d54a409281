// Slabs against a look at every face above and below a place.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slabs.hpp"
#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"
#include "rings.hpp"

using lamella::PlaneSide;
using lamella::Point;
using namespace slab_tests;

namespace {

/// Whether the layer is solid at a place in grid units.
bool covers(const SliceResult& result, std::size_t layer, double x, double y) {
    int winding = 0;
    for (const lamella::Contour& contour : result.contours_of(result.layers[layer])) {
        winding += rings::winding(result.points_of(contour), rings::PlaceOf<double>{x, y}).value_or(0);
    }
    return winding > 0;
}

/// What lies above and below one place, by each face alone.
class Plumb {
public:
    /// In grid units.
    Plumb(double x, double y) : x_(x), y_(y) {}

    /// False where the place is too near to a border for doubles to tell.
    bool pass(const oracle::Triangle& t, double mirror) {
        double barycentric[3];
        const auto area = static_cast<double>(twice_area(t));
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& a = t[(i + 1) % 3];
            const auto& b = t[(i + 2) % 3];
            const double side = (double(b.x) - a.x) * (y_ - a.y) - (double(b.y) - a.y) * (x_ - a.x);
            if (std::abs(side) < margin * std::hypot(double(b.x) - a.x, double(b.y) - a.y)) {
                return false;
            }
            barycentric[i] = side / area;
        }
        if (area != 0 && *std::min_element(barycentric, barycentric + 3) > 0) {
            const double z = barycentric[0] * t[0].z + barycentric[1] * t[1].z + barycentric[2] * t[2].z;
            (area * mirror > 0 ? up_ : down_).push_back(z);
        }
        return true;
    }

    /// Compares layer by layer; false where a face pierces a plane too near.
    bool judge(const Slabs& slabs) const {
        const auto& layers = slabs.top.layers;
        const auto height = [&](std::size_t i) { return static_cast<double>(layers[i].plane.z()); };
        for (const auto* const heights : {&up_, &down_}) {
            for (const double z : *heights) {
                for (std::size_t i = 0; i < layers.size(); ++i) {
                    if (std::abs(z - height(i)) < margin) {
                        return false;
                    }
                }
            }
        }
        constexpr double infinity = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const double next = i + 1 < layers.size() ? height(i + 1) : infinity;
            const double before = i > 0 ? height(i - 1) : -infinity;
            INFO("layer " << i << " at " << x_ << ", " << y_);
            REQUIRE(covers(slabs.top, i, x_, y_) == any_between(up_, height(i), next));
            REQUIRE(covers(slabs.bottom, i, x_, y_) == any_between(down_, before, height(i)));
        }
        return true;
    }

private:
    static constexpr double margin = 40;  // of 2^20 units a mm

    static bool any_between(const std::vector<double>& heights, double low, double high) {
        return std::any_of(heights.begin(), heights.end(), [&](double z) { return low < z && z < high; });
    }

    double x_;
    double y_;
    std::vector<double> up_;
    std::vector<double> down_;
};

/// At random places. `moved`: the soup as the transform leaves it, with faces turned where it mirrors.
std::size_t judge_by_plumbs(const shapes::Soup& moved, double mirror, const Slabs& slabs, std::uint64_t seed, double range) {
    std::mt19937_64 random(seed);
    const std::vector<oracle::Triangle> triangles = oracle::quantise(moved, slabs.top.unit_mm);
    std::size_t judged = 0;
    for (int i = 0; i < 40; ++i) {
        const auto place = [&] { return (static_cast<double>(random() >> 11) * 0x1p-53 * 2 - 0.5) * range * 0x1p20; };
        Plumb plumb(place(), place());
        const bool clear = std::all_of(triangles.begin(), triangles.end(),
                                       [&](const oracle::Triangle& t) { return plumb.pass(t, mirror); });
        judged += clear && plumb.judge(slabs) ? 1 : 0;
    }
    return judged;
}

}  // namespace

TEST_CASE("a marked part of a surface is projected by itself", "[engine][slabs]") {
    // Every third face of a ball: each leaves a triangle, cut by planes, that touches others at corners only.
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 2);
    shapes::Soup marked;
    for (std::size_t t = 0; t + 9 <= ball.size(); t += 27) {
        marked.insert(marked.end(), ball.begin() + static_cast<std::ptrdiff_t>(t),
                      ball.begin() + static_cast<std::ptrdiff_t>(t) + 9);
    }
    const Slabs whole = slabs_of(marked, slabs_at({-9, 9}, 0));
    CHECK(twice_area(whole.top) == twice_upward_area(marked, whole.top.unit_mm));
    CHECK(judge_by_plumbs(marked, 1, slabs_of(marked, slabs_at({-1, 0.5, 2, 3.25}, 0)), 1, 5) > 20);
}

TEST_CASE("every place is covered as the faces above and below it say", "[engine][slabs][random]") {
    std::mt19937_64 random(3);
    std::size_t judged = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const std::uint64_t range = 3 + random() % 6;
        const shapes::Soup soup = seed % 2 == 0 ? shapes::random_soup(seed, 2 + static_cast<int>(random() % 30), range)
                                                : shapes::random_tetrahedra(seed, 1 + static_cast<int>(random() % 8), range);
        std::vector<double> heights;
        for (std::uint64_t i = 0; i < 1 + random() % 5; ++i) {
            heights.push_back(static_cast<double>(random() % (16 * range)) / 8 - 1);
        }
        SlabOptions options = slabs_at(heights, 0x1p-20);
        options.plan.side = random() % 2 == 0 ? PlaneSide::below : PlaneSide::above;
        options.control.threads = 1 + static_cast<int>(random() % 3);
        shapes::Soup moved = soup;
        const bool mirrored = random() % 2 == 0;
        if (mirrored) {
            options.transform.m[0] = -1;
            options.transform.m[3] = static_cast<double>(range);
            for (std::size_t i = 0; i < moved.size(); i += 3) {
                moved[i] = static_cast<double>(range) - moved[i];
            }
        }
        options.allow_empty = true;
        INFO("seed " << seed);
        judged += judge_by_plumbs(moved, mirrored ? -1 : 1, slabs_of(soup, options), seed, static_cast<double>(range));
    }
    CHECK(judged > 60 * 40 / 2);
}
