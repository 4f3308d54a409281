// 128-bit integers: the compiler's own where it has them, else of two words, with the same numbers.
#pragma once

#include <bit>
#include <cmath>
#include <compare>
#include <concepts>
#include <cstdint>

namespace lamella {

/// A number of up to 64 bits.
template <class T>
concept UpTo64Bits = std::integral<T> && sizeof(T) <= sizeof(std::uint64_t);

/// A signed integer in two's complement. Results beyond 128 bits wrap around; division rounds towards zero.
class PortableInt128 {
public:
    PortableInt128() noexcept = default;
    // Implicit, as the compiler's own numbers are.
    template <UpTo64Bits T>
    constexpr PortableInt128(T value) noexcept  // NOLINT(google-explicit-constructor)
        : high_(std::signed_integral<T> ? static_cast<std::int64_t>(value) >> 63 : 0),
          low_(static_cast<std::uint64_t>(value)) {}

    template <std::integral T>
    requires(!std::same_as<T, bool>) constexpr explicit operator T() const noexcept { return static_cast<T>(low_); }
    /// Rounded to nearest, ties to even: its highest 64 bits, the last of which is set too where any is below them.
    explicit operator double() const noexcept {
        const PortableInt128 size = magnitude();
        const int below = 64 - std::countl_zero(size.high());
        const PortableInt128 top = size.shifted_down(below);
        const double rounded = std::ldexp(static_cast<double>(top.low_ | ((top << below) == size ? 0U : 1U)), below);
        return high_ < 0 ? -rounded : rounded;
    }

    friend constexpr auto operator<=>(const PortableInt128&, const PortableInt128&) noexcept = default;

    constexpr PortableInt128 operator~() const noexcept { return {~high(), ~low_}; }
    constexpr PortableInt128 operator-() const noexcept { return ~*this + 1; }
    friend constexpr PortableInt128 operator+(PortableInt128 a, PortableInt128 b) noexcept {
        return {a.high() + b.high() + (a.low_ + b.low_ < a.low_ ? 1 : 0), a.low_ + b.low_};
    }
    friend constexpr PortableInt128 operator-(PortableInt128 a, PortableInt128 b) noexcept { return a + -b; }
    friend constexpr PortableInt128 operator*(PortableInt128 a, PortableInt128 b) noexcept {
        const PortableInt128 low = product(a.low_, b.low_);
        return {low.high() + a.high() * b.low_ + a.low_ * b.high(), low.low_};
    }
    /// Precondition: b != 0.
    friend constexpr PortableInt128 operator/(PortableInt128 a, PortableInt128 b) noexcept {
        const PortableInt128 size = quotient(a.magnitude(), b.magnitude());
        return (a.high_ < 0) == (b.high_ < 0) ? size : -size;
    }
    friend constexpr PortableInt128 operator%(PortableInt128 a, PortableInt128 b) noexcept { return a - a / b * b; }
    friend constexpr PortableInt128 operator|(PortableInt128 a, PortableInt128 b) noexcept {
        return {a.high() | b.high(), a.low_ | b.low_};
    }

    // Precondition: 0 <= bits < 128.
    friend constexpr PortableInt128 operator<<(PortableInt128 a, int bits) noexcept {
        if (bits >= 64) {
            return {a.low_ << (bits - 64), 0};
        }
        return bits == 0 ? a : PortableInt128(a.high() << bits | a.low_ >> (64 - bits), a.low_ << bits);
    }
    friend constexpr PortableInt128 operator>>(PortableInt128 a, int bits) noexcept {
        return a.high_ < 0 ? ~(~a).shifted_down(bits) : a.shifted_down(bits);
    }

    constexpr PortableInt128& operator+=(PortableInt128 b) noexcept { return *this = *this + b; }
    constexpr PortableInt128& operator-=(PortableInt128 b) noexcept { return *this = *this - b; }

private:
    constexpr PortableInt128(std::uint64_t high, std::uint64_t low) noexcept
        : high_(static_cast<std::int64_t>(high)), low_(low) {}

    constexpr std::uint64_t high() const noexcept { return static_cast<std::uint64_t>(high_); }
    // From here on the words are those of an unsigned number.
    constexpr PortableInt128 magnitude() const noexcept { return high_ < 0 ? -*this : *this; }
    constexpr PortableInt128 shifted_down(int bits) const noexcept {
        if (bits >= 64) {
            return {0, high() >> (bits - 64)};
        }
        return bits == 0 ? *this : PortableInt128(high() >> bits, low_ >> bits | high() << (64 - bits));
    }

    /// high * high * 2^64 + (high * low + low * high) * 2^32 + low * low, by halves of the words.
    static constexpr PortableInt128 product(std::uint64_t a, std::uint64_t b) noexcept {
        constexpr std::uint64_t half = 0xFFFFFFFF;
        const std::uint64_t low = (a & half) * (b & half);
        const std::uint64_t first = (a >> 32) * (b & half) + (low >> 32);
        const std::uint64_t second = (a & half) * (b >> 32) + (first & half);
        return {(a >> 32) * (b >> 32) + (first >> 32) + (second >> 32), second << 32 | (low & half)};
    }
    /// Bit by bit, from the highest. Precondition: both are at most 2^127.
    static constexpr PortableInt128 quotient(PortableInt128 a, PortableInt128 b) noexcept {
        if ((a.high_ | b.high_) == 0) {
            return a.low_ / b.low_;
        }
        PortableInt128 made = 0;
        PortableInt128 rest = 0;
        for (int bit = 127; bit >= 0; --bit) {
            rest = rest << 1 | (a.shifted_down(bit).low_ & 1);
            const bool fits = rest.high() != b.high() ? rest.high() > b.high() : rest.low_ >= b.low_;
            rest = fits ? rest - b : rest;
            made = made << 1 | fits;
        }
        return made;
    }

    std::int64_t high_;  // first, as numbers are ordered
    std::uint64_t low_;
};

// Word128 is for products of words, and wraps around.
// Emscripten's operator new aligns to 8 bytes, and its 128-bit integers want 16.
#if defined(__SIZEOF_INT128__) && !defined(LAMELLA_PORTABLE) && !defined(__EMSCRIPTEN__)
__extension__ using Int128 = __int128;
__extension__ using Word128 = unsigned __int128;
#else
using Int128 = PortableInt128;
using Word128 = PortableInt128;
#endif

}  // namespace lamella
