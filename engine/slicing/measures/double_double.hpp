// Numbers of twice a double's precision: the unevaluated sum of two doubles, about 106 bits (Dekker 1971). The same on every
// platform, as nothing is contracted.
#pragma once

#include "base/numbers.hpp"

namespace lamella {

struct DoubleDouble {
    double high = 0;
    double low = 0;  ///< at most half a last bit of `high`

    DoubleDouble() = default;
    DoubleDouble(double value) noexcept : high(value) {}  // NOLINT(google-explicit-constructor): as numbers convert
    /// The integer, but for what lies below 106 bits.
    explicit DoubleDouble(Int128 value) noexcept {
        constexpr int bits = 32;  // which doubles hold exactly, whatever they are multiplied by
        for (int shift = 96; shift >= 0; shift -= bits) {
            const auto word = static_cast<std::int64_t>(value >> shift);  // the highest has the sign
            const double part = shift == 96 ? static_cast<double>(word) : static_cast<double>(word & 0xFFFFFFFF);
            *this = *this + DoubleDouble(part * scale_of(shift));
        }
    }
    explicit operator double() const noexcept { return high + low; }

    friend DoubleDouble operator+(DoubleDouble a, DoubleDouble b) noexcept {
        const DoubleDouble sum = two_sum(a.high, b.high);
        const DoubleDouble rest = two_sum(a.low, b.low);
        const DoubleDouble first = quick_sum(sum.high, sum.low + rest.high);
        return quick_sum(first.high, first.low + rest.low);
    }
    friend DoubleDouble operator-(DoubleDouble a, DoubleDouble b) noexcept { return a + b * -1.0; }
    friend DoubleDouble operator*(DoubleDouble a, DoubleDouble b) noexcept {
        const DoubleDouble product = two_product(a.high, b.high);
        return quick_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
    }
    /// Precondition: b is not 0.
    friend DoubleDouble operator/(DoubleDouble a, DoubleDouble b) noexcept {
        const double first = a.high / b.high;
        const DoubleDouble rest = a - b * DoubleDouble(first);
        const double second = rest.high / b.high;
        const double third = (rest - b * DoubleDouble(second)).high / b.high;
        return quick_sum(first, second) + DoubleDouble(third);
    }

private:
    DoubleDouble(double high_part, double low_part) noexcept : high(high_part), low(low_part) {}

    static double scale_of(int shift) noexcept {
        return shift == 96 ? 0x1p96 : shift == 64 ? 0x1p64 : shift == 32 ? 0x1p32 : 1.0;
    }
    /// The sum of two numbers and what its rounding loses.
    static DoubleDouble two_sum(double a, double b) noexcept {
        const double sum = a + b;
        const double of_b = sum - a;
        return {sum, (a - (sum - of_b)) + (b - of_b)};
    }
    /// The same where |a| >= |b|.
    static DoubleDouble quick_sum(double a, double b) noexcept {
        const double sum = a + b;
        return {sum, b - (sum - a)};
    }
    static DoubleDouble two_product(double a, double b) noexcept {
        const auto halves = [](double value) {
            const double big = 134217729 * value;  // 2^27 + 1
            const double upper = big - (big - value);
            return DoubleDouble{upper, value - upper};
        };
        const double product = a * b;
        const DoubleDouble x = halves(a);
        const DoubleDouble y = halves(b);
        return {product, ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low};
    }
};

}  // namespace lamella
