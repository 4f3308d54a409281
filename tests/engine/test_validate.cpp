// An audit of the structure finds every kind of broken promise. Results are made by hand, then damaged.
#include <cmath>
#include <functional>

#include "engine/slicing.hpp"
#include "lamella/audit.hpp"
#include "lamella/result.hpp"

using namespace lamella;
using audits::made_result;
using Points = std::vector<Point>;

namespace {

Points square(std::int32_t low, std::int32_t high) {
    return {{low, low}, {high, low}, {high, high}, {low, high}};
}

Points clockwise(std::int32_t low, std::int32_t high) {
    return {{low, low}, {low, high}, {high, high}, {high, low}};
}

/// Layer 0: an outer with a hole and an island in the hole; a flat and an open contour. Layer 1: empty. Layer 2: an
/// inverted shell.
SliceResult sound() {
    constexpr unsigned overruled = orientation_overruled;
    return made_result({{{square(0, 20)},
                         {clockwise(4, 16), Role::hole, -1, 0},
                         {square(6, 10), Role::outer, 1, 1},
                         {{{21, 0}, {22, 0}}, Role::flat, 0},
                         {{{30, 0}, {25, 0}, {25, 5}}, Role::open, 0}},
                        {},
                        {{square(0, 20), Role::outer, -1, -1, overruled},
                         {clockwise(4, 8), Role::hole, 1, 5, overruled},
                         {clockwise(10, 14), Role::hole, 1, 5, overruled}}});
}

struct Damage {
    const char* expected;  ///< part of the message
    std::function<void(SliceResult&)> apply;
};

void check_found(const std::vector<Damage>& damages) {
    for (const Damage& damage : damages) {
        SliceResult result = sound();
        damage.apply(result);
        const Status status = audits::structure_of(result);
        INFO("expected: " << damage.expected);
        REQUIRE_FALSE(status.ok());
        CHECK_THAT(status.error().message, Catch::Contains(damage.expected));
    }
}

void swap_contours(SliceResult& result, std::size_t a, std::size_t b) {
    // The point counts are equal, so only the positions of the points are exchanged.
    REQUIRE(result.contours[a].point_count == result.contours[b].point_count);
    const std::uint32_t count = result.contours[a].point_count;
    std::swap_ranges(&result.points[result.contours[a].first_point], &result.points[result.contours[a].first_point] + count,
                     &result.points[result.contours[b].first_point]);
    std::swap(result.contours[a], result.contours[b]);
    std::swap(result.contours[a].first_point, result.contours[b].first_point);
}

TEST_CASE("a valid result passes", "[result][validate]") {
    require_ok(audits::structure_of(sound()));
    CHECK(audits::structure_of(SliceResult()).ok());
}

TEST_CASE("broken offsets and planes are found", "[result][validate]") {
    check_found({
        {"layer 2: does not begin", [](SliceResult& r) { ++r.layers[2].first_contour; }},
        {"reaches past the last contour", [](SliceResult& r) { r.layers[2].contour_count = ~std::uint64_t{0}; }},
        {"left over", [](SliceResult& r) { --r.layers[2].contour_count; }},
        {"contour 1: does not begin", [](SliceResult& r) { ++r.contours[1].first_point; }},
        {"reaches past the last point", [](SliceResult& r) { r.contours[7].point_count = ~std::uint32_t{0}; }},
        {"left over", [](SliceResult& r) { r.contours[7].point_count = 3; }},
        {"layer 1: the plane is not above", [](SliceResult& r) { r.layers[1].plane = r.layers[0].plane; }},
        {"layer 1: the plane is not between", [](SliceResult& r) { r.layers[1].top_mm = 2.5; }},
        {"the summary", [](SliceResult& r) { ++r.info.holes; }},
        {"the summary", [](SliceResult& r) { --r.info.segments; }},
        {"the summary", [](SliceResult& r) { r.info.open_contours = 0; }},
        {"the summary", [](SliceResult& r) { r.info.overruled_contours = 1; }},
        {"the summary", [](SliceResult& r) { r.info.would_close_contours = 1; }},
        {"the summary", [](SliceResult& r) { r.contours[0].flags |= would_close; }},
        {"the summary", [](SliceResult& r) { r.info.emptied_layers = 1; }},
    });
}

TEST_CASE("broken contours are found", "[result][validate]") {
    check_found({
        {"layer 0, contour 0: equal consecutive", [](SliceResult& r) { r.points[2] = r.points[1]; }},
        {"contour 0: the first point is repeated", [](SliceResult& r) { r.points[3] = r.points[0]; }},
        {"contour 0: does not start", [](SliceResult& r) { std::rotate(&r.points[0], &r.points[1], &r.points[0] + 4); }},
        {"contour 3: does not start", [](SliceResult& r) { r.points[12].x = 23; }},
        {"contour 0: the area", [](SliceResult& r) { r.points[2].x += 1; }},
        {"contour 5: the area", [](SliceResult& r) { r.contours[5].twice_area.high = 1; }},
        {"contour 4: the area", [](SliceResult& r) { r.contours[4].twice_area.low = 1; }},
        {"contour 2: the area's sign", [](SliceResult& r) { r.contours[2].role = Role::hole; }},
        {"contour 0: the area's sign", [](SliceResult& r) { r.contours[0].role = Role::flat; }},
        {"contour 0: more points", [](SliceResult& r) { r.contours[0].segments = 3; }},
        {"contour 4: more points", [](SliceResult& r) { r.contours[4].segments = 1; }},
        {"contour 3: no segments", [](SliceResult& r) { r.contours[3].segments = 0; }},
        {"layer 0: contours do not use", [](SliceResult& r) { ++r.contours[2].segments; }},
        {"layer 0: contours do not use", [](SliceResult& r) { ++r.layers[0].segments; }},
        {"contour 0: runs against", [](SliceResult& r) { r.contours[0].orientation = -1; }},
        {"contour 0: closed with an area", [](SliceResult& r) { r.contours[0].orientation = 0; }},
        {"contour 4: flat or open", [](SliceResult& r) { r.contours[4].orientation = 1; }},
        {"contour 3: flat or open", [](SliceResult& r) { r.contours[3].parent = 0; }},
        {"there is no such part", [](SliceResult& r) { r.info.options.unite_parts = true, r.contours[2].part = 1; }},
        {"contour 2: an unknown", [](SliceResult& r) { r.contours[2].flags = 16; }},
        {"contour 2: an unknown", [](SliceResult& r) { r.contours[2].role = static_cast<Role>(4); }},
    });
}

TEST_CASE("broken nesting and order are found", "[result][validate]") {
    check_found({
        {"contour 2: the parent is not", [](SliceResult& r) { r.contours[2].parent = 0; }},
        {"contour 2: the parent is not", [](SliceResult& r) { r.contours[2].parent = -1; }},
        {"contour 0: the parent is not", [](SliceResult& r) { r.contours[0].parent = 0; }},
        {"contour 2: the parent is not", [](SliceResult& r) { r.contours[2].parent = 3; }},
        {"contour 6: the parent lies", [](SliceResult& r) { r.contours[6].parent = 0; }},
        {"contour 0: the parent lies", [](SliceResult& r) { r.contours[0].parent = 8; }},
        {"contour 2: the role", [](SliceResult& r) { r.contours[2].flags = orientation_overruled; }},
        {"contour 6: the role", [](SliceResult& r) { r.contours[6].orientation = -1, r.contours[6].flags = 0; }},
        {"contour 7: contours are not in the order", [](SliceResult& r) { swap_contours(r, 6, 7); }},
        {"contour 2: a hole that",
         [](SliceResult& r) {
             swap_contours(r, 1, 2);
             r.contours[1].parent = 2;
         }},
    });
}

TEST_CASE("the smallest contour around a start is its parent, among any number, and not one through it",
          "[result][validate]") {
    audits::MadeLayer layer = {{square(0, 1000)}};
    for (std::int32_t i = 0; i < 30; ++i) {
        layer.push_back({clockwise(10 + 30 * i, 30 + 30 * i), Role::hole, -1, 0});
    }
    for (std::int32_t i = 0; i < 30; ++i) {
        layer.push_back({square(12 + 30 * i, 20 + 30 * i), Role::outer, 1, 1 + i});
    }
    SliceResult result = made_result({layer});
    require_ok(audits::structure_of(result));
    result.contours[40].parent = 5;
    CHECK_FALSE(audits::structure_of(result).ok());
    // Starts on the first contour's left side, inside its box.
    result = made_result({{{square(0, 20)}, {{{0, 5}, {10, 5}, {10, 10}, {0, 10}}}}});
    require_ok(audits::structure_of(result));
    result.contours[1].parent = 0;
    CHECK_FALSE(audits::structure_of(result).ok());
}

TEST_CASE("areas are summed exactly", "[result]") {
    SliceResult result = sound();
    result.info.grid_mm = 0.5;
    CHECK(std::isnan(result[0].area_mm2()));
    const auto open = std::find_if(result.contours.begin(), result.contours.end(),
                                   [](const Contour& contour) { return contour.role == Role::open; });
    open->role = Role::flat;
    CHECK(result[0].area_mm2() == (400 - 144 + 16) * 0.25);
    CHECK(result[1].area_mm2() == 0);
    CHECK(result[2].area_mm2() == (400 - 16 - 16) * 0.25);
    CHECK(result.contours[1].twice_area.to_double() == -288);
    CHECK(Integer128{0, -1}.to_double() == -0x1p64);
    CHECK(Integer128{~std::uint64_t{0}, -1}.to_double() == -1);
}

TEST_CASE("the hash follows its documented layout", "[result][hash]") {
    const auto fnv = [](std::initializer_list<std::uint64_t> words) {
        std::uint64_t state = 14695981039346656037U;
        for (const std::uint64_t word : words) {
            state = (state ^ word) * 1099511628211U;
        }
        return state;
    };
    CHECK(SliceResult().hash() == fnv({0}));
    const SliceResult result = made_result({{{{{-1, 2}, {0, 3}, {0, 2}}, Role::hole, -1, -1, orientation_mixed}}});
    const std::uint64_t kind = 1 | 0xffU << 8 | 2U << 16;
    const std::uint64_t minus_one = ~std::uint64_t{0};
    CHECK(result.hash() ==
          fnv({1, 1, 1, kind, 3, 3, minus_one, minus_one, minus_one, 0x2'ffffffff, 0x3'00000000, 0x2'00000000}));
}

TEST_CASE("the hash counts parents from the first contour of their layer", "[result][hash]") {
    const auto with_hole = [](std::int64_t contours_below) {
        const audits::MadeLayer below(static_cast<std::size_t>(contours_below), {{{0, 0}, {1, 0}, {0, 1}}});
        SliceResult result =
            made_result({below, {{{{0, 0}, {4, 0}, {0, 4}}}, {{{1, 1}, {1, 2}, {2, 1}}, Role::hole, -1, contours_below}}});
        result.layers[0].contour_count = 0;  // leaves only the numbering of the contours above to differ
        return result.hash();
    };
    CHECK(with_hole(0) == with_hole(2));
}

}  // namespace
