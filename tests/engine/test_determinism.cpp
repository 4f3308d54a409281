// The same mesh gives the same bytes, whatever the threads, bands and forms, and whatever the order of triangles.
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::FillRule;
using lamella::GapSense;
using lamella::SliceOptions;
using lamella::SliceResult;
using shapes::octasphere;

namespace {

/// What is sliced, and how; `changes` an answer by what the options ask for.
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
    SliceOptions filled = uniform(0.3);
    filled.region.fill_rule = FillRule::non_zero;
    std::vector<Ask> asks = {{"outermost", soup, filled},           {"the largest", soup, filled},
                             {"no collinear points", soup, filled}, {"closed", soup, filled},
                             {"closed and eroded", soup, filled},   {"marked", soup, filled},
                             {"rules by layers", soup, filled}};
    asks[0].options.region.fill_rule = FillRule::outermost;
    asks[1].options.region.largest_only = true;
    asks[2].options.region.drop_collinear = true;
    asks[3].options.region.close_mm = asks[4].options.region.close_mm = 0.3;
    asks[4].options.region.offset_mm = -0.4;
    asks[4].options.region.miter_limit = 1.2;
    asks[5].options.region.mark_near_mm = 0.3;
    asks[6].options.region.fill_from = {{5, FillRule::outermost}, {20, FillRule::even_odd}, {33, FillRule::contours}};
    return asks;
}

std::vector<Ask> all_asks() {
    std::vector<Ask> asks = region_asks();
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        asks.push_back({name, mesh, uniform(0.125), false});
    }
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive}) {
        asks.push_back({std::string(lamella::name_of(rule)), tangle_of_balls(), uniform(0.05)});
        asks.back().options.region.fill_rule = rule;
    }
    for (const GapSense sense : {GapSense::kept, GapSense::any}) {
        asks.push_back({"gaps", torn_ball(sense == GapSense::any ? 120 : 60, sense == GapSense::any), uniform(0.05)});
        asks.back().options.close_gaps_mm = 1;
        asks.back().options.gap_sense = sense;
    }
    return asks;
}

void require_same(const SliceResult& found, const SliceResult& expected) {
    REQUIRE(hash_result(found) == hash_result(expected));
    REQUIRE(std::equal(found.closed_gaps.begin(), found.closed_gaps.end(), expected.closed_gaps.begin(),
                       expected.closed_gaps.end(),
                       [](const auto& a, const auto& b) { return a.layer == b.layer && a.from == b.from && a.to == b.to; }));
}

}  // namespace

TEST_CASE("threads, bands, forms and the order of triangles do not change the output", "[engine][determinism][threads]") {
    for (const Ask& ask : all_asks()) {
        const SliceResult expected = sliced(ask.mesh, by({1, 0, lamella::ContourForm::swept}, ask.options));
        INFO(ask.name);
        const double layer_mm = std::get<lamella::UniformLayers>(ask.options.plan.spacing).layer_height_mm;
        CHECK((hash_result(sliced(ask.mesh, uniform(layer_mm))) != hash_result(expected)) == ask.changes);
        std::uint64_t seed = 0;
        for (const Way& way : ways()) {
            INFO(way);
            require_same(value_of(slice(view_of(ask.mesh), by(way, ask.options))), expected);
            if (seed++ % 8 == 0) {
                require_same(sliced(shapes::shuffled(ask.mesh, seed), by(way, ask.options)), expected);
            }
        }
    }
}

TEST_CASE("the order of triangles and of their vertices does not change the output", "[engine][determinism]") {
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        for (const auto& [plan_name, options] : shape_cases::plans()) {
            const std::uint64_t expected = hash_result(sliced(mesh, options));
            for (const std::uint64_t seed : {1U, 2U, 3U}) {
                INFO(mesh_name << ", " << plan_name << ", shuffle " << seed);
                CHECK(hash_result(sliced(shapes::shuffled(mesh, seed), options)) == expected);
            }
        }
    }
}

TEST_CASE("repeated triangles may come in any order", "[engine][determinism]") {
    const shapes::Soup ball = octasphere({0, 0, 0}, 5, 1);
    const shapes::Soup tangle = shapes::random_tetrahedra(3, 6, 4);
    for (const shapes::Soup& mesh : {shapes::joined({ball, ball}), shapes::joined({ball, ball, ball}),
                                     shapes::joined({ball, shapes::flipped(ball), ball}),
                                     shapes::joined({tangle, tangle, shapes::flipped(tangle), tangle})}) {
        const SliceResult result = sliced(mesh, uniform(0.25));
        CHECK(result.summary.open_contours == 0);
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            INFO("shuffle " << seed);
            REQUIRE(hash_result(sliced(shapes::shuffled(mesh, seed), uniform(0.25))) == hash_result(result));
        }
    }
}
