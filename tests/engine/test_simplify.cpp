// Simplified contours keep what RegionRules::simplify_mm promises.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/simplify_checks.hpp"
#include "engine/slicing.hpp"

using namespace simplify_checks;

TEST_CASE("points of a noisy square within the tolerance go, its corners stay", "[engine][simplify]") {
    Ring square;
    for (int i = 0; i < 100; ++i) {
        square.push_back({i * 1000, i == 0 ? 0 : i * 7919 % 11});
    }
    for (int i = 0; i < 100; ++i) {
        square.push_back({100'000 - i * 7919 % 11 * (i > 0), i * 1000});
    }
    square.push_back({100'000, 100'000});
    square.push_back({50'000, 99'995});
    square.push_back({0, 100'000});
    CHECK(simplify({square}, 12).points_after == 4);
    CHECK(simplify({square}, 3).points_after > 20);
}

TEST_CASE("a circle keeps about as many points as its tolerance needs", "[engine][simplify]") {
    const Comparison sizes = simplify({circle(1e6, 5000)}, 1000);
    const double needed = std::numbers::pi / std::acos(1 - 1000 / 1e6);  // of chords with a sagitta of the tolerance
    CHECK(static_cast<double>(sizes.points_after) >= needed);
    CHECK(static_cast<double>(sizes.points_after) <= 2 * needed);
}

TEST_CASE("rings closer than the tolerance neither meet nor change places", "[engine][simplify]") {
    std::mt19937 random(5);
    std::size_t before = 0;
    std::size_t after = 0;
    for (int turn = 0; turn < 60; ++turn) {
        Rings rings;
        const double apart = 50 + static_cast<double>(random() % 400);
        for (int i = 0; i < 6; ++i) {
            // The same wave with every seed, so that neighbours stay apart.
            std::mt19937 wave(static_cast<unsigned>(turn));
            rings.push_back(wavy_ring(wave, {3, 4}, 4000 + apart * i, 160, 900, apart / 3, i % 2 == 0));
        }
        const Comparison sizes = simplify(rings, static_cast<double>(20 + random() % 1500));
        before += sizes.points_before;
        after += sizes.points_after;
    }
    CHECK(after < before / 2);
}

TEST_CASE("crowds of small contours keep apart under a tolerance larger than they are", "[engine][simplify]") {
    std::mt19937 random(6);
    for (int turn = 0; turn < 30; ++turn) {
        Rings rings{wavy_ring(random, {0, 0}, 3000, 300, 200, 60, false)};
        for (int i = 0; i < 80; ++i) {
            const Point centre{static_cast<std::int32_t>(random() % 8000) - 4000,
                               static_cast<std::int32_t>(random() % 8000) - 4000};
            rings.push_back(wavy_ring(random, centre, 60, 12, 20, 10, i % 2 == 0));
        }
        RegionRules rules;
        rules.fill_rule = turn % 3 == 0 ? FillRule::contours : (turn % 3 == 1 ? FillRule::non_zero : FillRule::even_odd);
        simplify(rings, static_cast<double>(10 + random() % 3000), rules);
    }
}

TEST_CASE("contours that cross or touch keep their points where they do", "[engine][simplify]") {
    std::mt19937 random(7);
    int fewer = 0;
    for (int turn = 0; turn < 40; ++turn) {
        Rings rings;
        for (int i = 0; i < 5; ++i) {
            const Point centre{static_cast<std::int32_t>(random() % 40), static_cast<std::int32_t>(random() % 40)};
            rings.push_back(wavy_ring(random, centre, 60, 90, 15, turn % 2 == 0 ? 30 : 3, false));
        }
        const Comparison sizes = simplify_as_given(rings, 1 + static_cast<std::int64_t>(random() % 12));
        fewer += sizes.points_after < sizes.points_before;
    }
    CHECK(fewer > 20);
}

TEST_CASE("a hole in a bump of its outer stays within", "[engine][simplify]") {
    // The line from (4000, 0) to (6000, 0) would pass below the hole and meet nothing.
    const Ring outer = {{0, 0}, {4000, 0}, {4500, -500}, {5500, -500}, {6000, 0}, {10'000, 0}, {10'000, 9000}, {0, 9000}};
    const Ring hole = {{4900, -300}, {4950, -200}, {5050, -300}};
    CHECK(simplify({outer}, 600).points_after == 4);
    const LayerContours both = region_by({outer, hole}, simplified_by(600));
    REQUIRE(both.contours.size() == 2);
    CHECK(both.contours[1].role == Role::hole);
    simplify({outer, hole}, 600);
}

TEST_CASE("a crescent thinner than the tolerance keeps its orientation", "[engine][simplify]") {
    Ring crescent;
    for (int i = -50; i <= 50; ++i) {
        crescent.push_back({i * 100, i * i * 2});
    }
    for (int i = 49; i > -50; --i) {
        crescent.push_back({i * 100, i * i * 2 - (2500 - i * i) / 50 + 60});
    }
    for (const double tolerance : {10.0, 100.0, 1000.0, 1e5}) {
        simplify({crescent}, tolerance);
        std::reverse(crescent.begin(), crescent.end());
        simplify({crescent}, tolerance);
    }
}

TEST_CASE("a contour of two lobes keeps the sign of its area though the larger one shrinks", "[engine][simplify]") {
    // Counter-clockwise around the left lobe, clockwise around the right one, which is smaller by less than the lines cut
    // off.
    Ring lobes;
    for (int degrees = 10; degrees <= 350; ++degrees) {
        const double angle = degrees * std::numbers::pi / 180;
        lobes.push_back({static_cast<std::int32_t>(std::lround(1000 * std::cos(angle))) - 1000,
                         static_cast<std::int32_t>(std::lround(1000 * std::sin(angle)))});
    }
    const std::size_t left = lobes.size();
    std::int32_t width = 100;
    do {
        lobes.resize(left);
        lobes.insert(lobes.end(), {{15, 174}, {width, 174}, {width, -174}, {15, -174}});
        ++width;
    } while (lamella::to_int128(lamella::closed_item(lobes).twice_area) > 1000);
    REQUIRE(lamella::to_int128(lamella::closed_item(lobes).twice_area) > 0);
    const Comparison sizes = simplify_as_given({lobes}, 10);
    CHECK(sizes.points_after < sizes.points_before);
}

TEST_CASE("contours as wide as the grid are simplified exactly", "[engine][simplify]") {
    constexpr std::int32_t far = lamella::grid_limit;
    const Ring square = {{-far, -far}, {0, -far + 1000}, {far, -far}, {far - 1000, 0},
                         {far, far},   {5, far - 1001},  {-far, far}};
    CHECK(simplify({square}, 1000).points_after == 5);
    CHECK(simplify({square}, 1001).points_after == 4);
    CHECK(simplify({square}, 999).points_after == 7);
}

TEST_CASE("layers of solids and open polylines are simplified alike on any number of threads", "[engine][simplify]") {
    for (const bool open : {false, true}) {
        shapes::Soup soup = shapes::octasphere({0, 0, 0}, 20, 6);
        soup.resize(open ? soup.size() / 9 * 7 / 10 * 9 : soup.size());
        lamella::SliceOptions options;
        options.plan.spacing = lamella::UniformLayers{.layer_height_mm = 1.5};
        options.control.threads = 1;
        const auto before = value_of(lamella::slice(view_of(soup), options));
        options.region.simplify_mm = 0.05;
        const auto after = value_of(lamella::slice(view_of(soup), options));
        CHECK((before.summary.open_contours > 0) == open);
        CHECK(after.points.size() < before.points.size() / 2);
        for (std::size_t l = 0; l < before.layers.size(); ++l) {
            compare(before.contours_of(before.layers[l]), {before.points.data(), before.points.size()},
                    after.contours_of(after.layers[l]), {after.points.data(), after.points.size()},
                    std::floor(0.05 / before.unit_mm));
        }
        CHECK(lamella::validate(after).ok());
        for (const int threads : {2, 3}) {
            options.control.threads = threads;
            const auto again = value_of(lamella::slice(view_of(soup), options));
            CHECK(lamella::hash_result(again) == lamella::hash_result(after));
        }
    }
}

TEST_CASE("a tolerance that is no length, or under the grid unit, is refused", "[engine][simplify]") {
    const Rings rings{circle(100, 20)};
    RegionRules rules;
    for (const double bad : {-1.0, std::nan(""), unit_mm / 2}) {
        rules.simplify_mm = bad;
        const auto made = regions::region(rings, rules);
        REQUIRE(!made.ok());
        CHECK(made.error().code == lamella::ErrorCode::invalid_argument);
        CHECK(made.error().message.find("the tolerance of simplification") != std::string::npos);
    }
}
