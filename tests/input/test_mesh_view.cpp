#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <catch2/catch.hpp>

#include "lamella/mesh.hpp"

namespace lamella::input_test {

namespace {

std::array<double, 3> turned(const Transform& t, double x, double y, double z) {
    std::array<double, 3> p{};
    for (std::size_t row = 0; row < 3; ++row) {
        p[row] = t.m[4 * row] * x + t.m[4 * row + 1] * y + t.m[4 * row + 2] * z + t.m[4 * row + 3];
    }
    return p;
}

double determinant(const Transform& t) {
    const auto& m = t.m;
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

}  // namespace

TEST_CASE("views describe the caller's memory", "[input]") {
    const std::vector<float> floats(18);
    const std::vector<double> doubles(12);
    const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 2, 3, 1, 2, 3};

    const MeshView soup = MeshView::soup(std::span<const float>(floats));
    CHECK(soup.triangle_count == 2);
    CHECK(soup.vertex_step() == 36);
    CHECK(MeshView::soup(std::span<const double>(doubles).first(9)).vertex_step() == 72);

    const MeshView indexed = MeshView::indexed(std::span<const double>(doubles), indices);
    CHECK(indexed.triangle_count == 3);
    CHECK(indexed.vertex_count == 4);
    CHECK(indexed.vertex_step() == 24);
    CHECK(indexed.index_step() == 12);
    CHECK(indexed.vertex_of(1, 2) == indices[5]);
    CHECK(MeshView::indexed(std::span<const float>(floats), indices).vertex_count == 6);

    const MeshView strided{.vertices = floats.data(), .triangle_count = 1, .vertex_stride = 50};
    CHECK(strided.vertex_at(1) == reinterpret_cast<const std::byte*>(floats.data()) + 50);
}

TEST_CASE("axis normals give exact transforms, that of z the identity", "[input]") {
    CHECK(Transform::from_normal(0, 0, -2).m == std::array<double, 12>{1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0});
    CHECK(Transform::from_normal(5, 0, 0).m == std::array<double, 12>{0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0});
    CHECK(Transform::from_normal(0, 0, 1).is_identity());
    CHECK(Transform::from_normal(0, 0, 1e-300).is_identity());
    CHECK(Transform::from_normal(0, -0.0, 7e300).is_identity());
    for (const double entry : Transform::from_normal(-0.0, 0, 3).m) {
        CHECK_FALSE(std::signbit(entry));
    }
}

TEST_CASE("any normal is turned into +z by a proper rotation", "[input]") {
    const auto n = GENERATE(values<std::array<double, 3>>({{0, 0, -1},
                                                           {1, 0, 0},
                                                           {0, -1, 0},
                                                           {1, 1, 1},
                                                           {-0.3, 0.2, -0.9},
                                                           {1e-9, 0, -1},
                                                           {0, 1e-9, 1},
                                                           {3, 4, -1e-12},
                                                           {1e-200, -2e-200, 0},
                                                           {-1e300, 1e300, 1e300}}));
    const Transform t = Transform::from_normal(n[0], n[1], n[2]);
    const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
    const double length = std::hypot(n[0] / largest, n[1] / largest, n[2] / largest);
    const auto z = turned(t, n[0] / largest, n[1] / largest, n[2] / largest);
    CHECK(std::abs(z[0]) < 1e-15 * length);
    CHECK(std::abs(z[1]) < 1e-15 * length);
    CHECK(z[2] == Approx(length).epsilon(1e-15));
    CHECK(determinant(t) == Approx(1).epsilon(1e-15));
    for (std::size_t row = 0; row < 3; ++row) {
        CHECK(std::hypot(t.m[4 * row], t.m[4 * row + 1], t.m[4 * row + 2]) == Approx(1).epsilon(1e-15));
        CHECK(t.m[4 * row + 3] == 0);
    }
}

TEST_CASE("a product of transforms applies the right one first", "[input]") {
    const Transform move{{1, 0, 0, 10, 0, 1, 0, 20, 0, 0, 1, 30}};
    const Transform turn{{0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}};
    CHECK((turn * move).m == std::array<double, 12>{0, -1, 0, -20, 1, 0, 0, 10, 0, 0, 1, 30});
    CHECK((move * turn).m == std::array<double, 12>{0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30});
    CHECK((move * Transform::scale(2)).m == std::array<double, 12>{2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 2, 30});
    CHECK((move * Transform{}).m == move.m);
}

}  // namespace lamella::input_test
