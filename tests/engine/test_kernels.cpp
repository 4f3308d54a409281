// The kernels chosen for this processor give what the portable ones give, to the bit.
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "base/kernels.hpp"

using lamella::Point;

TEST_CASE("kernels agree with the portable ones", "[engine][kernels]") {
    const lamella::Kernels& chosen = lamella::kernels_for_this_cpu();
    const lamella::Kernels& portable = lamella::portable_kernels();
    std::mt19937 random(7);
    for (const std::int32_t reach : {3, 1 << 20, lamella::grid_limit}) {
        std::uniform_int_distribution<std::int32_t> coordinate(-reach, reach);
        for (std::size_t count = 1; count < 70; ++count) {
            const std::size_t room = count + 2 * lamella::padded_count;
            std::vector<Point> points(room);
            std::vector<std::uint32_t> slots(room, 0);
            for (std::size_t i = 0; i < count; ++i) {
                points[i] = {coordinate(random), coordinate(random)};
                slots[i] = static_cast<std::uint32_t>((7 * i) % count);
            }
            std::vector<Point> ring(room);
            std::vector<Point> expected_ring(room);
            const lamella::RingFacts facts = chosen.trace(points.data(), slots.data(), count, ring.data());
            const lamella::RingFacts expected = portable.trace(points.data(), slots.data(), count, expected_ring.data());
            CHECK(facts.box_min == expected.box_min);
            CHECK(facts.box_max == expected.box_max);
            CHECK(lamella::to_wide(facts.twice_area) == lamella::to_wide(expected.twice_area));
            CHECK(facts.has_repeats == expected.has_repeats);
            ring.resize(count);
            expected_ring.resize(count);
            CHECK(ring == expected_ring);
            ring.resize(room);
            const std::int32_t x = ring[count / 2].x;
            CHECK(chosen.find_x(ring.data(), 0, count, x) == portable.find_x(ring.data(), 0, count, x));
        }
    }
}
