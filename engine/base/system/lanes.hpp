// A few numbers side by side, which compilers keep in one register; else in an array, with the same results lane by lane.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace lamella {

#if defined(__GNUC__) && !defined(LAMELLA_PORTABLE)
using TwoDoubles = double __attribute__((vector_size(16)));
using FourFloats = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));
#else

template <class T, std::size_t count>
struct Lanes {
    T lane[count];

    T operator[](std::size_t i) const noexcept { return lane[i]; }

    friend Lanes operator+(const Lanes& a, const Lanes& b) noexcept { return a.with(b, std::plus()); }
    friend Lanes operator*(const Lanes& a, const Lanes& b) noexcept { return a.with(b, std::multiplies()); }
    friend Lanes operator*(const Lanes& a, T b) noexcept {
        return a.with(a, [b](T x, T) { return x * b; });
    }
    friend Lanes operator/(const Lanes& a, T b) noexcept {
        return a.with(a, [b](T x, T) { return x / b; });
    }
    friend Lanes operator|(const Lanes& a, const Lanes& b) noexcept { return a.with(b, std::bit_or()); }
    // -1 where it holds, else 0.
    friend Lanes operator>(const Lanes& a, const Lanes& b) noexcept {
        return a.with(b, [](T x, T y) { return -(x > y); });
    }
    friend Lanes operator==(const Lanes& a, const Lanes& b) noexcept {
        return a.with(b, [](T x, T y) { return -(x == y); });
    }

private:
    template <class Does>
    Lanes with(const Lanes& b, const Does& does) const noexcept {
        Lanes made;
        for (std::size_t i = 0; i < count; ++i) {
            made.lane[i] = does(lane[i], b.lane[i]);
        }
        return made;
    }
};

using TwoDoubles = Lanes<double, 2>;
using FourFloats = Lanes<float, 4>;
using FourInts = Lanes<std::int32_t, 4>;
#endif

}  // namespace lamella
