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

TEST_CASE("select_equal finds what a loop finds, and writes no further than it may", "[engine][kernels]") {
    std::mt19937 random(11);
    for (const lamella::Kernels* kernels : {&lamella::kernels_for_this_cpu(), &lamella::portable_kernels()}) {
        for (std::size_t count = 0; count < 100; ++count) {
            for (const std::uint32_t kinds : {1U, 2U, 40U}) {
                std::vector<std::uint32_t> values(count);
                std::vector<std::uint32_t> expected;
                for (std::size_t i = 0; i < count; ++i) {
                    values[i] = 0xFFFFFFF0U + static_cast<std::uint32_t>(random()) % kinds % 16;
                    if (values[i] == 0xFFFFFFF1U - (kinds == 1 ? 1 : 0)) {
                        expected.push_back(static_cast<std::uint32_t>(i));
                    }
                }
                const std::uint32_t wanted = 0xFFFFFFF1U - (kinds == 1 ? 1 : 0);
                std::vector<std::uint32_t> found(count + lamella::select_padding + 1, 77);
                const std::size_t n = kernels->select_equal(values.data(), count, wanted, found.data());
                CHECK(found.back() == 77);
                found.resize(n);
                CHECK(found == expected);
            }
        }
    }
}
