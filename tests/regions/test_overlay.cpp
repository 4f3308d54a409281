// Layers combined by rules, judged cell by cell: regions on a lattice are sets of triangles, and so are their combinations.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <random>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "engine/counting_memory.hpp"
#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/overlay.hpp"
#include "regions/given.hpp"
#include "regions/lattice.hpp"
#include "regions/region.hpp"

using namespace lamella;
using lattice::Cells;
using lattice::cells_of;
using lattice::winding_around;
using polygons::box;
using regions::Given;
using regions::Polygon;
using regions::Polygons;

namespace {

SliceResult combined(std::span<const LayerSet> sets, const Rule& rule, const RegionRules& after = {},
                     const Context& context = {}) {
    SliceResult result;
    Overlay overlay;
    const auto info = overlay.combine(result, sets, rule, after, context);
    require_ok(info ? Status() : Status(info.error()));
    CHECK(info->contours == result.contours.size());
    require_ok(audits::structure_of(result));
    return result;
}

SliceResult combined(const Polygons& a, const Polygons& b, const Rule& rule) {
    const Given first(a);
    const Given second(b);
    const LayerSet sets[] = {{.layers = first.set}, {.layers = second.set}};
    return combined(sets, rule);
}

Polygon square(std::int32_t low, std::int32_t high) {
    return box(low, low, high, high);
}

/// "outer 4 hole 1": roles and areas in the order of the result.
std::string roles_of(const SliceResult& result) {
    std::string text;
    for (const Contour& contour : result.contours) {
        const double area = std::abs(contour.twice_area.to_double() / 2);
        text += (text.empty() ? "" : ", ") + std::string(word_of(contour.role)) + " " + std::to_string(std::int64_t(area));
    }
    return text;
}

Polygons triangles_of(Cells cells) {
    Polygons all;
    for (int t = 0; t < lattice::triangles; ++t) {
        if ((cells >> t & 1) != 0) {
            const auto corners = lattice::triangle_of(t);
            all.emplace_back(corners.begin(), corners.end());
        }
    }
    return all;
}

/// How often the polygons run around a point; `near` where that lies within two units of an edge.
int winding_around(const Polygons& polygons, Point p, bool& near) {
    int winding = 0;
    for (const Polygon& polygon : polygons) {
        const std::optional<int> own = rings::winding(polygon, p);
        winding += own.value_or(0);
        near = near || !own;
        rings::each_edge(std::span<const Point>(polygon), [&](Point a, Point b) {
            near = near || rings::distance(a, b, {double(p.x), double(p.y)}) < 2;
        });
    }
    return winding;
}

rings::Int128 twice_area_of(const SliceResult& result, std::uint32_t part) {
    rings::Int128 sum = 0;
    for (const Contour& contour : result.contours) {
        sum += contour.part == part ? to_int128(contour.twice_area) : rings::Int128{0};
    }
    return sum;
}

/// Contours of one part of a layer, as a layer of their own.
void check_regions(const SliceResult& result, std::span<const std::uint32_t> parts) {
    for (const std::uint32_t part : parts) {
        Polygons rings;
        for (const Contour& contour : result.contours) {
            const auto points = result.points_of(contour);
            if (contour.part == part) {
                rings.emplace_back(points.begin(), points.end());
            }
        }
        const SliceResult again = value_of(regions::region(rings, {.fill_rule = FillRule::positive}, 1));
        CHECK(again.contours.size() == rings.size());
        CHECK(twice_area_of(again, 0) == twice_area_of(result, part));
    }
}

}  // namespace

TEST_CASE("booleans of squares have the known contours", "[regions][overlay]") {
    const Polygons four = {square(0, 4)};
    CHECK(roles_of(combined(four, {}, unite)) == "outer 16");
    CHECK(roles_of(combined(four, {}, intersect(2))).empty());
    CHECK(roles_of(combined({}, four, subtract)).empty());
    CHECK(roles_of(combined(four, four, unite)) == "outer 16");
    CHECK(roles_of(combined(four, four, intersect(2))) == "outer 16");
    CHECK(roles_of(combined(four, four, subtract)).empty());
    CHECK(roles_of(combined(four, four, exclusive)).empty());
    CHECK(roles_of(combined({square(0, 2)}, {square(2, 4)}, unite)) == "outer 4, outer 4");
    CHECK(roles_of(combined({box(0, 0, 2, 2)}, {box(2, 0, 4, 2)}, unite)) == "outer 8");
    CHECK(roles_of(combined({square(0, 6)}, {square(2, 4)}, subtract)) == "outer 36, hole 4");
    CHECK(roles_of(combined({square(2, 4)}, {square(0, 6)}, subtract)).empty());
    CHECK(roles_of(combined({square(0, 6)}, {box(2, 2, 6, 4)}, subtract)) == "outer 28");
    CHECK(roles_of(combined({square(0, 8)}, {square(2, 4), square(4, 6)}, subtract)) == "outer 64, hole 8");
    CHECK(roles_of(combined({{{0, 0}, {0, 0}, {4, 0}, {4, 4}, {4, 4}, {4, 4}, {0, 4}, {0, 0}}, {}}, {square(1, 3), {{9, 9}}},
                            subtract)) == "outer 16, hole 4");
    Polygon backward = square(0, 4);
    std::reverse(backward.begin(), backward.end());
    CHECK(roles_of(combined({backward}, {square(2, 6)}, intersect(2))) == "outer 4");
    CHECK(roles_of(combined({backward}, {square(6, 8)}, unite)) == "outer 16, outer 4");
}

TEST_CASE("labels share their boundary, and the last set wins where asked", "[regions][overlay]") {
    const Given wide({box(0, 0, 6, 2)});
    const Given inlay({box(2, 0, 4, 2)});
    const LayerSet sets[] = {{.layers = wide.set}, {.layers = inlay.set}};
    const SliceResult result = combined(sets, {.last_wins = true});
    REQUIRE(result.contours.size() == 3);
    CHECK(result.contours[0].part == 0);
    CHECK(result.contours[1].part == 0);
    CHECK(result.contours[2].part == 1);
    CHECK(result.info.part_count == 2);
    CHECK(twice_area_of(result, 0) == 16);
    CHECK(twice_area_of(result, 1) == 8);
    const std::uint32_t labels[] = {0, 1, 2, 3};
    const SliceResult crossing = [&] {
        const Given low({square(0, 4)});
        const Given high({square(2, 6)});
        const LayerSet both[] = {{.layers = low.set}, {.layers = high.set}};
        return combined(both, {.labels = labels});
    }();
    CHECK(twice_area_of(crossing, 0) == 24);
    CHECK(twice_area_of(crossing, 1) == 24);
    CHECK(twice_area_of(crossing, 2) == 8);
}

TEST_CASE("on a lattice every label holds the triangles that the rule gives it", "[regions][overlay]") {
    std::mt19937_64 random(7);
    const int rounds = 300;
    for (int round = 0; round < rounds; ++round) {
        const std::size_t count = 1 + random() % 5;
        std::vector<Cells> cells(count);
        std::vector<std::unique_ptr<Given>> given;
        std::vector<LayerSet> sets;
        for (std::size_t s = 0; s < count; ++s) {
            cells[s] = random() | (random() % 2 != 0 ? random() : 0);
            given.push_back(std::make_unique<Given>(triangles_of(cells[s])));
            sets.push_back({.layers = given.back()->set});
        }
        std::vector<std::uint32_t> labels(std::size_t{1} << count);
        for (std::size_t in = 1; in < labels.size(); ++in) {
            labels[in] = static_cast<std::uint32_t>(random() % 4);
        }
        const SliceResult result = combined(sets, {.labels = labels});
        std::array<Cells, 4> expected{};
        for (int t = 0; t < lattice::triangles; ++t) {
            std::size_t in = 0;
            for (std::size_t s = 0; s < count; ++s) {
                in |= std::size_t{cells[s] >> t & 1} << s;
            }
            expected[labels[in]] |= Cells{1} << t;
        }
        const std::uint32_t parts[] = {0, 1, 2};
        for (const std::uint32_t part : parts) {
            REQUIRE(cells_of(result, part) == expected[part + 1]);
            REQUIRE(twice_area_of(result, part) == std::popcount(expected[part + 1]) * lattice::cell * lattice::cell / 2);
        }
        check_regions(result, parts);
    }
}

TEST_CASE("where stars cross in general, points off all edges have the label of the sets that they lie in",
          "[regions][overlay]") {
    std::mt19937_64 random(11);
    const auto below = [&random](std::int64_t most) { return static_cast<std::int64_t>(random() % std::uint64_t(most)); };
    for (int round = 0; round < 150; ++round) {
        const std::int64_t radius = std::array<std::int64_t, 3>{20, 200, std::int64_t{1} << 28}[std::size_t(round % 3)];
        std::vector<std::unique_ptr<Given>> given;
        std::vector<LayerSet> sets;
        for (int s = 0; s < 3; ++s) {
            Polygons stars;
            for (int i = 0; i < 3; ++i) {
                Polygon star;
                for (int corner = 0; corner < 12; ++corner) {
                    star.push_back({static_cast<std::int32_t>(below(2 * radius) - radius),
                                    static_cast<std::int32_t>(below(2 * radius) - radius)});
                }
                stars.push_back(star);
            }
            given.push_back(std::make_unique<Given>(stars));
            sets.push_back({.layers = given.back()->set, .fill_rule = s == 0 ? FillRule::even_odd : FillRule::non_zero});
        }
        std::uint32_t labels[8] = {};
        for (std::uint32_t in = 1; in < 8; ++in) {
            labels[in] = in;
        }
        const SliceResult result = combined(sets, {.labels = labels});
        for (int i = 0; i < 200; ++i) {
            const Point p{static_cast<std::int32_t>(below(2 * radius) - radius),
                          static_cast<std::int32_t>(below(2 * radius) - radius)};
            std::uint32_t in = 0;
            bool near = false;
            for (std::uint32_t s = 0; s < 3; ++s) {
                const int winding = winding_around(given[s]->polygons, p, near);
                in |= static_cast<std::uint32_t>(regions::fills(sets[s].fill_rule, winding)) << s;
            }
            for (std::uint32_t label = 1; label < 8 && !near; ++label) {
                REQUIRE(winding_around(result, label - 1, p) == (label == in ? 1 : 0));
            }
        }
        // The same of the sets in another order, with labels that say so.
        const LayerSet turned[] = {sets[2], sets[0], sets[1]};
        std::uint32_t others[8];
        for (std::uint32_t in = 0; in < 8; ++in) {
            others[in] = labels[(in >> 1 | in << 2) & 7];
        }
        REQUIRE(combined(turned, {.labels = others}).hash() == result.hash());
        REQUIRE(regions::area_of(combined(sets, unite)) == Approx(regions::area_of(result)));
    }
}

TEST_CASE("as many sets as there may be are told apart", "[regions][overlay]") {
    std::vector<std::unique_ptr<Given>> given;
    std::vector<LayerSet> sets;
    for (std::size_t s = 0; s < most_layer_sets; ++s) {
        given.push_back(std::make_unique<Given>(Polygons{square(0, 4)}));
        sets.push_back({.layers = given.back()->set});
    }
    CHECK(combined(sets, {.last_wins = true}).contours[0].part == most_layer_sets - 1);
    CHECK(roles_of(combined(sets, intersect(most_layer_sets))) == "outer 16");
    CHECK(roles_of(combined(sets, exclusive)) == "outer 16");
    given.back() = std::make_unique<Given>(Polygons{square(2, 6)});
    sets.back() = {.layers = given.back()->set};
    CHECK(roles_of(combined(sets, intersect(most_layer_sets))) == "outer 4");
    auto last = [](std::uint64_t in) noexcept -> std::uint32_t { return in >> (most_layer_sets - 1) != 0 ? 7 : 0; };
    CHECK(roles_of(combined(sets, {.label_of = last})) == "outer 16");
}

TEST_CASE("a stack is combined layer by layer, by any threads and to any destination", "[regions][overlay][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 10}, 10, 4);
    const shapes::Soup bar = shapes::box({-20, -2, 4}, {20, 3, 16});
    const Part parts[] = {{view_of(ball)}, {view_of(bar)}};
    const FillRule rule = GENERATE(FillRule::contours, FillRule::non_zero);
    const SliceResult both = sliced(parts, {.layer_height_mm = 0.5, .region = {.fill_rule = rule}});
    const LayerSet sets[] = {{.layers = both, .part = 0}, {.layers = both, .part = 1}};
    const SliceResult united = combined(sets, unite, {}, {.threads = 1});
    const SliceResult common = combined(sets, intersect(2));
    REQUIRE(united.size() == both.size());
    for (std::size_t n = 0; n < both.size(); ++n) {
        CHECK(united[n].plane_mm == both[n].plane_mm);
        const double sum = both[n].area_mm2();
        CHECK(united[n].area_mm2() + common[n].area_mm2() == Approx(sum).margin(1e-3));
    }
    CHECK(united.hash() == combined(sets, unite, {}, {.threads = 5}).hash());
    const LayerSet swapped[] = {sets[1], sets[0]};
    CHECK(united.hash() == combined(swapped, unite).hash());
    Overlay overlay;
    const CountingMemory memory;
    SliceResult counted;
    REQUIRE(overlay.combine(counted, sets, unite, {}, {.threads = 2, .memory = &memory}).ok());
    CHECK(counted.hash() == united.hash());
    counted = SliceResult();
    overlay.reset();
    CHECK(memory.held() == 0);
    std::size_t taken = 0;
    auto take = [&](const LayerView& layer) noexcept { taken += layer.contours.size(); };
    const auto info = overlay.combine(LayerSink{.take = take}, sets, subtract);
    require_ok(info ? Status() : Status(info.error()));
    CHECK(taken == combined(sets, subtract).contours.size());
}

TEST_CASE("layers above and below count where they are asked for", "[regions][overlay]") {
    const shapes::Soup steps = shapes::joined({shapes::box({0, 0, 0}, {9, 9, 1}), shapes::box({0, 0, 1}, {4, 9, 3})});
    const SliceResult stack = sliced(steps, {.layer_height_mm = 1, .region = {.fill_rule = FillRule::non_zero}});
    REQUIRE(stack.size() == 3);
    const LayerSet tops[] = {{.layers = stack}, {.layers = stack, .from = 1, .to = 1}};
    const SliceResult top = combined(tops, subtract);
    CHECK(top[0].area_mm2() == Approx(45));
    CHECK(top[1].area_mm2() == Approx(0).margin(1e-9));
    CHECK(top[2].area_mm2() == Approx(36));
    const LayerSet bottoms[] = {{.layers = stack}, {.layers = stack, .from = -1, .to = -1, .grow_mm = 1}};
    const SliceResult bottom = combined(bottoms, subtract);
    CHECK(bottom[0].area_mm2() == Approx(81));
    CHECK(bottom[1].contours.empty());
    const LayerSet window[] = {{.layers = stack, .from = -1, .to = 1}};
    CHECK(combined(window, unite)[1].area_mm2() == Approx(81));
    CHECK(combined(window, unite)[2].area_mm2() == Approx(36));
}

TEST_CASE("what cannot be combined is one clear error", "[regions][overlay]") {
    Overlay overlay;
    SliceResult result;
    const auto message = [&](std::span<const LayerSet> sets, const Rule& rule = unite, const RegionRules& after = {}) {
        return error_of(overlay.combine(result, sets, rule, after)).message;
    };
    const Given fine({square(0, 4)}, 0.5);
    const Given coarse({square(0, 4)}, 1);
    const Given far({{{grid_limit + 1, 0}, {0, 4}, {0, 0}}});
    const LayerSet one[] = {{.layers = fine.set}};
    CHECK(message({}) == "from 1 to 63 sets of layers can be combined, not 0");
    const LayerSet grids[] = {{.layers = fine.set}, {.layers = coarse.set}};
    CHECK(message(grids) == "set 1: its grid unit is 1 mm, and another set's 0.5 mm: slice both on one grid");
    const LayerSet beyond[] = {{.layers = far.set}};
    CHECK(message(beyond).find("set 0: a point with the coordinate") == 0);
    const LayerSet none[] = {{.layers = fine.set, .from = 1, .to = 0}};
    CHECK(message(none) == "set 0: layers from 1 to 0 are none");
    const LayerSet outermost[] = {{.layers = fine.set, .fill_rule = FillRule::outermost}};
    CHECK(message(outermost) ==
          "set 0: the fill rule of a set is even-odd, non-zero or positive; others are done to a slice");
    const LayerSet contours[] = {{.layers = fine.set, .fill_rule = FillRule::contours}};
    CHECK(message(contours) ==
          "set 0: the fill rule of a set is even-odd, non-zero or positive; others are done to a slice");
    const LayerSet tiny[] = {{.layers = fine.set, .grow_mm = 0.25}};
    CHECK(message(tiny).find("set 0: the offset of 0.25 mm is under the grid unit") == 0);
    const std::uint32_t labels[] = {1, 1};
    CHECK(message(one, {.labels = labels}) == "what lies in no set has the label 1, but must have none: 0");
    CHECK(message(one, {.labels = std::span(labels).first(1)}).find("a table of labels has 2^n") == 0);
    CHECK(message(one, intersect(2)) == "the rule is about set 1, but there are 1");
    const SliceResult low = sliced(shapes::box({0, 0, 0}, {4, 4, 4}), uniform(1));
    const SliceResult high = sliced(shapes::box({0, 0, 1}, {4, 4, 5}), uniform(1));
    const LayerSet heights[] = {{.layers = low}, {.layers = high}};
    CHECK(message(heights).find("set 1: its layer 0 lies at 1.") == 0);
    CHECK(overlay.combine(result, one, unite, {}, {.threads = -1}).error().code == ErrorCode::invalid_argument);
    SliceResult twice =
        sliced(shapes::box({0, 0, 0}, {4, 4, 4}), {.layer_height_mm = 1, .region = {.fill_rule = FillRule::non_zero}});
    std::reverse(twice.points.data(), twice.points.data() + twice.contours[0].point_count);
    const LayerSet backwards[] = {{.layers = twice}};
    CHECK(message(backwards).find("layer 0: contours of a set wind twice or backwards") == 0);
    constexpr std::uint64_t bytes = 4 * sizeof(Point) + sizeof(Contour);
    const Error too_large = error_of(overlay.combine(result, one, unite, {}, {.memory_limit_bytes = bytes - 1}));
    CHECK(too_large.code == ErrorCode::result_too_large);
    CHECK(too_large.message == "combined layers need more than the memory limit of " + std::to_string(bytes - 1) + " bytes");
    CHECK(overlay.combine(result, one, unite, {}, {.memory_limit_bytes = bytes}).ok());
    const LayerSet own[] = {{.layers = result}};
    CHECK(message(own) == "the answer cannot take the place of one of the sets");
}
