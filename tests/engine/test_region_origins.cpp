// Where the edges of regions come from, and those of several parts.
#include <algorithm>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/origin_oracle.hpp"
#include "engine/rounds.hpp"
#include "engine/slicing.hpp"

using lamella::FillRule;
using lamella::Part;
using lamella::Point;
using lamella::PointOrigin;
using lamella::SliceOptions;
using lamella::SliceResult;
using origin_oracle::Cut;
using origin_oracle::traced;
using origin_oracle::Triangles;

namespace {

SliceOptions filled(SliceOptions options, FillRule rule = FillRule::non_zero) {
    options.region.fill_rule = rule;
    options.origins = true;
    return options;
}

/// By looking at all cuts: of those that the edge lies on, the one of the smallest part and triangle.
std::optional<PointOrigin> origin_along(const std::vector<Cut>& cuts, Point from, Point to) {
    std::optional<PointOrigin> smallest;
    for (const Cut& cut : cuts) {
        if (rings::lies_on(cut.from, cut.to, from) && rings::lies_on(cut.from, cut.to, to) &&
            (!smallest || std::pair(cut.origin.part, cut.origin.triangle) < std::pair(smallest->part, smallest->triangle))) {
            const bool forwards = (std::int64_t{to.x} - from.x) * (std::int64_t{cut.to.x} - cut.from.x) +
                                      (std::int64_t{to.y} - from.y) * (std::int64_t{cut.to.y} - cut.from.y) >
                                  0;
            const Point begin = forwards ? cut.from : cut.to;
            const Point end = forwards ? cut.to : cut.from;
            smallest = cut.origin;
            smallest->edge = begin != from ? lamella::no_edge : (forwards ? cut.origin.edge : cut.origin.end_edge);
            smallest->end_edge = end != to ? lamella::no_edge : (forwards ? cut.origin.end_edge : cut.origin.edge);
        }
    }
    return smallest;
}

/// Requires that each edge of the region has the origin that looking at all cuts finds. Returns how many edges lie on none.
std::size_t check_region(const SliceResult& result, const std::vector<std::vector<Cut>>& cuts_by_layer) {
    std::size_t bent = 0;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        for (const lamella::Contour& contour : result.contours_of(result.layers[l])) {
            const auto points = result.points_of(contour);
            const auto origins = result.origins_of(contour);
            for (std::size_t i = 0; i < points.size(); ++i) {
                const auto along = origin_along(cuts_by_layer[l], points[i], points[i + 1 < points.size() ? i + 1 : 0]);
                INFO("layer " << l << ", edge from " << points[i].x << ", " << points[i].y);
                if (along) {
                    REQUIRE(origins[i] == *along);
                } else {
                    REQUIRE(origins[i].triangle != lamella::no_triangle);
                    ++bent;
                }
            }
        }
    }
    return bent;
}

std::vector<std::vector<Cut>> cuts_of(const shapes::Soup& soup, const SliceResult& result) {
    const Triangles triangles(soup, result);
    std::vector<std::vector<Cut>> cuts;
    for (const lamella::Layer& layer : result.layers) {
        cuts.push_back(triangles.cuts_at(layer.plane));
    }
    return cuts;
}

/// As Triangles::edges_of(), of all parts.
std::vector<Cut> edges_of_parts(const lamella::LayerView& layer, const std::vector<const Triangles*>& parts) {
    std::vector<Cut> edges;
    for (std::size_t part = 0; part < parts.size(); ++part) {
        const auto is_own = [part](const lamella::Contour& contour) { return contour.part == part; };
        const auto first = std::find_if(layer.contours.begin(), layer.contours.end(), is_own);
        const auto count = std::count_if(layer.contours.begin(), layer.contours.end(), is_own);
        lamella::LayerView own = layer;
        own.contours = {first, first + count};
        const std::vector<Cut> found = parts[part]->edges_of(own);
        edges.insert(edges.end(), found.begin(), found.end());
    }
    std::sort(edges.begin(), edges.end());
    return edges;
}

std::size_t without_triangle(const SliceResult& result) {
    return static_cast<std::size_t>(std::count(result.origins.begin(), result.origins.end(), PointOrigin()));
}

/// Boxes with corners on whole mm, so that their sides cross and coincide exactly.
shapes::Soup random_boxes(std::uint64_t seed, int count) {
    std::uint64_t state = seed;
    const auto draw = [&state](std::uint64_t below) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        return static_cast<double>((state >> 33) % below);
    };
    shapes::Soup boxes;
    for (int i = 0; i < count; ++i) {
        const double x = draw(6);
        const double y = draw(6);
        shapes::append(boxes, shapes::box({x, y, 0}, {x + 1 + draw(4), y + 1 + draw(4), 4}));
    }
    return boxes;
}

}  // namespace

TEST_CASE("edges of a region keep the triangles along which they run", "[engine][origins][regions]") {
    const auto seed = GENERATE(range(1U, 1 + rounds(199)));
    const FillRule rule = GENERATE(FillRule::non_zero, FillRule::even_odd, FillRule::positive);
    const shapes::Soup boxes = random_boxes(seed, 5);
    const SliceResult result = traced(boxes, filled(at_heights({1, 2, 3}), rule));
    CHECK(check_region(result, cuts_of(boxes, result)) == 0);
}

TEST_CASE("bent edges of a region keep the triangle of the edge that was bent", "[engine][origins][regions]") {
    const auto seed = GENERATE(range(1U, 1 + rounds(59)));
    const shapes::Soup tangle = shapes::random_tetrahedra(seed, 6, 9);
    SliceOptions options = filled(at_heights({1.25, 2.75, 4.5, 6.25}, 1.0 / 64));
    const SliceResult result = traced(tangle, options);
    CHECK(without_triangle(result) == 0);
}

TEST_CASE("what offset and closing move comes from no triangle, what they leave keeps its origin",
          "[engine][origins][regions]") {
    const shapes::Soup boxes = shapes::joined(
        {shapes::box({0, 0, 0}, {4, 4, 4}), shapes::box({4.5, 0, 0}, {8, 4, 4}), shapes::box({20, 0, 0}, {24, 4, 4})});
    SliceOptions options = filled(at_heights({2}, 1.0 / 1024));
    SECTION("offset") {
        options.region.offset_mm = 0.25;
        const SliceResult result = traced(boxes, options);
        CHECK(without_triangle(result) == result.points.size());
    }
    SECTION("closing") {
        options.region.closing_mm = 0.5;
        const SliceResult result = traced(boxes, options);
        REQUIRE(result.contours.size() == 2);
        CHECK(without_triangle(result) == result.contours[0].point_count);
        for (const PointOrigin& origin : result.origins_of(result.contours[1])) {
            CHECK(origin.triangle >= 24);
        }
    }
}

TEST_CASE("an edge of several without the points between comes from the first of them", "[engine][origins][regions]") {
    SliceOptions options = filled(at_heights({2}));
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    for (const bool inside_out : {false, true}) {
        const shapes::Soup mesh = inside_out ? shapes::flipped(box) : box;
        INFO("inside out " << inside_out);
        options.region.drop_collinear = false;
        const SliceResult whole = traced(mesh, options);
        options.region.drop_collinear = true;
        const SliceResult dropped = traced(mesh, options);
        REQUIRE(whole.points.size() == 8);
        REQUIRE(dropped.points.size() == 4);
        for (std::size_t i = 0; i < 4; ++i) {
            REQUIRE(dropped.points[i] == whole.points[2 * i]);
            PointOrigin expected = whole.origins[2 * i];
            expected.end_edge = lamella::no_edge;
            CHECK(dropped.origins[i] == expected);
        }
    }
}

TEST_CASE("a fold leaves the origins of the edges beside it", "[engine][origins][regions]") {
    // A block with a notch, whose short floor closing folds into the corner of its walls.
    const shapes::Soup block =
        shapes::walls({{0, 0}, {20, 0}, {20, 10}, {12, 10}, {10.0625, 8}, {9.9375, 8}, {8, 10}, {0, 10}});
    SliceOptions options = filled(at_heights({5}, 1.0 / 1024));
    const SliceResult before = traced(block, options);
    options.region.closing_mm = 0.2;
    const SliceResult after = traced(block, options);
    // Each side has a point in its middle: the floor's three points have become one, and the two edges beside it longer.
    REQUIRE(after.points.size() == before.points.size() - 2);
    CHECK(without_triangle(before) == 0);
    CHECK(without_triangle(after) == 2);
}

TEST_CASE("origins name the part where there are several", "[engine][origins][parts]") {
    const shapes::Soup low = random_boxes(1, 3);
    const shapes::Soup high = random_boxes(2, 3);
    const std::vector<Part> parts = {{.mesh = view_of(low)}, {.mesh = view_of(high)}};
    SliceOptions options = filled(at_heights({1, 3}), FillRule::contours);
    SECTION("separate") {
        const SliceResult both = sliced(parts, options);
        require_ok(audits::structure_of(both, parts));
        const Triangles of_low(low, both, 0);
        const Triangles of_high(high, both, 1);
        for (const lamella::LayerView layer : both) {
            std::vector<Cut> expected = of_low.cuts_at(layer.plane);
            const std::vector<Cut> more = of_high.cuts_at(layer.plane);
            expected.insert(expected.end(), more.begin(), more.end());
            std::sort(expected.begin(), expected.end());
            CHECK(edges_of_parts(layer, {&of_low, &of_high}) == expected);
        }
    }
    SECTION("united") {
        options.region.fill_rule = FillRule::non_zero;
        options.unite_parts = true;
        const SliceResult united = sliced(parts, options);
        require_ok(audits::structure_of(united, parts));
        std::vector<std::vector<Cut>> cuts;
        for (const lamella::Layer& layer : united.layers) {
            cuts.push_back(Triangles(low, united, 0).cuts_at(layer.plane));
            const std::vector<Cut> more = Triangles(high, united, 1).cuts_at(layer.plane);
            cuts.back().insert(cuts.back().end(), more.begin(), more.end());
        }
        CHECK(std::any_of(united.contours.begin(), united.contours.end(),
                          [](const lamella::Contour& contour) { return contour.part == lamella::several_parts; }));
        CHECK(check_region(united, cuts) == 0);
        options.origins = false;
        const SliceResult plain = sliced(parts, options);
        CHECK(plain.origins.empty());
        CHECK(plain.hash() == united.hash());
    }
}

TEST_CASE("more parts than an origin can name are refused", "[engine][origins][parts]") {
    const shapes::Soup one = shapes::triangle({0, 0, 0}, {4, 0, 4}, {0, 4, 4});
    const std::vector<Part> parts(65536, Part{.mesh = view_of(one)});
    SliceOptions options = at_heights({2});
    options.origins = true;
    const lamella::Error error = failure_of(parts, options);
    CHECK(error.code == lamella::ErrorCode::invalid_argument);
    CHECK(error.message == "origins name one of at most 65535 parts, not of 65536");
}
