// The engine compared with the oracle: soups whose corners often coincide, and generated meshes.
#include <random>

#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "oracle/compare.hpp"

using namespace lamella;

namespace {

constexpr double fine_unit_mm = 0.125;

SliceResult check_against_oracle(const shapes::Soup& soup, const SliceOptions& options, const Way& way = {}) {
    SliceResult result = sliced(soup, options, way.context, way.tuning);
    const std::string found = oracle::difference(result, oracle::quantise(soup, result.info.grid_mm));
    REQUIRE_THAT(found, Catch::Equals(""));
    return result;
}

/// Requires that assemble() makes the expected layer from the oracle's segments, in any order.
void check_assembled(const shapes::Soup& soup, std::int32_t z, std::uint64_t seed) {
    const std::vector<oracle::Triangle> triangles = oracle::quantise(soup, fine_unit_mm);
    const oracle::Layer expected = oracle::slice_at(triangles, z);
    std::vector<Segment> segments = oracle::segments_at(triangles, z);
    std::shuffle(segments.begin(), segments.end(), std::mt19937_64(seed));
    REQUIRE_THAT(oracle::difference(value_of(assemble(segments)), expected), Catch::Equals(""));
}

TEST_CASE("soups and tetrahedra with coincident corners agree with the oracle in every form and band", "[engine][random]") {
    const ContourForm form = GENERATE(ContourForm::swept, ContourForm::assembled);
    for (std::uint64_t seed = 0; seed < rounds(400); ++seed) {
        const std::uint64_t range = 2 + seed % 4;
        INFO("seed " << seed);
        const SliceOptions options = through_quarters(range);
        const Way way{{.threads = 1 + static_cast<int>(seed % 2)},
                      {.band_planes = seed % 7 == 0 ? 1 + static_cast<std::int64_t>(seed % 5) : 0, .form = form}};
        const shapes::Soup soup = shapes::random_soup(seed, 3 + static_cast<int>(seed % 40), range);
        const shapes::Soup solids = shapes::random_tetrahedra(seed, 2 + static_cast<int>(seed % 12), range);
        check_against_oracle(soup, options, way);
        CHECK(check_against_oracle(solids, options, way).info.open_contours == 0);
        check_against_oracle(shapes::joined({solids, soup}), options, way);
    }
}

TEST_CASE("generated meshes agree with the oracle", "[engine][random]") {
    using models::Shape;
    const Shape shape = GENERATE(Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism);
    const shapes::Soup soup = generated(shape, 4000);
    REQUIRE_FALSE(soup.empty());
    for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
        check_against_oracle(soup, uniform(0.25), {{}, {.form = form}});
        check_against_oracle(soup, {}, {{}, {.form = form, .random_heights = RandomHeights{0.1, 0.5, 3}}});
    }
}

TEST_CASE("assemble makes the oracle's contours of the oracle's segments", "[assemble][random]") {
    for (std::uint64_t seed = 0; seed < 150; ++seed) {
        const std::uint64_t range = 2 + seed % 4;
        const std::int32_t z = 2 * static_cast<std::int32_t>(seed % (4 * range)) + 1;
        INFO("seed " << seed);
        check_assembled(shapes::random_soup(seed, 5 + static_cast<int>(seed % 40), range), z, seed);
        check_assembled(shapes::random_tetrahedra(seed, 2 + static_cast<int>(seed % 12), range), z, seed);
    }
}

TEST_CASE("the comparison finds every difference", "[engine][random]") {
    const shapes::Soup shells =
        shapes::joined({shapes::box({0, 0, 0}, {8, 8, 8}), shapes::flipped(shapes::box({2, 2, 2}, {6, 6, 6})),
                        shapes::triangle({9, 0, 0}, {12, 0, 0}, {9, 0, 8})});
    const oracle::Layer expected = oracle::slice_at(oracle::quantise(shells, coarse_unit_mm), 5);
    const auto differs = [&](auto&& damage) {
        SliceResult result = sliced(shells, at_heights({3}));
        damage(result);
        return !oracle::difference(result, result.layers[0], expected).empty();
    };
    CHECK_FALSE(differs([](SliceResult&) {}));
    CHECK(differs([](SliceResult& r) { r.points[3].x += 1; }));
    CHECK(differs([](SliceResult& r) { r.contours[1].parent = -1; }));
    CHECK(differs([](SliceResult& r) { r.contours[1].role = Role::outer; }));
    CHECK(differs([](SliceResult& r) { r.contours[1].orientation = 1; }));
    CHECK(differs([](SliceResult& r) { r.contours[1].flags = 1; }));
    CHECK(differs([](SliceResult& r) { ++r.contours[2].segments; }));
    CHECK(differs([](SliceResult& r) { r.contours[0].twice_area.low ^= 1; }));
    CHECK(differs([](SliceResult& r) { --r.layers[0].contour_count; }));
    CHECK(differs([](SliceResult& r) { std::rotate(&r.points[0], &r.points[1], &r.points[0] + 8); }));
}

}  // namespace
