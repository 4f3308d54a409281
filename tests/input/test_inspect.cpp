#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/check.hpp"
#include "lamella/grid.hpp"

namespace lamella::input_test {

namespace {

using shapes::Soup;

/// Twelve triangles, outward.
Soup cube(shapes::Xyz low, double size) {
    return shapes::box(low, {low[0] + size, low[1] + size, low[2] + size});
}

Soup operator+(Soup a, const Soup& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// A coordinate of the soup.
double& at(Soup& soup, std::size_t triangle, std::size_t corner, std::size_t axis) {
    return soup[9 * triangle + 3 * corner + axis];
}

/// The answer, which must not depend on threads.
MeshCheck counted(const MeshView& mesh, double grid_mm = 0) {
    const CheckOptions options{.frame = {.grid_mm = grid_mm}, .counts_only = true};
    const MeshCheck one = value_of(check(mesh, options, {.threads = 1}));
    const MeshCheck three = check(mesh, options, {.threads = 3}).value();
    CHECK(three.volume_mm3 == one.volume_mm3);
    CHECK(three.area_mm2 == one.area_mm2);
    CHECK(three.edges == one.edges);
    CHECK(three.shell_count == one.shell_count);
    CHECK(three.boundary_edges == one.boundary_edges);
    return one;
}

MeshCheck counted(const Soup& soup, double grid_mm = 0) {
    return counted(view_of(soup), grid_mm);
}

Soup with_flipped_patch() {
    Soup soup = cube({0, 0, 0}, 2);
    const Soup patch = shapes::flipped({soup.begin(), soup.begin() + 18});
    std::copy(patch.begin(), patch.end(), soup.begin());
    return soup;
}

}  // namespace

TEST_CASE("an indexed tetrahedron of doubles is inspected exactly", "[input]") {
    const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const MeshCheck counts = counted(MeshView::indexed(std::span<const double>(xyz), indices));
    CHECK(counts.edges == 6);
    CHECK(counts.closed);
    CHECK(counts.box == Box{{0, 0, 0}, {1, 1, 1}});
    CHECK(counts.volume_mm3 == Approx(1.0 / 6));
    CHECK(counts.area_mm2 == Approx(1.5 + std::sqrt(3.0) / 2));
}

TEST_CASE("edges, shells and volumes of small meshes are counted", "[input]") {
    const Soup whole = cube({0, 0, 0}, 2);
    struct Case {
        const char* name;
        Soup soup;
        std::uint64_t edges, boundary, overfull, mismatched, shells;
        bool closed;
        double volume_mm3;
    };
    const std::vector<Case> cases = {
        {"a cube", cube({1, 2, 3}, 2), 18, 0, 0, 0, 1, true, 8},
        {"inverted", shapes::flipped(whole), 18, 0, 0, 0, 1, true, -8},
        {"without a triangle", shapes::without(whole, 11, 1), 18, 3, 0, 0, 1, false, 0},
        {"two that share an edge", whole + cube({2, 2, 0}, 2), 35, 0, 1, 0, 1, true, 16},
        {"two that share a vertex", whole + cube({2, 2, 2}, 2), 36, 0, 0, 0, 2, true, 16},
        {"two that share a side", whole + cube({2, 0, 0}, 2), 32, 0, 4, 0, 1, true, 16},
        {"two apart", whole + cube({5, 0, 0}, 2), 36, 0, 0, 0, 2, true, 16},
        {"with a face twice", whole + shapes::only(whole, 0, 1), 18, 0, 3, 0, 1, false, 0},
        {"with a flipped patch", with_flipped_patch(), 18, 0, 0, 4, 1, false, 0},
    };
    for (const Case& one : cases) {
        INFO(one.name);
        const MeshCheck counts = counted(one.soup);
        CHECK(counts.edges == one.edges);
        CHECK(counts.boundary_edges == one.boundary);
        CHECK(counts.overfull_edges == one.overfull);
        CHECK(counts.mismatched_edges == one.mismatched);
        CHECK(counts.shell_count == one.shells);
        CHECK(counts.closed == one.closed);
        CHECK((!one.closed || counts.volume_mm3 == Approx(one.volume_mm3)));
    }
}

TEST_CASE("vertices are compared on the grid and degenerate triangles left out", "[input]") {
    Soup soup = cube({0, 0, 0}, 2) + shapes::triangle({0, 0, 0}, {0, 0, 1e-8}, {2, 0, 0});
    at(soup, 3, 1, 0) += 3e-7;  // a third of the step between vertices of the default grid
    const MeshCheck counts = counted(soup);
    CHECK(counts.degenerate == 1);
    CHECK(counts.triangles == 13);
    CHECK(counts.edges == 18);
    CHECK(counts.closed);
}

TEST_CASE("beyond 1,024 mm the unit doubles", "[input]") {
    CHECK(counted(cube({0, 0, 0}, 1024)).grid_mm == default_grid_mm);
    CHECK(counted(cube({0, 0, 0}, 1025)).grid_mm == 2 * default_grid_mm);
    CHECK(counted(cube({-1e9, 0, 0}, 1e6)).grid_mm == 1.0);
    CHECK(counted(cube({0, 0, 0}, 2), 0.25).grid_mm == 0.25);
}

TEST_CASE("unusable input is refused with the triangle", "[input]") {
    CHECK(check(MeshView{}, {.counts_only = true}).error().code == ErrorCode::empty_mesh);

    const double value = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity(), 3e38, -1.1e9);
    Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
    at(soup, 20'000, 2, 1) = value;
    at(soup, 25'000, 0, 0) = value;
    const Error error = error_of(check(view_of(soup), {.counts_only = true}));
    CHECK(error.code == ErrorCode::bad_coordinate);
    CHECK(error.triangle == 20'000);
    CHECK_THAT(error.message, Catch::Contains("triangle 20000"));
}

TEST_CASE("an index beyond the vertices and an unusable unit are refused", "[input]") {
    const std::vector<float> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 1, 3};
    const Error error = error_of(check(MeshView::indexed(std::span<const float>(xyz), indices), {.counts_only = true}));
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.triangle == 1);

    const Soup soup = cube({0, 0, 0}, 2);
    for (const double unit : {-2.0, std::numeric_limits<double>::quiet_NaN(), 1e-12}) {
        CHECK_FALSE(check(view_of(soup), {.frame = {.grid_mm = unit}, .counts_only = true}).ok());
    }
}

}  // namespace lamella::input_test
