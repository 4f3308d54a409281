// Colours as DICOM states them: CIELab for the white of D50 (PS3.3, C.10.7.1.1), from sRGB.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace lamella {

/// The n-th root of a number from 1e-15 to 1, by Newton's method: the same on every platform, as pow() is not.
inline double nth_root(double value, int n) noexcept {
    double root = 1;
    for (int step = 0; step < 64; ++step) {
        double power = 1;
        for (int i = 1; i < n; ++i) {
            power *= root;
        }
        root = ((n - 1) * root + value / power) / n;
    }
    return root;
}

/// L from 0 to 100, a and b from -128 to 127, each as 0 to 65,535.
inline std::array<std::uint16_t, 3> cielab_of(const std::array<std::uint8_t, 3>& srgb) noexcept {
    std::array<double, 3> linear{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double value = srgb[i] / 255.0;
        const double base = (value + 0.055) / 1.055;
        const double fifth = nth_root(base, 5);  // base^2.4 = base^2 (base^(1/5))^2
        linear[i] = value <= 0.04045 ? value / 12.92 : base * base * fifth * fifth;
    }
    // To XYZ, adapted to D50 by Bradford's method (B. Lindbloom), each over that of white.
    static constexpr std::array<std::array<double, 3>, 3> rows = {
        {{0.4360747, 0.3850649, 0.1430804}, {0.2225045, 0.7168786, 0.0606169}, {0.0139322, 0.0971045, 0.7141733}}};
    std::array<double, 3> f{};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& [red, green, blue] = rows[i];
        const double ratio = (red * linear[0] + green * linear[1] + blue * linear[2]) / (red + green + blue);
        f[i] = ratio > 216.0 / 24389 ? nth_root(ratio, 3) : (24389.0 / 27 * ratio + 16) / 116;
    }
    const auto scaled = [](double value, double from, double range) {
        const double share = (value - from) / range;
        return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0, 1.0)));
    };
    return {scaled(116 * f[1] - 16, 0, 100), scaled(500 * (f[0] - f[1]), -128, 255), scaled(200 * (f[1] - f[2]), -128, 255)};
}

}  // namespace lamella
