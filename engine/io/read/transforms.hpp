// Transforms of objects that a file places.
#pragma once

#include <array>

#include "lamella/mesh.hpp"

namespace lamella {

/// Of the axes; negative where a transform turns triangles inside out.
inline double determinant(const std::array<double, 12>& m) {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

inline std::array<double, 3> moved(const Transform& transform, const std::array<double, 3>& p) {
    const std::array<double, 12>& m = transform.m;
    return {m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3], m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7],
            m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]};
}

}  // namespace lamella
