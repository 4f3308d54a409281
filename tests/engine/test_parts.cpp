// Several meshes in one result.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"

using lamella::Contour;
using lamella::ErrorCode;
using lamella::FillRule;
using lamella::Part;
using lamella::SliceOptions;
using lamella::SliceResult;

namespace {

Part part_of(const shapes::Soup& soup, const lamella::Transform& transform = {}) {
    return {view_of(soup), transform};
}

lamella::Transform moved_by(double x, double y, double z) {
    lamella::Transform transform;
    transform.m[3] = x;
    transform.m[7] = y;
    transform.m[11] = z;
    return transform;
}

using Parts = std::vector<Part>;
using Names = std::vector<std::uint32_t>;

Names parts_in(const SliceResult& result, std::size_t layer) {
    Names parts;
    for (const Contour& contour : result.contours_of(result.layers[layer])) {
        parts.push_back(contour.part);
    }
    return parts;
}

SliceResult united(const Parts& parts, SliceOptions options, const lamella::Context& context = {}) {
    options.unite_parts = true;
    return sliced(parts, options, context);
}

std::uint64_t hash_without_parts(SliceResult result) {
    for (Contour& contour : result.contours) {
        contour.part = 0;
    }
    return result.hash();
}

/// Contours of a layer as "outer 1", "hole several", in the order of the result.
std::vector<std::string> named_at(const SliceResult& result, std::size_t layer) {
    std::vector<std::string> names;
    for (const Contour& contour : result.contours_of(result.layers[layer])) {
        const std::string role = contour.role == lamella::Role::outer  ? "outer "
                                 : contour.role == lamella::Role::hole ? "hole "
                                 : contour.role == lamella::Role::flat ? "flat "
                                                                       : "open ";
        names.push_back(role + (contour.part == lamella::several_parts ? "several" : std::to_string(contour.part)));
    }
    return names;
}

using Lines = std::vector<std::string>;

}  // namespace

TEST_CASE("the contours of parts that overlap lie side by side", "[engine][parts]") {
    const shapes::Soup tube =
        shapes::joined({shapes::box({0, 0, 0}, {10, 10, 10}), shapes::flipped(shapes::box({2, 2, 0}, {8, 8, 10}))});
    const shapes::Soup cube = shapes::box({-4, 4, 0}, {4, 6, 20});
    const SliceResult result = sliced(Parts{part_of(tube), part_of(cube)}, at_heights({5, 15, 25}));
    CHECK(result.info.part_count == 2);
    CHECK(contours_at(result, 0) == std::vector<std::string>{"outer + x8 in -: 0,0 9,0 20,0 20,9 20,20 11,20 0,20 0,11",
                                                             "hole - x8 in 0: 4,4 4,11 4,16 11,16 16,16 16,9 16,4 9,4",
                                                             "outer + x8 in -: -8,8 -4,8 8,8 8,9 8,12 4,12 -8,12 -8,11"});
    CHECK(parts_in(result, 0) == Names{0, 0, 1});
    CHECK(parts_in(result, 1) == Names{1});
    CHECK(parts_in(result, 2).empty());
    CHECK(result.layers[0].segments == 24);
    CHECK(result[0].area_mm2() == 64 + 16);
    CHECK(result.info.triangles == 36);
    CHECK(result.info.box.min_mm[0] == -4);
    CHECK(result.info.box.max_mm[2] == 20);
    // Two crossings of the bar with the wall of the tube on each of its long sides.
    const lamella::Crossings crossings = value_of(audits::crossings_of(result));
    CHECK(crossings.count == 4);
    CHECK_FALSE(audits::ledger_of(result, view_of(tube)).ok());
    CHECK_FALSE(audits::volume_of(result, view_of(tube)).ok());
}

TEST_CASE("planes and grid are those of the box around all parts", "[engine][parts]") {
    const shapes::Soup low = shapes::box({0, 0, 0}, {4, 4, 1});
    const shapes::Soup high = shapes::box({0, 0, 2.1}, {1500, 4, 3});
    const SliceResult result = sliced(Parts{part_of(high), part_of(low)}, uniform(0.2));
    CHECK(result.info.grid_mm == 2 * lamella::default_grid_mm);
    REQUIRE(result.layers.size() == 15);
    const SliceResult whole = sliced(shapes::joined({high, low}), uniform(0.2));
    REQUIRE(whole.layers.size() == 15);
    for (std::size_t l = 0; l < 15; ++l) {
        CHECK(result.layers[l].plane == whole.layers[l].plane);
        CHECK(result.layers[l].bottom_mm == whole.layers[l].bottom_mm);
        CHECK(result.layers[l].segments == whole.layers[l].segments);
        CHECK(contours_at(result, l) == contours_at(whole, l));  // they never share a layer
    }
    CHECK(parts_in(result, 0) == Names{1});
    CHECK(parts_in(result, 14) == Names{0});
    // Its far end is at the grid's very limit, which a grid chosen by the mesh takes.
    const shapes::Soup far = shapes::box({0, 0, 0}, {1024, 4, 1});
    CHECK(sliced(Parts{part_of(far), part_of(low)}, uniform(0.5)).info.grid_mm == lamella::default_grid_mm);
    CHECK(sliced(Parts{part_of(low), part_of(low)}, uniform(0.5, lamella::finest_grid)).info.grid_mm ==
          sliced(low, uniform(0.5, lamella::finest_grid)).info.grid_mm);
}

TEST_CASE("a part's placement is a transform of the mesh", "[engine][parts]") {
    const shapes::Soup soup = shapes::octasphere({1, 2, 3}, 10, 4);
    const std::vector<float> floats = shapes::floats(soup);
    SliceOptions turned = uniform(0.1);
    turned.frame.transform = GENERATE(lamella::Transform{}, lamella::Transform::from_normal(1, 2, 3));
    for (const lamella::MeshView& mesh : {view_of(soup), view_of(floats)}) {
        const SliceResult alone = sliced(mesh, turned);
        const SliceResult placed = sliced(Parts{{mesh, turned.frame.transform}}, uniform(0.1));
        CHECK(placed.hash() == alone.hash());
        CHECK(placed.info.options.frame.transform.is_identity());
        CHECK(sliced(Parts{{mesh, {}}}, turned).hash() == alone.hash());
    }
}

TEST_CASE("rules are done to each part by itself", "[engine][parts]") {
    // Two cubes that overlap are one region where they are one part, and two where they are two.
    const shapes::Soup left = shapes::box({0, 0, 0}, {10, 10, 10});
    const shapes::Soup right = shapes::box({5, 0, 0}, {15, 10, 10});
    SliceOptions options = at_heights({5});
    options.region.fill_rule = FillRule::non_zero;
    const shapes::Soup both = shapes::joined({left, right});
    const SliceResult joined = sliced(Parts{part_of(both), part_of(right)}, options);
    CHECK(parts_in(joined, 0) == Names{0, 1});
    CHECK(joined[0].area_mm2() == 150 + 100);
    const SliceResult apart = sliced(Parts{part_of(left), part_of(right)}, options);
    CHECK(contours_at(apart, 0)[1] == contours_at(sliced(right, options), 0)[0]);
    CHECK(apart[0].area_mm2() == 200);
}

TEST_CASE("equal parts keep a contour each, and gaps are listed by layer", "[engine][parts]") {
    const shapes::Soup open = shapes::without(shapes::box({0, 0, 0}, {10, 10, 10}), 4, 2);  // no front
    SliceOptions options = at_heights({2, 5});
    options.stitch_mm = 20;
    const SliceResult result = sliced(Parts{part_of(open), part_of(open)}, options);
    CHECK(parts_in(result, 1) == Names{0, 1});
    REQUIRE(result.stitches.size() == 4);
    CHECK(result.stitches[1].layer == 0);
    CHECK(result.stitches[2].layer == 1);
    CHECK(result.info.options.stitch_mm == 20);
}

TEST_CASE("what is wrong with a part is said of that part", "[engine][parts]") {
    const shapes::Soup good = shapes::box({0, 0, 0}, {4, 4, 4});
    shapes::Soup bad = good;
    bad[40] = std::nan("");
    const shapes::Soup none;
    const shapes::Soup dust = shapes::box({0, 0, 0}, {1e-9, 1e-9, 1e-9});
    SliceOptions closing = uniform(1);
    closing.region.closing_mm = -1;
    const std::tuple<Parts, SliceOptions, ErrorCode, const char*> cases[] = {
        {{}, uniform(1), ErrorCode::invalid_argument, ""},
        {{part_of(good), part_of(bad)}, uniform(1), ErrorCode::bad_coordinate, "part 1: triangle 4, "},
        {{part_of(good), part_of(none)}, uniform(1), ErrorCode::empty_mesh, "part 1: the mesh has no triangles"},
        {{part_of(dust), part_of(good)}, uniform(1), ErrorCode::empty_mesh, "part 0: each of 12 triangles has"},
        {{part_of(good)}, uniform(-1), ErrorCode::invalid_argument, "the layer height must be positive"},
        {{part_of(bad)}, closing, ErrorCode::invalid_argument, "the closing radius"}};
    for (const auto& [parts, options, code, message] : cases) {
        const lamella::Error error = failure_of(parts, options);
        CHECK(error.code == code);
        CHECK_THAT(error.message, Catch::StartsWith(message));
        CHECK((code != ErrorCode::bad_coordinate || error.triangle == 4));
    }
}

TEST_CASE("parts have origins, though no plane meets the first", "[engine][parts][origins]") {
    const shapes::Soup low = shapes::box({0, 0, 0}, {1, 1, 1});
    const shapes::Soup high = shapes::box({0, 0, 5}, {1, 1, 7});
    const Parts parts = {part_of(low), part_of(high)};
    SliceOptions options;
    options.heights_mm = std::vector<double>{6};
    options.origins = true;
    const SliceResult result = sliced(parts, options);
    REQUIRE(result.origins.size() == result.points.size());
    CHECK(result.origins[0].part == 1);
}

TEST_CASE("the memory limit is for all parts", "[engine][parts][errors]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 4, 100});
    const std::uint64_t contents = 10'000 * (8 * sizeof(lamella::Point) + sizeof(Contour));
    const std::uint64_t layers = 10'000 * sizeof(lamella::Layer);
    const std::uint64_t limit = layers + 2 * contents;
    const Parts two = {part_of(soup), part_of(soup)};
    CHECK(sliced(two, uniform(0.01), {.memory_limit_bytes = limit}).contours.size() == 20'000);
    const lamella::Context smaller{.memory_limit_bytes = limit - 1};
    CHECK(failure_of(two, uniform(0.01), smaller).code == ErrorCode::result_too_large);
    CHECK(sliced(Parts{part_of(soup)}, uniform(0.01), smaller).contours.size() == 10'000);
}

TEST_CASE("a broken order of parts is found", "[engine][parts][validate]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    const auto damaged = [&](void (*damage)(SliceResult&)) {
        SliceResult result = sliced(Parts{part_of(cube), part_of(cube, moved_by(20, 0, 0)), part_of(cube)}, at_heights({5}));
        damage(result);
        const lamella::Status status = audits::structure_of(result);
        return status ? std::string("valid") : status.error().message;
    };
    CHECK(damaged([](SliceResult&) {}) == "valid");
    CHECK_THAT(damaged([](SliceResult& r) { r.info.part_count = 2; }), Catch::Contains("the part is none"));
    CHECK_THAT(damaged([](SliceResult& r) { r.contours[2].part = 0; }), Catch::Contains("not in the order of parts"));
    CHECK_THAT(damaged([](SliceResult& r) { r.contours[2].parent = 0; }), Catch::Contains("the parent is of another part"));
}

TEST_CASE("united parts are the region of one mesh that has all of them", "[engine][parts][regions]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    const shapes::Soup other = shapes::octasphere({3, 1, 2.03}, 9, 4);
    const shapes::Soup small = shapes::octasphere({-2, 0, 1.01}, 2, 3);
    const shapes::Soup inverted = shapes::flipped(shapes::octasphere({1, 12, 0.7}, 6, 3));
    SliceOptions options = uniform(0.1);
    options.region.fill_rule = GENERATE(FillRule::even_odd, FillRule::non_zero, FillRule::positive);
    const SliceResult whole = sliced(shapes::joined({ball, other, small, inverted}), options);
    const Parts given = {part_of(ball), part_of(other), part_of(small), part_of(inverted)};
    const SliceResult parts = united(given, options);
    CHECK(parts.contours.size() == whole.contours.size());
    CHECK(parts.info.part_count == 4);
    CHECK(parts.info.holes == whole.info.holes);
    CHECK(parts.info.emptied_layers == whole.info.emptied_layers);
    CHECK(united(given, options, {.threads = 3}).hash() == parts.hash());
    options.unite_parts = false;
    CHECK(sliced(given, options, {.threads = 1}).hash() == sliced(given, options, {.threads = 5}).hash());
    CHECK(hash_without_parts(united({part_of(inverted), part_of(small), part_of(other), part_of(ball)}, options)) ==
          whole.hash());
}

TEST_CASE("a contour of united parts names the part that all its edges come from", "[engine][parts][regions]") {
    using shapes::box;
    SliceOptions options = at_heights({5});
    options.region.fill_rule = FillRule::non_zero;
    const shapes::Soup u =
        shapes::joined({box({0, 0, 0}, {2, 10, 10}), box({1, 0, 0}, {9, 2, 10}), box({8, 0, 0}, {10, 10, 10})});
    const shapes::Soup tube = shapes::joined({box({0, 0, 0}, {10, 10, 10}), shapes::flipped(box({3, 3, 0}, {7, 7, 10}))});
    const shapes::Soup apart = box({20, 0, 0}, {24, 4, 10});
    const std::tuple<shapes::Soup, shapes::Soup, Lines> cases[] = {
        // A bar across a U: the hole between them has edges of both.
        {u, box({-2, 6, 0}, {12, 8, 10}), {"outer several", "hole several"}},
        // Joined by its own part alone, and a part that meets nothing.
        {apart, u, {"outer 1", "outer 0"}},
        // The hole of part 0 is its own, though part 1 makes its outer one larger.
        {tube, box({9, 4, 0}, {15, 6, 10}), {"outer several", "hole 0"}},
        // Equal contours are of all their parts; of an enclosed one none is seen.
        {apart, apart, {"outer several"}},
        {box({21, 1, 0}, {22, 2, 10}), apart, {"outer 1"}}};
    for (const auto& [first, second, expected] : cases) {
        CHECK(named_at(united({part_of(first), part_of(second)}, options), 0) == expected);
    }
}

TEST_CASE("open polylines of united parts stay as they are", "[engine][parts][regions]") {
    const shapes::Soup post = shapes::box({2, 2, 0}, {4, 4, 10});
    const shapes::Soup open = shapes::without(shapes::box({0, 0, 0}, {10, 10, 10}), 4, 2);  // no front
    SliceOptions options = at_heights({5});
    options.region.fill_rule = FillRule::positive;
    const SliceResult result = united({part_of(post), part_of(open)}, options);
    CHECK(named_at(result, 0) == Lines{"outer 0", "open 1"});
    CHECK(result.info.open_contours == 1);
    const SliceResult alone = sliced(open, options);
    CHECK(contours_at(result, 0)[1] == contours_at(alone, 0)[0]);
    options.stitch_mm = 20;
    const SliceResult closed = united({part_of(post), part_of(open)}, options);
    CHECK(named_at(closed, 0) == Lines{"outer 1"});
    CHECK(closed.stitches.size() == 1);
}

TEST_CASE("parts are united by a fill rule only", "[engine][parts][regions]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    SliceOptions options = at_heights({5});
    options.region.fill_rule = FillRule::positive;
    options.region.fill_from = {{4, FillRule::contours}};
    const Parts parts = {part_of(cube), part_of(cube)};
    options.unite_parts = true;
    const lamella::Error refused = failure_of(parts, options);
    CHECK(refused.code == ErrorCode::invalid_argument);
    CHECK_THAT(refused.message, Catch::StartsWith("uniting parts needs a region, but layer 4 has"));
    options.region = {};
    CHECK(failure_of(parts, options).code == ErrorCode::invalid_argument);
    options.unite_parts = false;
    CHECK(slice(parts, options).ok());
}
