// Simplification within a slice: origins, parts and regions.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"

using lamella::Contour;
using lamella::FillRule;
using lamella::Part;
using lamella::PointOrigin;
using lamella::Role;
using lamella::SliceOptions;
using lamella::SliceResult;

namespace {

/// Two balls that overlap, rough by up to 0.05 mm, and a third one that lacks its upper side.
shapes::Soup rough_balls() {
    shapes::Soup soup = shapes::joined({shapes::octasphere({0, 0, 0}, 10, 5), shapes::octasphere({6, 1, 1}, 8, 5)});
    const std::size_t closed = soup.size();
    const shapes::Soup open = shapes::octasphere({20, 0, 0}, 5, 4);
    soup.insert(soup.end(), open.begin(), open.begin() + static_cast<std::ptrdiff_t>(open.size() / 9 * 7 / 10 * 9));
    for (std::size_t i = 0; i < closed; ++i) {  // by the place, so that equal corners stay equal
        soup[i] += 0.05 * std::sin(soup[i] * 7919);
    }
    return soup;
}

SliceOptions simplified(double tolerance_mm, FillRule rule = FillRule::contours) {
    SliceOptions options = uniform(0.7);
    options.region.fill_rule = rule;
    options.region.simplify_mm = tolerance_mm;
    options.origins = true;
    return options;
}

/// Requires that lines between points that are no neighbours in the plain contour come from no triangle, and that all other
/// edges have the origins of the plain ones. Returns how many such lines there are.
std::size_t check_origins(const SliceResult& plain, const SliceResult& result) {
    REQUIRE(plain.contours.size() == result.contours.size());
    std::size_t lines = 0;
    for (std::size_t c = 0; c < plain.contours.size(); ++c) {
        const auto before = plain.points_of(plain.contours[c]);
        const auto after = result.points_of(result.contours[c]);
        const auto old_origins = plain.origins_of(plain.contours[c]);
        const auto origins = result.origins_of(result.contours[c]);
        const bool open = plain.contours[c].role == Role::open;
        std::size_t at = 0;
        bool after_line = false;
        for (std::size_t i = 0; i < after.size(); ++i) {
            while (at < before.size() && before[at] != after[i]) {
                ++at;
            }
            REQUIRE(at < before.size());
            const bool is_end = open && i + 1 == after.size();
            const bool is_line = !is_end && before[at + 1 < before.size() ? at + 1 : 0] != after[(i + 1) % after.size()];
            REQUIRE(origins[i] == (is_line || (is_end && after_line) ? PointOrigin() : old_origins[at]));
            lines += is_line;
            after_line = is_line;
        }
    }
    return lines;
}

}  // namespace

TEST_CASE("lines that replace points come from no triangle, all other edges keep theirs", "[engine][simplify][origins]") {
    const shapes::Soup soup = rough_balls();
    for (const FillRule rule : {FillRule::contours, FillRule::non_zero, FillRule::even_odd}) {
        for (const double tolerance : {0.001, 0.05, 0.5}) {
            SliceOptions options = simplified(tolerance, rule);
            const SliceResult result = sliced(soup, options);
            require_ok(audits::structure_of(result, view_of(soup)));
            options.region.simplify_mm = 0;
            const SliceResult plain = sliced(soup, options);
            require_ok(audits::structure_of(plain, view_of(soup)));
            CHECK(plain.info.open_contours > 0);
            CHECK(result.points.size() < plain.points.size());
            CHECK(check_origins(plain, result) > 100);
            options.region.simplify_mm = tolerance;
            options.origins = false;
            CHECK(sliced(soup, options).hash() == result.hash());
        }
    }
}

TEST_CASE("a contour that is turned round against its facets keeps the origins of its edges when simplified",
          "[engine][simplify][origins]") {
    const shapes::Soup soup = shapes::flipped(shapes::octasphere({0, 0, 0}, 10, 5));
    const SliceResult result = sliced(soup, simplified(0.02));
    require_ok(audits::structure_of(result, view_of(soup)));
    CHECK(result.info.overruled_contours > 0);
    CHECK(check_origins(sliced(soup, simplified(0)), result) > 100);
}

TEST_CASE("contours keep their segments when simplified, those that were made count their edges", "[engine][simplify]") {
    const shapes::Soup soup = rough_balls();
    for (const FillRule rule : {FillRule::contours, FillRule::non_zero}) {
        SliceOptions options = simplified(0.05, rule);
        const SliceResult result = sliced(soup, options);
        options.region.simplify_mm = 0;
        const SliceResult plain = sliced(soup, options);
        REQUIRE(result.contours.size() == plain.contours.size());
        std::size_t made = 0;
        for (std::size_t c = 0; c < plain.contours.size(); ++c) {
            const Contour& before = plain.contours[c];
            const bool is_made = rule != FillRule::contours && before.role != Role::open && before.segments != 0 &&
                                 result.contours[c].segments != before.segments;
            made += is_made;
            CHECK(result.contours[c].segments == (is_made ? result.contours[c].point_count : before.segments));
            CHECK(result.contours[c].parent == before.parent);
            CHECK(result.contours[c].role == before.role);
        }
        CHECK((made > 10) == (rule != FillRule::contours));
    }
}

TEST_CASE("parts are simplified each by itself, united ones as the region of all", "[engine][simplify][parts]") {
    const shapes::Soup left = shapes::octasphere({0, 0, 0}, 10, 5);
    const shapes::Soup right = shapes::octasphere({8, 1, 0.3}, 9, 5);
    const std::vector<Part> parts = {{.mesh = view_of(left)}, {.mesh = view_of(right)}};
    SliceOptions options = simplified(0.05, FillRule::non_zero);
    options.frame.grid_mm = 0x1p-20;
    options.heights_mm = std::vector<double>{-7.25, -3.5, 0.125, 4.75};

    const SliceResult apart = sliced(parts, options);
    CHECK(audits::structure_of(apart, parts).ok());
    const SliceResult alone = sliced(right, options);
    for (std::size_t l = 0; l < alone.layers.size(); ++l) {
        const auto contours = apart[l].contours;
        const auto own = std::find_if(contours.begin(), contours.end(), [](const Contour& c) { return c.part == 1; });
        REQUIRE(own != contours.end());
        const auto expected = alone.points_of(alone[l].contours[0]);
        const auto found = apart.points_of(*own);
        CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
    }

    options.unite_parts = true;
    const SliceResult united = sliced(parts, options);
    CHECK(audits::structure_of(united, parts).ok());
    options.unite_parts = false;
    const SliceResult whole = sliced(shapes::joined({left, right}), options);
    CHECK(whole.points.size() < 2000);
    CHECK(std::equal(united.points.begin(), united.points.end(), whole.points.begin(), whole.points.end()));
    options.region.simplify_mm = 0;
    CHECK(sliced(shapes::joined({left, right}), options).points.size() > 2 * whole.points.size());
}

TEST_CASE("regions of random tetrahedra stay valid regions when simplified", "[engine][simplify][regions][random]") {
    std::size_t fewer = 0;
    for (std::uint64_t seed = 0; seed < 120; ++seed) {
        const shapes::Soup soup = shapes::random_tetrahedra(seed, 8 + static_cast<int>(seed % 25), 9);
        SliceOptions options = at_heights({1.25, 2.75, 4.5, 6.25}, 1.0 / 64);
        options.origins = true;
        for (const FillRule rule : {FillRule::contours, FillRule::non_zero, FillRule::even_odd, FillRule::positive}) {
            INFO("seed " << seed << ", " << lamella::name_of(rule));
            options.region.fill_rule = rule;
            options.region.simplify_mm = 0;
            const SliceResult plain = sliced(soup, options);
            options.region.simplify_mm = static_cast<double>(1 + seed % 40) / 32;
            const SliceResult result = sliced(soup, options);
            require_ok(audits::structure_of(result, view_of(soup)));
            const auto crossings = audits::crossings_of(result);
            const auto crossings_before = audits::crossings_of(plain);
            REQUIRE(crossings.ok());
            REQUIRE(crossings_before.ok());
            REQUIRE(crossings->count <= crossings_before->count);
            REQUIRE(result.contours.size() == plain.contours.size());
            // Where contours cross, which of those around is the smallest may change.
            for (std::size_t c = 0; c < plain.contours.size() && rule != FillRule::contours; ++c) {
                REQUIRE(result.contours[c].parent == plain.contours[c].parent);
                REQUIRE(result.contours[c].role == plain.contours[c].role);
            }
            fewer += result.points.size() < plain.points.size();
        }
    }
    CHECK(fewer > 100);
}
