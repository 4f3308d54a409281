// Several meshes in one result.
#include <numeric>

#include <catch2/catch.hpp>

#include "engine/everywhere.hpp"

using namespace lamella;

namespace {

Part part_of(const shapes::Soup& soup, const Transform& transform = {}) {
    return {view_of(soup), transform};
}

Transform moved_by(double x, double y, double z) {
    return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}

using Parts = std::vector<Part>;
SliceResult united(const Parts& parts, SliceOptions options, const Context& context = {}) {
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
        names.push_back(word_of(contour.role) +
                        (contour.part == several_parts ? " several" : " " + std::to_string(contour.part)));
    }
    return names;
}

using Lines = std::vector<std::string>;

TEST_CASE("parts are cut as each is alone, at the planes and on the grid of the box around all, and lie side by side",
          "[engine][parts]") {
    const shapes::Soup ball = shapes::octasphere({1, 2, 3}, 10, 4);
    const shapes::Soup torn = shapes::without(ball, 40, 30);
    const shapes::Soup bar = shapes::box({-4, 4, 0.5}, {40, 6, 20});
    const shapes::Soup far = shapes::box({0, 0, 21}, {1500, 4, 25});  // for which the grid is coarser
    const Parts parts = {part_of(ball), part_of(bar, Transform::from_normal(1, 2, 30)),
                         part_of(torn), part_of(far),
                         part_of(bar),  part_of(torn, moved_by(3, 0, 0.25))};
    const shapes::Soup within = shapes::joined({ball, shapes::box({0, 0, -7}, {1500, 4, 25})});
    const SliceResult plan = sliced(within, uniform(0.2));
    for (const RegionRules& rules :
         {RegionRules{}, {.fill_rule = FillRule::non_zero, .closing_mm = 0.5, .simplify_mm = 0.05}}) {
        SliceOptions options{.layer_height_mm = 0.2, .stitch_mm = 5, .origins = true, .region = rules};
        const SliceResult whole = sliced(parts, options, {.threads = 3});
        CHECK(whole.info.part_count == parts.size());
        CHECK(whole.info.grid_mm == 2 * default_grid_mm);
        REQUIRE(whole.size() == plan.size());
        options.frame.grid_mm = whole.info.grid_mm;
        options.heights_mm.emplace();
        for (const Layer& layer : whole.layers) {
            options.heights_mm->push_back(layer.plane_mm);
        }
        std::vector<std::size_t> contours(whole.size(), 0);
        std::vector<std::size_t> points(whole.size(), 0);
        std::size_t stitches = 0;
        for (std::uint32_t p = 0; p < parts.size(); ++p) {
            options.frame.transform = parts[p].placement;
            SliceResult alone = sliced(parts[p].mesh, options);
            stitches += alone.stitches.size();
            std::for_each(alone.contours.begin(), alone.contours.end(), [p](Contour& own) { own.part = p; });
            for (PointOrigin& origin : alone.origins) {
                origin.part = static_cast<std::uint16_t>(origin.triangle == no_triangle ? 0 : p);
            }
            for (std::size_t l = 0; l < whole.size(); ++l) {
                const LayerView own = alone[l];
                LayerView found = whole[l];
                REQUIRE(found.plane == plan.layers[l].plane);
                static_cast<Layer&>(found) = own;
                found.first_contour = whole.layers[l].first_contour + contours[l];
                found.first_point += points[l];
                found.contours = found.contours.subspan(std::exchange(contours[l], contours[l] + own.contours.size()),
                                                        own.contours.size());
                found.origins = found.origins.subspan(points[l], own.points.size());
                found.points =
                    found.points.subspan(std::exchange(points[l], points[l] + own.points.size()), own.points.size());
                found.stitches = own.stitches;
                REQUIRE(is_same(found, own));
            }
        }
        CHECK(std::accumulate(contours.begin(), contours.end(), std::size_t{0}) == whole.contours.size());
        CHECK(stitches == whole.stitches.size());
        CHECK(std::is_sorted(whole.stitches.begin(), whole.stitches.end(),
                             [](const Stitch& x, const Stitch& y) { return x.layer < y.layer; }));
        CHECK_FALSE(audits::ledger_of(whole, view_of(ball)).ok());
        CHECK_FALSE(audits::volume_of(whole, view_of(ball)).ok());
    }
    // Its far end is at the grid's very limit, which a grid chosen by the mesh takes.
    const shapes::Soup limit = shapes::box({0, 0, 0}, {1024, 4, 1});
    CHECK(sliced(Parts{part_of(limit), part_of(bar)}, uniform(0.5)).info.grid_mm == default_grid_mm);
    CHECK(sliced(Parts{part_of(bar), part_of(bar)}, uniform(0.5, finest_grid)).info.grid_mm ==
          sliced(bar, uniform(0.5, finest_grid)).info.grid_mm);
}

TEST_CASE("what is wrong with a part is said of that part", "[engine][parts]") {
    const shapes::Soup good = shapes::box({0, 0, 0}, {4, 4, 4});
    shapes::Soup bad = good;
    bad[40] = std::nan("");
    const shapes::Soup none;
    const shapes::Soup dust = shapes::box({0, 0, 0}, {1e-9, 1e-9, 1e-9});
    const SliceOptions closing{.region = {.closing_mm = -1}};
    const SliceOptions unite{.unite_parts = true};
    const SliceOptions unite_some{.unite_parts = true,
                                  .region = {.fill_rule = FillRule::positive, .fill_from = {{4, FillRule::contours}}}};
    const std::tuple<Parts, SliceOptions, ErrorCode, const char*> cases[] = {
        {{}, uniform(1), ErrorCode::invalid_argument, ""},
        {{part_of(good), part_of(bad)}, uniform(1), ErrorCode::bad_coordinate, "part 1: triangle 4, "},
        {{part_of(good), part_of(none)}, uniform(1), ErrorCode::empty_mesh, "part 1: the mesh has no triangles"},
        {{part_of(dust), part_of(good)}, uniform(1), ErrorCode::empty_mesh, "part 0: each of 12 triangles has"},
        {{part_of(good)}, unite, ErrorCode::invalid_argument, "uniting parts needs a region, but layer 0 has"},
        {{part_of(good)}, unite_some, ErrorCode::invalid_argument, "uniting parts needs a region, but layer 4 has"},
        {{part_of(good)}, uniform(-1), ErrorCode::invalid_argument, "layer_height_mm must be"},
        {{part_of(bad)}, closing, ErrorCode::invalid_argument, "closing_mm must be"}};
    for (const auto& [parts, options, code, message] : cases) {
        const Error error = failure_of(parts, options);
        CHECK(error.code == code);
        CHECK_THAT(error.message, Catch::StartsWith(message));
        CHECK((code != ErrorCode::bad_coordinate || error.triangle == 4));
    }
}

TEST_CASE("the memory limit is for all parts", "[engine][parts][errors]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 4, 100});
    const std::uint64_t contents = 10'000 * (8 * sizeof(Point) + sizeof(Contour));
    const std::uint64_t layers = 10'000 * sizeof(Layer);
    const std::uint64_t limit = layers + 2 * contents;
    const Parts two = {part_of(soup), part_of(soup)};
    CHECK(sliced(two, uniform(0.01), {.memory_limit_bytes = limit}).contours.size() == 20'000);
    const Context smaller{.memory_limit_bytes = limit - 1};
    CHECK(failure_of(two, uniform(0.01), smaller).code == ErrorCode::result_too_large);
    CHECK(sliced(Parts{part_of(soup)}, uniform(0.01), smaller).contours.size() == 10'000);
}

TEST_CASE("a broken order of parts is found", "[engine][parts][validate]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    const auto damaged = [&](void (*damage)(SliceResult&)) {
        SliceResult result = sliced(Parts{part_of(cube), part_of(cube, moved_by(20, 0, 0)), part_of(cube)}, at_heights({5}));
        damage(result);
        const Status status = audits::structure_of(result);
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
    SliceOptions options = uniform(0.1, default_grid_mm);
    options.region.fill_rule = GENERATE(FillRule::even_odd, FillRule::non_zero, FillRule::positive);
    options.region.simplify_mm = GENERATE(0.0, 0.05);
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
    const SliceOptions options{.heights_mm = {{5}}, .region = {.fill_rule = FillRule::non_zero}};
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
    SliceOptions options{.heights_mm = {{5}}, .region = {.fill_rule = FillRule::positive}};
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

}  // namespace
