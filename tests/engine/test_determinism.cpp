// The same mesh gives the same bytes, whatever the threads, bands and forms, and whatever the order of triangles.
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/same_result.hpp"
#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::FillRule;
using lamella::LayerContent;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::StitchDirection;
using shapes::octasphere;

namespace {

/// A mesh and how it is sliced; `changes` the answer by what the options ask for.
struct Ask {
    std::string name;
    shapes::Soup mesh;
    SliceOptions options;
    bool changes = true;
};

/// Overlapping balls, one in four inside out.
shapes::Soup tangle_of_balls() {
    std::mt19937 random(4);
    const auto place = [&] { return static_cast<double>(random() % 4000) / 1000.0; };
    shapes::Soup soup;
    for (int i = 0; i < 12; ++i) {
        const shapes::Soup ball = octasphere({place(), place(), place()}, 2, 2);
        soup = shapes::joined({soup, i % 4 == 3 ? shapes::flipped(ball) : ball});
    }
    return soup;
}

/// A ball that lacks some of its facets; with `turned`, a third of the others is turned round.
shapes::Soup torn_ball(int lost, bool turned) {
    shapes::Soup soup = octasphere({0, 0, 0}, 10, 4);
    std::mt19937 random(8);
    for (; lost > 0; --lost) {
        soup = shapes::without(soup, random() % (soup.size() / 9), 1);
    }
    for (std::size_t t = 0; turned && t < soup.size() / 9; ++t) {
        if (random() % 3 == 0) {
            std::swap_ranges(&soup[9 * t], &soup[9 * t] + 3, &soup[9 * t] + 3);
        }
    }
    return soup;
}

std::vector<Ask> region_asks() {
    const shapes::Soup soup = shapes::joined({octasphere({0, 0, 0}, 10, 3), octasphere({12, 3, 1}, 7, 2),
                                              shapes::flipped(octasphere({1, 0, 0}, 4, 2)),
                                              shapes::box({19.05, -3, -8}, {25, 3, 8}), octasphere({30, 0, 0}, 4.95, 3)});
    constexpr FillRule united = FillRule::non_zero;
    const std::pair<const char*, lamella::RegionRules> rules[] = {
        {"outermost", {.fill_rule = FillRule::outermost}},
        {"the largest", {.fill_rule = united, .largest_only = true}},
        {"no collinear points", {.fill_rule = united, .drop_collinear = true}},
        {"closed", {.fill_rule = united, .closing_mm = 0.3}},
        {"closed and eroded", {.fill_rule = united, .closing_mm = 0.3, .offset_mm = -0.4, .miter_limit = 1.2}},
        {"marked", {.fill_rule = united, .flag_closing_mm = 0.3}},
        {"rules by layers",
         {.fill_rule = united, .fill_from = {{5, FillRule::outermost}, {20, FillRule::even_odd}, {33, FillRule::contours}}}},
    };
    std::vector<Ask> asks;
    for (const auto& [name, region] : rules) {
        asks.push_back({name, soup, uniform(0.3)});
        asks.back().options.region = region;
    }
    return asks;
}

std::vector<Ask> all_asks() {
    std::vector<Ask> asks = region_asks();
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        for (const auto& [plan, options] : shape_cases::plans(mesh)) {
            asks.push_back({name + ", " + plan, mesh, options, false});
        }
    }
    for (const LayerContent content : {LayerContent::upward_faces, LayerContent::downward_faces}) {
        asks.push_back({"faces", tangle_of_balls(), {.layer_height_mm = 0.3, .content = content}, false});
        asks.push_back({"faces", torn_ball(60, true), {.layer_height_mm = 40, .content = content}, false});
    }
    const shapes::Soup ball = octasphere({0, 0, 0}, 5, 1);
    const shapes::Soup tangle = shapes::random_tetrahedra(3, 6, 4);
    for (const shapes::Soup& repeated : {shapes::joined({ball, ball}), shapes::joined({ball, ball, ball}),
                                         shapes::joined({ball, shapes::flipped(ball), ball}),
                                         shapes::joined({tangle, tangle, shapes::flipped(tangle), tangle})}) {
        asks.push_back({"repeated triangles", repeated, uniform(0.25), false});
    }
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive}) {
        asks.push_back({std::string(lamella::name_of(rule)), tangle_of_balls(), uniform(0.05)});
        asks.back().options.region.fill_rule = rule;
    }
    for (const StitchDirection sense : {StitchDirection::oriented, StitchDirection::any}) {
        asks.push_back(
            {"gaps", torn_ball(sense == StitchDirection::any ? 120 : 60, sense == StitchDirection::any), uniform(0.05)});
        asks.back().options.stitch_mm = 1;
        asks.back().options.stitch_direction = sense;
    }
    return asks;
}

}  // namespace

TEST_CASE("threads, bands, forms and the order of triangles do not change the output", "[engine][determinism][threads]") {
    for (const Ask& ask : all_asks()) {
        const SliceResult expected = sliced(ask.mesh, ask.options, {.threads = 1});
        INFO(ask.name);
        SliceOptions plain = ask.options;
        plain.region = {};
        plain.stitch_mm = 0;
        CHECK((sliced(ask.mesh, plain).hash() != expected.hash()) == ask.changes);
        std::uint64_t seed = 0;
        for (const Way& way : ways()) {
            INFO(way);
            const bool shuffle = seed++ % 8 == 0;
            require_same(sliced(ask.mesh, ask.options, way.context, way.tuning), expected);
            if (shuffle) {
                const shapes::Soup shuffled = shapes::shuffled(ask.mesh, seed);
                require_same(sliced(shuffled, ask.options, way.context, way.tuning), expected);
            }
        }
    }
}
