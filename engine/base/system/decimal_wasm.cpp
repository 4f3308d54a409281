#include "base/system/decimal.hpp"

#ifdef __EMSCRIPTEN__

#include <cmath>
#include <cstring>

#include <emscripten.h>

// JavaScript's digits are the shortest, too. It writes an exponent without a leading zero, and no sign of zero.
// clang-format off
EM_JS(int, lamella_write_decimal, (double magnitude, char* text), {
    const parts = magnitude.toExponential().split("e");
    const decimals = parts[0].replace(".", "").length - 1 - parts[1];
    let written = parts[0] + "e" + parts[1][0] + parts[1].slice(1).padStart(2, "0");
    if (decimals < 100) {  // more are longer than an exponent, and refused
        const fixed = decimals > 0 ? magnitude.toFixed(decimals) : BigInt(magnitude).toString();
        written = fixed.length <= written.length ? fixed : written;
    }
    for (let i = 0; i < written.length; ++i) {
        HEAPU8[text + i] = written.charCodeAt(i);
    }
    return written.length;
});
// clang-format on

namespace lamella {

std::size_t write_decimal(double value, char* text) noexcept {
    char* to = text;
    if (std::signbit(value)) {
        *to++ = '-';
    }
    if (std::isfinite(value)) {
        to += lamella_write_decimal(std::fabs(value), to);
    } else {
        std::memcpy(to, std::isnan(value) ? "nan" : "inf", 3);
        to += 3;
    }
    return static_cast<std::size_t>(to - text);
}

}  // namespace lamella

#endif
