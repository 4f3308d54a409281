// What upward and downward faces project onto layers, against drawings, against slice(), and against a look at every face
// above a point.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"
#include "oracle/oracle.hpp"

using lamella::MeshView;
using lamella::PlaneSide;
using lamella::Point;
using lamella::SlabOptions;
using lamella::Slabs;
using lamella::SliceResult;

namespace {

using Lines = std::vector<std::string>;

SlabOptions slabs_at(std::vector<double> heights_mm, double unit_mm = coarse_unit_mm) {
    SlabOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{std::move(heights_mm)};
    options.unit_mm = unit_mm;
    options.control.threads = 1;
    return options;
}

/// Requires success and two valid results.
Slabs slabs_of(const MeshView& mesh, const SlabOptions& options) {
    lamella::Result<Slabs> slabs = slice_slabs(mesh, options);
    INFO((slabs ? std::string() : slabs.error().message));
    REQUIRE(slabs.ok());
    for (const SliceResult* const result : {&slabs->top, &slabs->bottom}) {
        const lamella::Status valid = validate(*result);
        INFO((valid ? std::string() : valid.error().message));
        REQUIRE(valid.ok());
    }
    return std::move(slabs).value();
}
Slabs slabs_of(const shapes::Soup& soup, const SlabOptions& options) {
    return slabs_of(view_of(soup), options);
}

std::uint64_t hash_of(const Slabs& slabs) {
    return hash_result(slabs.top) * 31 + hash_result(slabs.bottom);
}

/// Twice the net area of one layer, or of all, in square units.
oracle::Int128 twice_area(const SliceResult& result, const lamella::Layer& layer) {
    oracle::Int128 sum = 0;
    for (const lamella::Contour& contour : result.contours_of(layer)) {
        sum += (oracle::Int128{contour.twice_area.high} << 64) + contour.twice_area.low;
    }
    return sum;
}
oracle::Int128 twice_area(const SliceResult& result) {
    oracle::Int128 sum = 0;
    for (const lamella::Layer& layer : result.layers) {
        sum += twice_area(result, layer);
    }
    return sum;
}

oracle::Int128 twice_area(const oracle::Triangle& t) {
    const auto [a, b, c] = t;
    return oracle::Int128{b.x - a.x} * (c.y - a.y) - oracle::Int128{b.y - a.y} * (c.x - a.x);
}

/// Of all faces that look upward.
oracle::Int128 twice_upward_area(const shapes::Soup& soup, double unit_mm) {
    oracle::Int128 sum = 0;
    for (const oracle::Triangle& t : oracle::quantise(soup, unit_mm)) {
        sum += std::max<oracle::Int128>(0, twice_area(t));
    }
    return sum;
}

/// Whether the layer is solid at a place in grid units.
bool covers(const SliceResult& result, std::size_t layer, double x, double y) {
    int winding = 0;
    for (const lamella::Contour& contour : result.contours_of(result.layers[layer])) {
        const auto points = result.points_of(contour);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Point a = points[i];
            const Point b = points[(i + 1) % points.size()];
            if ((a.y <= y) != (b.y <= y) && a.x + (b.x - a.x) * ((y - a.y) / (double(b.y) - a.y)) > x) {
                winding += b.y > a.y ? 1 : -1;
            }
        }
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

/// A bowl and what it stands on: horizontal, sloped and vertical faces, an overhang and a hollow.
shapes::Soup steps() {
    return shapes::joined({shapes::box({0, 0, 0}, {8, 8, 2}), shapes::box({2, 2, 2}, {6, 6, 5})});
}

lamella::Error slab_failure(const MeshView& mesh, const SlabOptions& options) {
    const lamella::Result<Slabs> slabs = slice_slabs(mesh, options);
    REQUIRE_FALSE(slabs.ok());
    CHECK_FALSE(slabs.error().message.empty());
    CHECK(slabs.error().message.find('\n') == std::string::npos);
    return slabs.error();
}

lamella::SliceOptions as_slice(const SlabOptions& options) {
    lamella::SliceOptions same;
    same.plan = options.plan;
    same.unit_mm = options.unit_mm;
    same.unit_fit = options.unit_fit;
    same.allow_empty = options.allow_empty;
    same.transform = options.transform;
    same.memory_limit_bytes = options.memory_limit_bytes;
    same.control = options.control;
    return same;
}

}  // namespace

TEST_CASE("a box projects its top and its bottom, and nothing between", "[engine][slabs]") {
    const Slabs slabs = slabs_of(shapes::box({0, 0, 0}, {4, 3, 10}), slabs_at({-2, 1, 5, 9, 12}));
    const Lines rectangle = {"outer + x4 in -: 0,0 8,0 8,6 0,6"};
    CHECK(contours_at(slabs.top, 3) == rectangle);
    CHECK(contours_at(slabs.bottom, 1) == rectangle);
    for (const std::size_t layer : {0U, 1U, 2U, 4U}) {
        CHECK(contours_at(slabs.top, layer).empty());
    }
    for (const std::size_t layer : {0U, 2U, 3U, 4U}) {
        CHECK(contours_at(slabs.bottom, layer).empty());
    }
    CHECK(slabs.top.layers[3].segments == 2);
    CHECK(slabs.top.summary.crossed == 2);
    CHECK(slabs.top.summary.segments == 2);
    CHECK(slabs.top.summary.triangles == 12);
}

TEST_CASE("a horizontal face on a plane lies above it or below it as the plan says", "[engine][slabs]") {
    SlabOptions options = slabs_at({0, 5, 10});
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 10});
    const Lines square = {"outer + x4 in -: 0,0 8,0 8,8 0,8"};
    SECTION("below: an upward face projects to its own plane, a downward one to the next above") {
        const Slabs slabs = slabs_of(box, options);
        CHECK(contours_at(slabs.top, 2) == square);
        CHECK(contours_at(slabs.bottom, 1) == square);
        CHECK(twice_area(slabs.top) == 128);
        CHECK(twice_area(slabs.bottom) == 128);
    }
    SECTION("above: an upward face projects to the next plane below, a downward one to its own") {
        options.plan.side = PlaneSide::above;
        const Slabs slabs = slabs_of(box, options);
        CHECK(contours_at(slabs.top, 1) == square);
        CHECK(contours_at(slabs.bottom, 0) == square);
        CHECK(twice_area(slabs.top) == 128);
        CHECK(twice_area(slabs.bottom) == 128);
    }
}

TEST_CASE("upward faces below the lowest plane and downward ones above the highest project to none", "[engine][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 10});
    const Slabs above = slabs_of(box, slabs_at({11, 12}));
    CHECK(above.top.contours.empty());
    CHECK(above.top.summary.crossed == 0);
    CHECK(twice_area(above.bottom, above.bottom.layers[0]) == 128);
    const Slabs below = slabs_of(box, slabs_at({-5, -1}));
    CHECK(below.bottom.contours.empty());
    CHECK(below.bottom.summary.crossed == 0);
    CHECK(twice_area(below.top, below.top.layers[1]) == 128);
}

TEST_CASE("a step's top has a hole where the next step stands", "[engine][slabs]") {
    const Slabs slabs = slabs_of(steps(), slabs_at({1, 3}));
    // The cap of the lower box is whole: where the upper one stands, its bottom lies on it.
    CHECK(contours_at(slabs.top, 0) == Lines{"outer + x4 in -: 0,0 16,0 16,16 0,16"});
    CHECK(contours_at(slabs.top, 1) == Lines{"outer + x4 in -: 4,4 12,4 12,12 4,12"});
    CHECK(contours_at(slabs.bottom, 0) == Lines{"outer + x4 in -: 0,0 16,0 16,16 0,16"});
    CHECK(contours_at(slabs.bottom, 1) == Lines{"outer + x4 in -: 4,4 12,4 12,12 4,12"});
    // A pyramid cut at two heights: the slab between them is a frame.
    const shapes::Soup pyramid = shapes::joined(
        {shapes::triangle({0, 0, 0}, {8, 0, 0}, {4, 4, 4}), shapes::triangle({8, 0, 0}, {8, 8, 0}, {4, 4, 4}),
         shapes::triangle({8, 8, 0}, {0, 8, 0}, {4, 4, 4}), shapes::triangle({0, 8, 0}, {0, 0, 0}, {4, 4, 4})});
    SlabOptions side = slabs_at({1, 3});
    const Slabs frame = slabs_of(pyramid, side);
    CHECK(contours_at(frame.top, 0) == Lines{"outer + x4 in -: 1,1 15,1 15,15 1,15", "hole - x4 in 0: 5,5 5,11 11,11 11,5"});
    CHECK(contours_at(frame.top, 1) == Lines{"outer + x4 in -: 5,5 11,5 11,11 5,11"});
    const auto islands = islands_of(frame.top.contours_of(frame.top.layers[0]));
    CHECK((*islands.begin()).holes.size() == 1);
    CHECK(frame.bottom.contours.empty());
}

TEST_CASE("a face between two planes is one piece, and one across planes is cut", "[engine][slabs]") {
    const shapes::Soup low = shapes::triangle({0, 0, 2}, {4, 0, 3}, {0, 4, 3});
    const Slabs whole = slabs_of(low, slabs_at({1, 5}));
    CHECK(contours_at(whole.top, 0) == Lines{"outer + x3 in -: 0,0 8,0 0,8"});
    CHECK(whole.top.summary.segments == 1);
    const shapes::Soup tall = shapes::triangle({0, 0, 0}, {8, 0, 0}, {0, 0.5, 8});
    const Slabs cut = slabs_of(tall, slabs_at({-1, 2, 4, 6}, 0));
    CHECK(cut.top.summary.segments == 4);
    CHECK(cut.top.summary.crossed == 1);
    for (std::size_t layer = 0; layer < 4; ++layer) {
        CHECK(cut.top.layers[layer].segments == 1);
    }
}

TEST_CASE("heights may be listed in any order and coincide", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 3);
    const Slabs sorted = slabs_of(ball, slabs_at({-3, 0, 2}, 0));
    const Slabs listed = slabs_of(ball, slabs_at({2, -3, 0, 2, -3}, 0));
    CHECK(hash_of(listed) == hash_of(sorted));
    CHECK(std::vector<std::uint64_t>(listed.top.layer_of.begin(), listed.top.layer_of.end()) ==
          std::vector<std::uint64_t>{2, 0, 1, 2, 0});
    CHECK(std::equal(listed.bottom.layer_of.begin(), listed.bottom.layer_of.end(), listed.top.layer_of.begin()));
}

TEST_CASE("the bands of a ball share their borders with slices, and their areas add up exactly", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({1, 2, 0}, 5, 4);
    SlabOptions options = slabs_at({-20, 0.3, 1.1, 2.5, 2.75, 4, 4.9}, 0);
    const Slabs slabs = slabs_of(ball, options);
    const SliceResult slice = sliced(ball, as_slice(options));
    CHECK(twice_area(slabs.top) == twice_upward_area(ball, slabs.top.unit_mm));
    const auto points = [](const SliceResult& result, std::uint64_t contour) {
        const auto own = result.points_of(result.contours[contour]);
        std::vector<std::pair<int, int>> sorted;
        for (const Point p : own) {
            sorted.emplace_back(p.x, p.y);
        }
        std::sort(sorted.begin(), sorted.end());
        return sorted;
    };
    for (std::size_t layer = 1; layer < slice.layers.size(); ++layer) {
        const bool last = layer + 1 == slice.layers.size();
        REQUIRE(slabs.top.layers[layer].contour_count == (last ? 1 : 2));
        const std::uint64_t outer = slabs.top.layers[layer].first_contour;
        CHECK(points(slabs.top, outer) == points(slice, slice.layers[layer].first_contour));
        if (!last) {
            CHECK(points(slabs.top, outer + 1) == points(slice, slice.layers[layer + 1].first_contour));
        }
    }
}

TEST_CASE("two planes far below and far above give the whole shadow", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 3);
    const Slabs slabs = slabs_of(ball, slabs_at({-1e9, 1e9}, 0));
    CHECK(twice_area(slabs.top, slabs.top.layers[0]) == twice_upward_area(ball, slabs.top.unit_mm));
    CHECK(slabs.top.layers[1].contour_count == 0);
    CHECK(slabs.bottom.layers[0].contour_count == 0);
    CHECK(twice_area(slabs.bottom) == twice_area(slabs.top));
}

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

TEST_CASE("a transform that mirrors turns no face inside out", "[engine][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 3, 10});
    SlabOptions options = slabs_at({1, 9});
    options.transform.m[5] = -1;
    const Slabs slabs = slabs_of(box, options);
    CHECK(contours_at(slabs.top, 1) == Lines{"outer + x4 in -: 0,-6 8,-6 8,0 0,0"});
    CHECK(contours_at(slabs.bottom, 0) == Lines{"outer + x4 in -: 0,-6 8,-6 8,0 0,0"});
    CHECK(slabs.top.layers[0].contour_count == 0);
}

TEST_CASE("slabs do not depend on threads or on the order of triangles", "[engine][slabs][determinism][threads]") {
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        for (const double layer : {0.3, 40.0}) {
            SlabOptions options;
            options.plan.spacing = lamella::UniformLayers{.layer_height_mm = layer, .first_height_mm = 0.01};
            options.control.threads = 1;
            const std::uint64_t expected = hash_of(slabs_of(mesh, options));
            INFO(name);
            for (const int threads : {2, 5}) {
                options.control.threads = threads;
                CHECK(hash_of(slabs_of(mesh, options)) == expected);
            }
            for (const std::uint64_t seed : {1U, 2U, 3U}) {
                CHECK(hash_of(slabs_of(shapes::shuffled(mesh, seed), options)) == expected);
            }
        }
    }
}

TEST_CASE("any view of a mesh gives the same slabs", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 2);
    const std::uint64_t expected = hash_of(slabs_of(ball, slabs_at({-2, 1, 2}, 0)));
    CHECK(hash_of(slabs_of(shapes::indexed(ball).view(), slabs_at({-2, 1, 2}, 0))) == expected);
}

TEST_CASE("one of very many layers is what its two planes alone give", "[engine][slabs][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 3);
    constexpr std::size_t planes = 9'001;
    std::vector<double> heights;
    for (std::size_t i = 0; i < planes; ++i) {
        heights.push_back(-6 + 12 * static_cast<double>(i) / (planes - 1));
    }
    SlabOptions options = slabs_at(heights, 0);
    options.control.threads = 3;
    const Slabs all = slabs_of(ball, options);
    REQUIRE(all.top.layers.size() == planes);
    CHECK(twice_area(all.top) == twice_upward_area(ball, all.top.unit_mm));
    for (const std::size_t layer : {4'500U, 4'501U, 5'000U, 6'999U, 8'249U}) {
        const Slabs two = slabs_of(ball, slabs_at({heights[layer], heights[layer + 1]}, 0));
        CHECK(twice_area(all.top, all.top.layers[layer]) == twice_area(two.top, two.top.layers[0]));
        CHECK(all.top.layers[layer].segments == two.top.layers[0].segments);
        const Slabs below = slabs_of(ball, slabs_at({heights[planes - layer], heights[planes - 1 - layer]}, 0));
        const lamella::Layer& low = all.bottom.layers[planes - layer];
        CHECK(twice_area(all.bottom, low) == twice_area(below.bottom, below.bottom.layers[1]));
        CHECK(low.segments == below.bottom.layers[1].segments);
        CHECK(low.segments > 0);
    }
}

TEST_CASE("pieces on top of one another are united, whatever their number", "[engine][slabs]") {
    const shapes::Soup sheet = shapes::triangle({0, 0, 1}, {4, 0, 1}, {0, 4, 1});
    const shapes::Soup stack = shapes::joined(
        {sheet, shapes::moved(sheet, {0, 0, 0.5}), shapes::moved(sheet, {0, 0, 0.5}), shapes::moved(sheet, {1, 1, 1})});
    const Slabs slabs = slabs_of(stack, slabs_at({0, 9}));
    CHECK(contours_at(slabs.top, 0) == Lines{"outer + x7 in -: 0,0 8,0 6,2 10,2 2,10 2,6 0,8"});
    CHECK(slabs.top.layers[0].segments == 4);
    CHECK(slabs.top.layers.size() == 2);
}

TEST_CASE("rules of regions follow the union", "[engine][slabs][regions]") {
    const shapes::Soup parts = shapes::joined({shapes::box({0, 0, 0}, {4, 4, 4}), shapes::box({5, 0, 0}, {8, 4, 4})});
    SlabOptions options = slabs_at({2});
    options.bottom = false;
    SECTION("points within straight lines go") {
        const shapes::Soup tilted = shapes::joined(
            {shapes::triangle({0, 0, 3}, {4, 0, 3}, {4, 4, 3}), shapes::triangle({0, 0, 3}, {4, 4, 3}, {0, 4, 3}),
             shapes::triangle({4, 0, 3}, {8, 0, 3}, {8, 4, 3}), shapes::triangle({4, 0, 3}, {8, 4, 3}, {4, 4, 3})});
        CHECK(contours_at(slabs_of(tilted, options).top, 0) == Lines{"outer + x6 in -: 0,0 8,0 16,0 16,8 8,8 0,8"});
        options.region.drop_collinear = true;
        const Lines plain = contours_at(slabs_of(tilted, options).top, 0);
        CHECK(plain == Lines{"outer + x6 in -: 0,0 16,0 16,8 0,8"});
    }
    SECTION("gaps are closed") {
        options.region.close_mm = 1;
        CHECK(slabs_of(parts, options).top.layers[0].contour_count == 1);
    }
    SECTION("the largest stays") {
        options.region.largest_only = true;
        CHECK(contours_at(slabs_of(parts, options).top, 0) == Lines{"outer + x4 in -: 0,0 8,0 8,8 0,8"});
    }
    SECTION("layers that the rules empty are counted") {
        options.region.offset_mm = -2.5;
        const Slabs slabs = slabs_of(parts, options);
        CHECK(slabs.top.contours.empty());
        CHECK(slabs.top.summary.emptied_layers == 1);
    }
}

TEST_CASE("what is not asked for has no layers", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 2);
    SlabOptions options = slabs_at({-2, 1, 2}, 0);
    const Slabs both = slabs_of(ball, options);
    options.bottom = false;
    const Slabs top = slabs_of(ball, options);
    CHECK(hash_result(top.top) == hash_result(both.top));
    CHECK(top.bottom.layers.empty());
    options.bottom = true;
    options.top = false;
    const Slabs bottom = slabs_of(ball, options);
    CHECK(hash_result(bottom.bottom) == hash_result(both.bottom));
    CHECK(bottom.top.layers.empty());
}

TEST_CASE("slabs refuse what slice() refuses, in the same words", "[engine][slabs][errors]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const auto same = [&](const MeshView& mesh, const SlabOptions& options, lamella::ErrorCode code) {
        const lamella::Error expected = failure_of(mesh, as_slice(options));
        const lamella::Error found = slab_failure(mesh, options);
        CHECK(found.message == expected.message);
        CHECK(found.code == expected.code);
        CHECK(found.code == code);
        CHECK(found.triangle == expected.triangle);
        CHECK(found.plane == expected.plane);
    };
    using lamella::ErrorCode;
    shapes::Soup bad = box;
    bad[40] = nan;
    same(view_of(bad), slabs_at({1}), ErrorCode::bad_coordinate);
    bad[40] = 2e9;
    same(view_of(bad), slabs_at({1}), ErrorCode::bad_coordinate);
    same(view_of({}), slabs_at({1}), ErrorCode::empty_mesh);
    const shapes::Soup point = shapes::triangle({0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0});
    same(view_of(point), slabs_at({1}), ErrorCode::empty_mesh);
    same(view_of(box), slabs_at({1, nan}), ErrorCode::bad_planes);
    same(view_of(box), slabs_at({1}, 1e-18), ErrorCode::invalid_argument);
    same(view_of(box), slabs_at({1}, 1e-9), ErrorCode::bad_coordinate);
    shapes::Indexed indexed = shapes::indexed(box);
    indexed.indices[7] = 99;
    same(indexed.view(), slabs_at({1}), ErrorCode::invalid_argument);
    SlabOptions negative = slabs_at({1});
    negative.control.threads = -1;
    same(view_of(box), negative, ErrorCode::invalid_argument);
}

TEST_CASE("slabs refuse what has no meaning for them", "[engine][slabs][errors]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    SlabOptions options = slabs_at({1});
    SECTION("neither") {
        options.top = options.bottom = false;
        CHECK(slab_failure(view_of(box), options).message == "neither top nor bottom is asked for");
    }
    SECTION("a fill rule") {
        options.region.fill_rule = lamella::FillRule::non_zero;
        CHECK_THAT(slab_failure(view_of(box), options).message, Catch::Contains("fill rule"));
    }
    SECTION("lengths that are none") {
        options.region.close_mm = -1;
        CHECK_THAT(slab_failure(view_of(box), options).message, Catch::StartsWith("the closing radius"));
        options.region.close_mm = 1e9;
        CHECK_THAT(slab_failure(view_of(box), options).message, Catch::Contains("beyond the grid"));
    }
    SECTION("more than the memory limit") {
        options.memory_limit_bytes = 150;
        const lamella::Error error = slab_failure(view_of(box), options);
        CHECK(error.code == lamella::ErrorCode::result_too_large);
        CHECK(error.message == "1 layer with 4 pieces of faces need 160 bytes, more than the memory limit of 150");
    }
}

TEST_CASE("an empty mesh gives empty layers where asked", "[engine][slabs]") {
    SlabOptions options = slabs_at({3, 1, 2}, 0);
    options.allow_empty = true;
    for (const shapes::Soup& soup : {shapes::Soup{}, shapes::triangle({0, 0, 0}, {0, 0, 0}, {0, 1e-9, 0})}) {
        const Slabs slabs = slabs_of(soup, options);
        CHECK(slabs.top.layers.size() == 3);
        CHECK(slabs.bottom.layers.size() == 3);
        CHECK(slabs.top.contours.empty());
        CHECK(slabs.top.layer_of[0] == 2);
        options.plan.spacing = lamella::UniformLayers{};
        CHECK(slabs_of(soup, options).top.layers.empty());
        options.plan.spacing = lamella::ExplicitPlanes{{3, 1, 2}};
    }
}

TEST_CASE("a coarser unit is taken where the mesh needs one", "[engine][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    SlabOptions options = slabs_at({1}, 0x1p-29);
    options.unit_fit = lamella::UnitFit::coarser_if_needed;
    const Slabs slabs = slabs_of(box, options);
    CHECK(slabs.top.summary.unit_doublings == 2);
    CHECK(slabs.bottom.unit_mm == 0x1p-27);
    CHECK(slabs.top.area_mm2(slabs.top.layers[0]) == 16);
}

TEST_CASE("slabs take their memory from the host and hold no more than their result", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 5);
    CountingMemory memory;
    {
        SlabOptions options = slabs_at({-2, 0, 1, 2}, 0);
        options.control.memory = &memory;
        const Slabs slabs = slabs_of(ball, options);
        std::size_t bytes = 0;
        for (const SliceResult* const result : {&slabs.top, &slabs.bottom}) {
            bytes += result->layers.capacity() * sizeof(lamella::Layer) +
                     result->contours.capacity() * sizeof(lamella::Contour) + result->points.capacity() * sizeof(Point) +
                     result->layer_of.capacity() * sizeof(std::uint64_t);
        }
        CHECK(memory.held() == bytes);
        CHECK(memory.peak() > slabs.top.summary.segments * 8);
    }
    CHECK(memory.held() == 0);
}
