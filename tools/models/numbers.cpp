#include "models/numbers.hpp"

#include <cfloat>

#include "base/numbers.hpp"

namespace lamella::models {

static_assert(FLT_EVAL_METHOD == 0, "intermediate results in extended precision would change the bytes");

namespace {

// Taylor series on [-pi/4, pi/4]; the first omitted terms are below 2^-54.
SinCos sincos_octant(double r) noexcept {
    const double q = -r * r;
    double s = 1;
    double c = 1;
    for (int k = 16; k >= 2; k -= 2) {
        s = 1 + s * q / (k * (k + 1));
        c = 1 + c * q / (k * (k - 1));
    }
    return {r * s, c};
}

}  // namespace

SinCos sincos_turns(double turns) noexcept {
    double fraction = turns - static_cast<double>(static_cast<std::int64_t>(turns));
    if (fraction < 0) {
        fraction += 1;
    }
    const int quarter = static_cast<int>(fraction * 8 + 1) / 2;  // the nearest quarter turn
    const SinCos at = sincos_octant((fraction - quarter * 0.25) * tau);
    switch (quarter & 3) {
        case 0:
            return at;
        case 1:
            return {at.cos, -at.sin};
        case 2:
            return {-at.sin, -at.cos};
        default:
            return {-at.cos, at.sin};
    }
}

std::uint64_t Random::next() noexcept {
    state_ += 0x9e3779b97f4a7c15U;
    return mix64(state_);
}

}  // namespace lamella::models
