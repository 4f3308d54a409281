// 177,000 layers on lattices, each by every fill rule: 354,000 regions by even-odd and by non-zero, and as many by the
// others.
#include <random>

#include <catch2/catch.hpp>

#include "regions/lattice.hpp"

TEST_CASE("all of 708,000 regions on lattices are exact in area and structure", "[lattices_long]") {
    constexpr int layers = 177'000;
    std::mt19937 random(20);
    for (int number = 0; number < layers; ++number) {
        const std::int32_t size = number % 2 == 0 ? 12 : 3 + number / 2 % 9;
        const regions::Polygons polygons = regions::random_octilinear(random, size);
        const std::string fault = regions::judge_octilinear(polygons, size, regions::random_placement(random, size), random);
        if (!fault.empty()) {
            FAIL("layer " << number << ", " << fault);
        }
    }
}
