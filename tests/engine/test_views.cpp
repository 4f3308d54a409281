// Meshes as callers hold them: soup or indexed, float or double, strided, transformed.
#include <cmath>
#include <cstring>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "oracle/compare.hpp"

using lamella::CoordinateType;
using lamella::MeshView;
using lamella::Transform;

namespace {

const shapes::Soup ball = shapes::octasphere({1, 2, 3}, 10, 3);

std::uint64_t hash_of(const MeshView& view, const lamella::SliceOptions& options = uniform(0.25)) {
    return hash_result(sliced(view, options));
}

/// The numbers of `soup` in records of `stride` bytes with `per_record` numbers each, at an odd address.
template <class T>
std::vector<std::byte> records(const std::vector<T>& numbers, std::size_t per_record, std::size_t stride) {
    const std::size_t count = numbers.size() / per_record;
    std::vector<std::byte> bytes(1 + stride * count, std::byte{0xFF});
    for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(bytes.data() + 1 + i * stride, numbers.data() + i * per_record, per_record * sizeof(T));
    }
    return bytes;
}

/// Facets of a box of 2 x 3 x 4 mm, away from the origin.
const shapes::Soup brick = shapes::box({1, 1, 1}, {3, 4, 5});

void check_turned(double nx, double ny, double nz, std::size_t layers, double area) {
    lamella::SliceOptions options = uniform(0.5);
    options.transform = Transform::from_normal(nx, ny, nz);
    const lamella::SliceResult result = sliced(brick, options);
    INFO("normal " << nx << ' ' << ny << ' ' << nz);
    REQUIRE(result.layers.size() == layers);
    CHECK(result.frame.m == options.transform.m);
    CHECK(result.summary.overruled_contours == 0);
    for (const lamella::Layer& layer : result.layers) {
        CHECK(layer.contour_count == 1);
        CHECK(result.area_mm2(layer) == Approx(area).epsilon(1e-5));
    }
}

}  // namespace

TEST_CASE("soup and indexed meshes give the same result", "[engine][views]") {
    const shapes::Indexed mesh = shapes::indexed(ball);
    CHECK(mesh.xyz.size() < ball.size() / 3);
    CHECK(hash_of(mesh.view()) == hash_of(view_of(ball)));
    const std::vector<float> xyz = shapes::floats(mesh.xyz);
    const std::vector<float> soup = shapes::floats(ball);
    CHECK(hash_of(MeshView::indexed(std::span<const float>(xyz), mesh.indices)) ==
          hash_of(MeshView::soup(std::span<const float>(soup))));
}

TEST_CASE("float meshes give the same result as their numbers in double", "[engine][views]") {
    const std::vector<float> soup = shapes::floats(ball);
    const shapes::Soup widened(soup.begin(), soup.end());
    const lamella::SliceResult result = sliced(MeshView::soup(std::span<const float>(soup)), uniform(0.25));
    CHECK_THAT(oracle::difference(result, oracle::quantise(widened, result.unit_mm)), Catch::Equals(""));
    // Grids that are no power of two, and a coarse one, where halves are ties.
    for (const double unit : {0.004, 0.1, 0.25}) {
        const lamella::SliceResult other = sliced(MeshView::soup(std::span<const float>(soup)), uniform(1, unit));
        CHECK_THAT(oracle::difference(other, oracle::quantise(widened, unit)), Catch::Equals(""));
        CHECK(hash_result(sliced(widened, uniform(1, unit))) == hash_result(other));
    }
}

TEST_CASE("records of any stride at any address are read", "[engine][views]") {
    const std::vector<float> soup = shapes::floats(ball);
    const std::uint64_t expected = hash_of(MeshView::soup(std::span<const float>(soup)));
    const std::vector<std::byte> facets = records(soup, 9, 50);
    CHECK(hash_of(MeshView::strided_soup(facets.data() + 1, soup.size() / 9, 50, CoordinateType::f32)) == expected);
    const std::vector<std::byte> doubles = records(ball, 9, 91);
    CHECK(hash_of(MeshView::strided_soup(doubles.data() + 1, ball.size() / 9, 91, CoordinateType::f64)) ==
          hash_of(view_of(ball)));
    const shapes::Indexed mesh = shapes::indexed(ball);
    const std::vector<std::byte> vertices = records(mesh.xyz, 3, 33);
    CHECK(hash_of(MeshView::indexed(vertices.data() + 1, mesh.xyz.size() / 3, 33, CoordinateType::f64, mesh.indices)) ==
          hash_of(view_of(ball)));
}

TEST_CASE("a normal turns the mesh, and the result carries the frame", "[engine][views]") {
    CHECK(Transform::from_normal(0, 0, 1).is_identity());
    CHECK(Transform::from_normal(0, 0, 2.5).is_identity());
    check_turned(0, 0, 1, 8, 6);
    check_turned(0, 0, -1, 8, 6);
    check_turned(1, 0, 0, 4, 12);
    check_turned(-3, 0, 0, 4, 12);
    check_turned(0, 1, 0, 6, 8);
    check_turned(0, -1, 0, 6, 8);
}

TEST_CASE("a turned mesh keeps its volume", "[engine][views]") {
    lamella::SliceOptions options = uniform(0.01);
    options.transform = Transform::from_normal(1, -2, 0.5);
    const lamella::SliceResult result = sliced(brick, options);
    double volume = 0;
    for (const lamella::Layer& layer : result.layers) {
        volume += result.area_mm2(layer) * 0.01;
    }
    CHECK(volume == Approx(24).epsilon(1e-4));
}

TEST_CASE("a transform applies before the grid", "[engine][views]") {
    lamella::SliceOptions options = at_heights({5, 7, 9});
    options.transform.m = {2, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 4};
    const lamella::SliceResult result = sliced(brick, options);
    REQUIRE(result.layers.size() == 3);
    CHECK(result.layers[0].contour_count == 0);
    CHECK(contours_at(result, 1) == std::vector<std::string>{"outer + x8 in -: 24,2 27,2 32,2 32,4 32,8 29,8 24,8 24,6"});
    CHECK(contours_at(result, 2).size() == 1);
    CHECK(result.summary.min_mm[0] == 12);
    CHECK(result.summary.max_mm[2] == 9);
}
