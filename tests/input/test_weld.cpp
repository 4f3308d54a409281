// Welding: which vertices become one, and that nothing else changes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "lamella/weld.hpp"

namespace lamella {
namespace {

WeldedMesh welded(const shapes::Soup& soup, double tolerance) {
    return value_of(weld(view_of(soup), tolerance));
}

std::uint64_t hash_of(const MeshView& mesh) {
    return sliced(mesh, uniform(0.3)).hash();
}

/// Each corner of each triangle moved by up to `reach`.
shapes::Soup cracked(shapes::Soup soup, double reach, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> move(-reach, reach);
    for (double& coordinate : soup) {
        coordinate += move(random);
    }
    return soup;
}

TEST_CASE("a tolerance of zero joins equal vertices and changes no slice", "[input][weld]") {
    const shapes::Soup soup = shapes::octasphere({1, 2, 3}, 10, 4);
    const WeldedMesh mesh = welded(soup, 0);
    CHECK(mesh.joined == 0);
    CHECK(mesh.largest_move_mm == 0);
    CHECK(mesh.indices.size() == soup.size() / 3);
    CHECK(mesh.vertex_count == soup.size() / 9 / 2 + 2);  // Euler, on a sphere
    CHECK(hash_of(mesh.view()) == hash_of(view_of(soup)));
}

TEST_CASE("a cracked sphere closes when it is welded", "[input][weld]") {
    const shapes::Soup whole = shapes::octasphere({0, 0, 0}, 10, 4);
    const shapes::Soup soup = cracked(whole, 0.001, 5);
    CHECK(sliced(view_of(soup), uniform(0.3)).info.open_contours > 0);
    const WeldedMesh mesh = welded(soup, 0.01);
    CHECK(mesh.vertex_count == whole.size() / 9 / 2 + 2);
    CHECK(mesh.joined == soup.size() / 3 - mesh.vertex_count);
    CHECK(mesh.largest_move_mm <= 0.01);
    CHECK(mesh.largest_move_mm > 0.001);
    const SliceResult result = sliced(mesh.view(), uniform(0.3));
    CHECK(result.info.open_contours == 0);
    CHECK(result.info.degenerate == 0);
}

TEST_CASE("the nearest vertex wins, across cells of the search too", "[input][weld]") {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> place(-3, 3);
    shapes::Soup soup(9 * 300);
    for (double& coordinate : soup) {
        coordinate = place(random);
    }
    const double tolerance = 0.4;
    const WeldedMesh mesh = welded(soup, tolerance);
    // The rule as stated, all against all.
    std::vector<std::array<double, 3>> corners(soup.size() / 3);
    for (std::size_t i = 0; i < soup.size(); ++i) {
        corners[i / 3][i % 3] = soup[i];
    }
    std::vector<std::array<double, 3>> sorted = corners;
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::array<double, 3>> kept;
    std::map<std::array<double, 3>, std::uint32_t> vertex_of;
    for (const auto& at : sorted) {
        const auto squared = [&](const auto& other) {
            return std::pow(at[0] - other[0], 2) + std::pow(at[1] - other[1], 2) + std::pow(at[2] - other[2], 2);
        };
        const auto nearest = std::min_element(kept.begin(), kept.end(),
                                              [&](const auto& a, const auto& b) { return squared(a) < squared(b); });
        vertex_of[at] = static_cast<std::uint32_t>(nearest - kept.begin());
        if (nearest == kept.end() || squared(*nearest) > tolerance * tolerance) {
            vertex_of[at] = static_cast<std::uint32_t>(kept.size());
            kept.push_back(at);
        }
    }
    CHECK(kept.size() > 200);
    CHECK(mesh.joined == corners.size() - kept.size());
    REQUIRE(mesh.vertex_count == kept.size());
    REQUIRE(mesh.coordinates.size() == kept.size() * sizeof kept[0]);
    CHECK(std::memcmp(mesh.coordinates.data(), kept.data(), mesh.coordinates.size()) == 0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        CHECK(mesh.indices[i] == vertex_of[corners[i]]);
    }
}

TEST_CASE("390,000 vertices in one cell of the search are welded", "[input][weld]") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(0, 1);
    shapes::Soup soup(std::size_t{9} * 130'000);
    for (double& coordinate : soup) {
        coordinate = place(random);
    }
    CHECK(welded(soup, 0).vertex_count == 390'000);
    CHECK(welded(soup, 0.01).vertex_count < 390'000);
}

TEST_CASE("meshes that cannot be welded are refused", "[input][weld]") {
    shapes::Soup soup = shapes::octasphere({0, 0, 0}, 1, 1);
    for (const double tolerance : {-1.0, 1e-10, std::nan(""), std::numeric_limits<double>::infinity()}) {
        CHECK(weld(view_of(soup), tolerance).error().code == ErrorCode::invalid_argument);
    }
    CHECK(weld(view_of(shapes::Soup{}), 0).error().code == ErrorCode::empty_mesh);
    soup[9 * 3 + 4] = std::nan("");
    const Error broken = error_of(weld(view_of(soup), 0.1));
    CHECK(broken.code == ErrorCode::bad_coordinate);
    CHECK(broken.triangle == 3);
    const std::vector<float> xyz(9);
    const std::vector<std::uint32_t> indices{0, 1, 3};
    CHECK(weld(MeshView::indexed(std::span(xyz), indices), 0).error().code == ErrorCode::invalid_argument);
    // No corner is read with the one before it: the vertex lies far outside the memory.
    const std::vector<std::int32_t> integers(9);
    const std::vector<std::uint32_t> far{0, 1, 0xfffffff0};
    const MeshView of_integers{.vertices = integers.data(),
                               .vertex_count = 3,
                               .triangle_count = 1,
                               .indices = far.data(),
                               .vertex_type = Number::i32};
    CHECK(weld(of_integers, 0).error().code == ErrorCode::invalid_argument);
}

}  // namespace
}  // namespace lamella
