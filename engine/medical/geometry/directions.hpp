// Directions in the patient.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace lamella {

using Direction = std::array<double, 3>;

/// Voxels along a side: more fit no mask.
inline constexpr std::uint64_t largest_image_side = std::uint64_t{1} << 24;

inline double dot(const Direction& a, const Direction& b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Direction cross(const Direction& a, const Direction& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double length(const Direction& a) noexcept {
    return std::sqrt(dot(a, a));
}

inline Direction scaled(const Direction& a, double factor) noexcept {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}

/// The axis of the patient that a direction is nearest to, and whether it runs against it.
struct NearestAxis {
    std::size_t axis;
    bool negative;
};

inline NearestAxis nearest_axis(const Direction& a) noexcept {
    const auto* const most =
        std::max_element(a.begin(), a.end(), [](double x, double y) { return std::abs(x) < std::abs(y); });
    return {static_cast<std::size_t>(most - a.begin()), *most < 0};
}

}  // namespace lamella
