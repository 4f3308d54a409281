// Numbers in messages.
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "base/words.hpp"
#include "golden/golden.hpp"
#include "models/numbers.hpp"

using lamella::exact_text;

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
