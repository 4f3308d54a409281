// Numbers in messages.
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "base/bits.hpp"
#include "base/words.hpp"
#include "models/numbers.hpp"

using lamella::exact_text;
using lamella::exact_text_by_trial;

TEST_CASE("numbers are written alike with and without the C++ library's help", "[engine]") {
    lamella::models::Random random(7);
    for (int i = 0; i < 3000; ++i) {
        const auto any = lamella::bits_as<double>(random.next());
        const double decimal = std::round(any / std::exp2(std::ilogb(any)) * 1e6) / std::pow(10, i % 9);
        for (const double value : {any, decimal}) {
            CHECK((std::isnan(value) || exact_text_by_trial(value) == exact_text(value)));
        }
    }
    for (int power = -1074; power < 1024; ++power) {
        CHECK(exact_text_by_trial(std::ldexp(-1, power)) == exact_text(std::ldexp(-1, power)));
    }
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double value :
         {0.0, -0.0, 9.5, 1e21, 123456.0, 0.0001, std::numeric_limits<double>::max(), infinity, -infinity}) {
        CHECK(exact_text_by_trial(value) == exact_text(value));
    }
    CHECK(exact_text(0x1p-24) == "5.960464477539063e-08");
    CHECK(exact_text(100) == "100");
}
