#include <algorithm>
#include <cassert>
#include <cmath>

#include "lamella/mesh.hpp"

namespace lamella {

namespace {

template <class T>
MeshView soup_of(std::span<const T> xyz, Number number) {
    assert(xyz.size() % 9 == 0);
    return {.vertices = xyz.data(), .triangle_count = xyz.size() / 9, .vertex_type = number};
}

template <class T>
MeshView indexed_of(std::span<const T> xyz, std::span<const std::uint32_t> indices, Number number) {
    assert(xyz.size() % 3 == 0 && indices.size() % 3 == 0);
    return {.vertices = xyz.data(),
            .vertex_count = xyz.size() / 3,
            .triangle_count = indices.size() / 3,
            .indices = indices.data(),
            .vertex_type = number};
}

}  // namespace

MeshView MeshView::soup(std::span<const float> xyz) noexcept {
    return soup_of(xyz, Number::f32);
}
MeshView MeshView::soup(std::span<const double> xyz) noexcept {
    return soup_of(xyz, Number::f64);
}
MeshView MeshView::indexed(std::span<const float> xyz, std::span<const std::uint32_t> indices) noexcept {
    return indexed_of(xyz, indices, Number::f32);
}
MeshView MeshView::indexed(std::span<const double> xyz, std::span<const std::uint32_t> indices) noexcept {
    return indexed_of(xyz, indices, Number::f64);
}

bool Transform::is_singular() const noexcept {
    const double determinant =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
    double largest = 1;  // of a matrix whose rows are that long
    for (std::size_t row = 0; row < 12; row += 4) {
        largest *= std::sqrt(m[row] * m[row] + m[row + 1] * m[row + 1] + m[row + 2] * m[row + 2]);
    }
    return std::isfinite(largest) && std::abs(determinant) <= 1e-12 * largest;
}

Transform Transform::scale(double factor) noexcept {
    Transform transform;
    transform.m[0] = transform.m[5] = transform.m[10] = factor;
    return transform;
}

Transform operator*(const Transform& second, const Transform& first) noexcept {
    Transform both = second;
    if (first.is_identity()) {
        return both;  // to the bit
    }
    for (std::size_t row = 0; row < 3; ++row) {
        const double* of = second.m.data() + 4 * row;
        for (std::size_t column = 0; column < 4; ++column) {
            const auto* at = first.m.data() + column;
            both.m[4 * row + column] = of[0] * at[0] + of[1] * at[4] + of[2] * at[8] + (column == 3 ? of[3] : 0.0);
        }
    }
    return both;
}

// The rotation about the axis n × z. With n = (a, b, c) of length one and c >= 0:
//
//     | 1 - a²/(1+c)    -ab/(1+c)   -a |
//     |  -ab/(1+c)    1 - b²/(1+c)  -b |
//     |       a             b        c |
//
// Where c < 0 the space is first turned half round the x axis, so that nothing is divided by a small 1 + c. Only
// + - * / and sqrt are used, which are rounded alike everywhere.
Transform Transform::from_normal(double x, double y, double z) noexcept {
    const double largest = std::max({std::abs(x), std::abs(y), std::abs(z)});
    assert(largest > 0 && std::isfinite(largest));
    x /= largest;
    y /= largest;
    z /= largest;
    const double length = std::sqrt(x * x + y * y + z * z);
    const double flip = z < 0 ? -1.0 : 1.0;
    const double a = x / length;
    const double b = flip * (y / length);
    const double c = flip * (z / length);
    const double k = 1.0 / (1.0 + c);
    Transform transform;
    transform.m = {1.0 - a * a * k,
                   flip * (-a * b * k),
                   flip * -a,
                   0,  //
                   -a * b * k,
                   flip * (1.0 - b * b * k),
                   flip * -b,
                   0,  //
                   a,
                   flip * b,
                   flip * c,
                   0};
    for (double& entry : transform.m) {
        entry += 0.0;  // -0 becomes +0: equal transforms have equal bytes
    }
    return transform;
}

}  // namespace lamella
