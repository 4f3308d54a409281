// Portable forms of what compilers have of their own give the same numbers; and numbers in messages.
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "base/system/processor.hpp"
#include "base/words.hpp"
#include "golden/golden.hpp"
#include "models/numbers.hpp"

using lamella::exact_text;

#ifdef __SIZEOF_INT128__

using lamella::PortableInt128;

namespace {

__extension__ using Signed = __int128;
__extension__ using Unsigned = unsigned __int128;  // wraps around, as portable numbers do

bool are_equal(PortableInt128 a, Unsigned b) {
    return static_cast<std::uint64_t>(a) == static_cast<std::uint64_t>(b) &&
           static_cast<std::uint64_t>(a >> 64) == static_cast<std::uint64_t>(b >> 64);
}

/// Powers of two, what is next to them, sums of two of them, and the opposites of all.
std::vector<Unsigned> edge_values() {
    std::vector<Unsigned> values = {0};
    for (const int bits : {0, 1, 23, 31, 32, 33, 52, 53, 54, 63, 64, 65, 75, 96, 117, 126, 127}) {
        const Unsigned power = Unsigned{1} << bits;
        for (const Unsigned value :
             {power, power - 1, power + 1, power + (Unsigned{1} << bits / 2), power - static_cast<unsigned>(bits)}) {
            values.insert(values.end(), {value, -value});
        }
    }
    return values;
}

}  // namespace

TEST_CASE("portable 128-bit integers are those of the compiler", "[engine][numbers]") {
    std::size_t wrong = 0;
    const auto check = [&](bool right) { wrong += right ? 0 : 1; };
    for (const Unsigned a : edge_values()) {
        const auto sa = static_cast<Signed>(a);
        const PortableInt128 pa = PortableInt128(static_cast<std::int64_t>(a >> 64)) << 64 | static_cast<std::uint64_t>(a);
        check(are_equal(pa, a) && are_equal(-pa, -a) && are_equal(~pa, ~a));
        check(static_cast<double>(pa) == static_cast<double>(sa));
        check(static_cast<std::int32_t>(pa) == static_cast<std::int32_t>(sa));
        for (int bits = 0; bits < 128; ++bits) {
            check(are_equal(pa << bits, a << bits) && are_equal(pa >> bits, static_cast<Unsigned>(sa >> bits)));
        }
        for (const Unsigned b : edge_values()) {
            const auto sb = static_cast<Signed>(b);
            const PortableInt128 pb =
                PortableInt128(static_cast<std::int64_t>(b >> 64)) << 64 | static_cast<std::uint64_t>(b);
            check(are_equal(pa + pb, a + b) && are_equal(pa - pb, a - b) && are_equal(pa * pb, a * b));
            check(are_equal(pa | pb, a | b));
            check((pa < pb) == (sa < sb) && (pa <= pb) == (sa <= sb) && (pa == pb) == (sa == sb));
            const bool overflows = a == Unsigned{1} << 127 && sb == -1;
            if (b != 0 && !overflows) {
                check(are_equal(pa / pb, static_cast<Unsigned>(sa / sb)) &&
                      are_equal(pa % pb, static_cast<Unsigned>(sa % sb)));
            }
        }
    }
    CHECK(wrong == 0);
    CHECK(are_equal(2 * PortableInt128(std::int32_t{-3}) - ~std::uint64_t{0}, -Unsigned{6} - ~std::uint64_t{0}));
}

#endif

TEST_CASE("bytes of words are reversed, and halves rounded to even", "[engine][numbers]") {
    CHECK(lamella::reversed_bytes(std::uint64_t{0x0123456789ABCDEF}) == 0xEFCDAB8967452301);
    CHECK(lamella::reversed_bytes(std::uint32_t{0x01234567}) == 0x67452301);
    CHECK(lamella::reversed_bytes(std::uint16_t{0x0123}) == 0x2301);
    CHECK(lamella::reversed_bytes(std::uint8_t{0x01}) == 0x01);
    for (const auto& [value, rounded] : {std::pair{0.5, 0}, {1.5, 2}, {-2.5, -2}, {2.4999, 2}}) {
        CHECK(lamella::round_to_int(value) == rounded);
    }
}

TEST_CASE("numbers are written in their shortest form", "[engine]") {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const auto& [value, text] : std::initializer_list<std::pair<double, const char*>>{
             {0.0, "0"},
             {-0.0, "-0"},
             {100, "100"},
             {9.5, "9.5"},
             {-9.5, "-9.5"},
             {10000, "10000"},
             {1e5, "1e+05"},
             {123456, "123456"},
             {0.001, "0.001"},
             {0.0001, "1e-04"},
             {0x1p-24, "5.960464477539063e-08"},
             {1e21, "1e+21"},
             {0x1p70, "1180591620717411303424"},
             {0x1p-1074, "5e-324"},
             {std::numeric_limits<double>::max(), "1.7976931348623157e+308"},
             {std::numeric_limits<double>::lowest(), "-1.7976931348623157e+308"},
             {infinity, "inf"},
             {-infinity, "-inf"},
             {std::numeric_limits<double>::quiet_NaN(), "nan"},
         }) {
        CHECK(exact_text(value) == text);
    }
}

TEST_CASE("numbers are written alike on every platform", "[engine]") {
    lamella::models::Random random(7);
    std::string texts;
    const auto add = [&](double value) { texts += exact_text(value) + "\n"; };
    for (int i = 0; i < 3000; ++i) {
        const auto any = lamella::bits_as<double>(random.next());
        if (!std::isnan(any)) {
            add(any);
            add(std::round(std::ldexp(any, -std::ilogb(any)) * 1e6) / std::pow(10, i % 9));
        }
    }
    for (int power = -1074; power < 1024; ++power) {
        add(std::ldexp(-1, power));
    }
    CHECK(golden::hash_of(texts) == 0x8750C026C8083EAAU);
}
