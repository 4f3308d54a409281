// The engine compared with the oracle: soups whose corners often coincide, and generated meshes.
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "oracle/compare.hpp"

using lamella::ContourForm;

namespace {

constexpr double fine_unit_mm = 0.125;

lamella::SliceOptions through_all(std::uint64_t range, ContourForm form) {
    lamella::SliceOptions options = through_quarters(range);
    options.tuning.form = form;
    return options;
}

void check_against_oracle(const shapes::Soup& soup, const lamella::SliceOptions& options) {
    const lamella::SliceResult result = sliced(soup, options);
    const std::string found = oracle::difference(result, oracle::quantise(soup, result.unit_mm));
    REQUIRE_THAT(found, Catch::Equals(""));
}

std::vector<lamella::Segment> shuffled(std::vector<lamella::Segment> segments, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    for (std::size_t i = segments.size(); i > 1; --i) {
        std::swap(segments[i - 1], segments[random() % i]);
    }
    return segments;
}

/// Requires that assemble() makes the expected layer from the oracle's segments, in any order and on any number of
/// threads.
void check_assembled(const shapes::Soup& soup, std::int32_t z, std::uint64_t seed) {
    const std::vector<oracle::Triangle> triangles = oracle::quantise(soup, fine_unit_mm);
    const oracle::Layer expected = oracle::slice_at(triangles, z);
    const std::vector<lamella::Segment> segments = shuffled(oracle::segments_at(triangles, z), seed);
    for (const int threads : {1, 3}) {
        lamella::Control control;
        control.threads = threads;
        REQUIRE_THAT(oracle::difference(value_of(assemble(segments, control)), expected), Catch::Equals(""));
    }
}

}  // namespace

TEST_CASE("unbalanced soups with coincident corners agree with the oracle", "[engine][random]") {
    const ContourForm form = GENERATE(ContourForm::swept, ContourForm::assembled);
    for (std::uint64_t seed = 0; seed < rounds(400); ++seed) {
        const std::uint64_t range = 2 + seed % 4;
        INFO("seed " << seed);
        check_against_oracle(shapes::random_soup(seed, 3 + static_cast<int>(seed % 40), range), through_all(range, form));
    }
}

TEST_CASE("tetrahedra that share edges agree with the oracle and close", "[engine][random]") {
    const ContourForm form = GENERATE(ContourForm::swept, ContourForm::assembled);
    for (std::uint64_t seed = 0; seed < rounds(400); ++seed) {
        const std::uint64_t range = 2 + seed % 4;
        const shapes::Soup soup = shapes::random_tetrahedra(seed, 2 + static_cast<int>(seed % 12), range);
        INFO("seed " << seed);
        check_against_oracle(soup, through_all(range, form));
        CHECK(sliced(soup, through_all(range, form)).summary.open_contours == 0);
    }
}

TEST_CASE("many bands agree with the oracle on soups with coincident corners", "[engine][random]") {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        lamella::SliceOptions options = through_all(5, ContourForm::swept);
        options.control.threads = 2;
        options.tuning.band_planes = 1 + static_cast<int>(seed % 5);
        INFO("seed " << seed);
        check_against_oracle(shapes::joined({shapes::random_tetrahedra(seed, 10, 5), shapes::random_soup(seed, 10, 5)}),
                             options);
    }
}

TEST_CASE("generated meshes agree with the oracle", "[engine][random]") {
    using lamella::models::Shape;
    const Shape shape = GENERATE(Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism);
    const shapes::Soup soup = generated(shape, 4000);
    REQUIRE_FALSE(soup.empty());
    for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
        lamella::SliceOptions options = uniform(0.25);
        options.tuning.form = form;
        check_against_oracle(soup, options);
        options.plan.spacing = lamella::RandomLayers{0.1, 0.5, 3};
        check_against_oracle(soup, options);
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

TEST_CASE("assemble makes the oracle's layers of a generated mesh", "[assemble]") {
    const shapes::Soup soup = generated(lamella::models::Shape::bone, 20'000);
    const lamella::SliceResult result = sliced(soup, uniform(1));
    const std::vector<oracle::Triangle> triangles = oracle::quantise(soup, result.unit_mm);
    for (const lamella::Layer& layer : result.layers) {
        const auto assembled = value_of(assemble(shuffled(oracle::segments_at(triangles, layer.plane.z()), 1)));
        const oracle::Layer expected = oracle::slice_at(triangles, layer.plane.z());
        REQUIRE_THAT(oracle::difference(assembled, expected), Catch::Equals(""));
        REQUIRE_THAT(oracle::difference(result, layer, expected), Catch::Equals(""));
    }
}
