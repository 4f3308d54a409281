#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh/inspect.hpp"

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

MeshView view_of(const Soup& soup) {
    return MeshView::soup(std::span<const double>(soup));
}

/// The answer, which must not depend on threads.
MeshInfo info_of(const MeshView& mesh, double unit_mm = 0) {
    InspectOptions options;
    options.unit_mm = unit_mm;
    options.control.threads = 1;
    const Result<MeshInfo> one = inspect(mesh, options);
    INFO((one ? "" : one.error().message));
    REQUIRE(one.ok());
    options.control.threads = 3;
    const MeshInfo three = inspect(mesh, options).value();
    CHECK(three.volume_mm3 == one.value().volume_mm3);
    CHECK(three.area_mm2 == one.value().area_mm2);
    CHECK(three.edges == one.value().edges);
    CHECK(three.shells == one.value().shells);
    CHECK(three.boundary_edges == one.value().boundary_edges);
    return one.value();
}
MeshInfo info_of(const Soup& soup, double unit_mm = 0) {
    return info_of(view_of(soup), unit_mm);
}

/// A torus of 2 * rings * rings triangles.
Soup torus(int rings) {
    const auto at = [&](int i, int j) {
        const double u = 2 * M_PI * (i % rings) / rings;
        const double v = 2 * M_PI * (j % rings) / rings;
        const double r = 20 + 5 * std::cos(v);
        return shapes::Xyz{r * std::cos(u), r * std::sin(u), 5 * std::sin(v)};
    };
    Soup soup;
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < rings; ++j) {
            soup = std::move(soup) + shapes::triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1)) +
                   shapes::triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    return soup;
}

}  // namespace

TEST_CASE("a cube is closed", "[input]") {
    const MeshInfo info = info_of(cube({1, 2, 3}, 2));
    CHECK(info.triangles == 12);
    CHECK(info.degenerate == 0);
    CHECK(info.edges == 18);
    CHECK(info.boundary_edges == 0);
    CHECK(info.overfull_edges == 0);
    CHECK(info.mismatched_edges == 0);
    CHECK(info.shells == 1);
    CHECK(info.closed);
    CHECK(info.volume_mm3 == Approx(8));
    CHECK(info.area_mm2 == Approx(24));
    CHECK(info.min_mm[2] == 3);
    CHECK(info.max_mm[0] == 3);
    CHECK(info.unit_mm == default_unit_mm);
}

TEST_CASE("an indexed tetrahedron of doubles is inspected exactly", "[input]") {
    const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const MeshInfo info = info_of(MeshView::indexed(std::span<const double>(xyz), indices));
    CHECK(info.edges == 6);
    CHECK(info.closed);
    CHECK(info.volume_mm3 == Approx(1.0 / 6));
    CHECK(info.area_mm2 == Approx(1.5 + std::sqrt(3.0) / 2));
}

TEST_CASE("an inverted cube is closed, with negative volume", "[input]") {
    const MeshInfo info = info_of(shapes::flipped(cube({0, 0, 0}, 2)));
    CHECK(info.closed);
    CHECK(info.volume_mm3 == Approx(-8));
    CHECK(info.mismatched_edges == 0);
}

TEST_CASE("a missing triangle leaves three boundary edges", "[input]") {
    Soup soup = cube({0, 0, 0}, 2);
    soup.resize(soup.size() - 9);
    const MeshInfo info = info_of(soup);
    CHECK(info.boundary_edges == 3);
    CHECK(info.edges == 18);
    CHECK_FALSE(info.closed);
}

TEST_CASE("two cubes that share an edge have one overfull edge and are closed", "[input]") {
    const MeshInfo info = info_of(cube({0, 0, 0}, 2) + cube({2, 2, 0}, 2));
    CHECK(info.overfull_edges == 1);
    CHECK(info.boundary_edges == 0);
    CHECK(info.mismatched_edges == 0);
    CHECK(info.edges == 35);
    CHECK(info.shells == 1);
    CHECK(info.closed);
}

TEST_CASE("a duplicate face makes overfull edges and opens the mesh", "[input]") {
    const Soup soup = cube({0, 0, 0}, 2);
    const MeshInfo info = info_of(soup + Soup(soup.begin(), soup.begin() + 9));
    CHECK(info.overfull_edges == 3);
    CHECK_FALSE(info.closed);
}

TEST_CASE("a flipped patch has mismatched edges around it", "[input]") {
    Soup soup = cube({0, 0, 0}, 2);
    const Soup patch = shapes::flipped({soup.begin(), soup.begin() + 18});
    std::copy(patch.begin(), patch.end(), soup.begin());
    const MeshInfo info = info_of(soup);
    CHECK(info.mismatched_edges == 4);
    CHECK(info.boundary_edges == 0);
    CHECK(info.shells == 1);
    CHECK_FALSE(info.closed);
}

TEST_CASE("shells are connected over edges, not over vertices", "[input]") {
    CHECK(info_of(cube({0, 0, 0}, 2) + cube({5, 0, 0}, 2)).shells == 2);
    CHECK(info_of(cube({0, 0, 0}, 2) + cube({2, 2, 2}, 2)).shells == 2);
    CHECK(info_of(cube({0, 0, 0}, 2) + cube({2, 0, 0}, 2)).shells == 1);
}

TEST_CASE("vertices are compared on the grid and degenerate triangles left out", "[input]") {
    Soup soup = cube({0, 0, 0}, 2) + shapes::triangle({0, 0, 0}, {0, 0, 1e-8}, {2, 0, 0});
    at(soup, 3, 1, 0) += 3e-7;  // a third of the step between vertices of the default grid
    const MeshInfo info = info_of(soup);
    CHECK(info.degenerate == 1);
    CHECK(info.triangles == 13);
    CHECK(info.edges == 18);
    CHECK(info.closed);
}

TEST_CASE("many partitions and chunks give the counts of a torus", "[input]") {
    const int rings = GENERATE(150, 300);
    const MeshInfo info = info_of(torus(rings));
    const auto quads = static_cast<std::uint64_t>(rings) * static_cast<std::uint64_t>(rings);
    CHECK(info.triangles == 2 * quads);
    CHECK(info.edges == 3 * quads);
    CHECK(info.shells == 1);
    CHECK(info.closed);
    CHECK(info.volume_mm3 == Approx(2 * M_PI * M_PI * 20 * 25).epsilon(1e-2));
}

TEST_CASE("counts do not depend on the order of triangles and vertices", "[input]") {
    Soup soup = torus(60) + cube({0, 0, 0}, 2) + cube({2, 2, 0}, 2);
    soup.erase(soup.begin() + 9 * 17, soup.begin() + 9 * 18);
    const MeshInfo before = info_of(soup);
    const MeshInfo after = info_of(shapes::shuffled(soup, 3));
    CHECK(after.edges == before.edges);
    CHECK(after.boundary_edges == 3);
    CHECK(before.boundary_edges == 3);
    CHECK(after.overfull_edges == 1);
    CHECK(after.shells == 2);
    CHECK(before.shells == 2);
}

TEST_CASE("beyond 1,024 mm the unit doubles", "[input]") {
    CHECK(info_of(cube({0, 0, 0}, 1024)).unit_mm == default_unit_mm);
    CHECK(info_of(cube({0, 0, 0}, 1025)).unit_mm == 2 * default_unit_mm);
    CHECK(info_of(cube({-1e9, 0, 0}, 1e6)).unit_mm == 1.0);
    CHECK(info_of(cube({0, 0, 0}, 2), 0.25).unit_mm == 0.25);
}

TEST_CASE("unusable input is refused with the triangle", "[input]") {
    CHECK(inspect(MeshView{}).error().code == ErrorCode::empty_mesh);

    const double value = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity(), 3e38, -1.1e9);
    Soup soup = torus(120);
    at(soup, 20'000, 2, 1) = value;
    at(soup, 25'000, 0, 0) = value;
    const Result<MeshInfo> info = inspect(view_of(soup));
    REQUIRE_FALSE(info.ok());
    CHECK(info.error().code == ErrorCode::bad_coordinate);
    CHECK(info.error().triangle == 20'000);
    CHECK_THAT(info.error().message, Catch::Contains("triangle 20000"));
}

TEST_CASE("an index beyond the vertices and an unusable unit are refused", "[input]") {
    const std::vector<float> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 1, 3};
    const Result<MeshInfo> info = inspect(MeshView::indexed(std::span<const float>(xyz), indices));
    REQUIRE_FALSE(info.ok());
    CHECK(info.error().code == ErrorCode::invalid_argument);
    CHECK(info.error().triangle == 1);

    const Soup soup = cube({0, 0, 0}, 2);
    for (const double unit : {-2.0, std::numeric_limits<double>::quiet_NaN(), 1e-12}) {
        InspectOptions options;
        options.unit_mm = unit;
        CHECK_FALSE(inspect(view_of(soup), options).ok());
    }
}

}  // namespace lamella::input_test
