// The loops written for several instruction sets: every form that this processor supports equals the portable one to the
// bit, and those of the report what an obvious loop gives.
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include <catch2/catch.hpp>

#include "audit/face_sums.hpp"
#include "engine/slicing.hpp"
#include "lamella/result.hpp"
#include "rings.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/edges/edge_runs.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/sweep/band_sweep.hpp"

using namespace lamella;

namespace {

/// A random ring of `count` points; with `repeats`, one point equals the one before it.
void check_ring(const Kernels& form, std::size_t count, std::int32_t reach, bool repeats, std::mt19937& random) {
    const Kernels& portable = portable_of(kernel_forms());
    std::uniform_int_distribution<std::int32_t> coordinate(-reach, reach);
    const std::size_t room = count + 2 * padded_count;
    std::vector<Point> points(room);
    std::vector<std::uint32_t> slots(room, 0);
    for (std::size_t i = 0; i < count; ++i) {
        points[i] = {coordinate(random), coordinate(random)};
        slots[i] = static_cast<std::uint32_t>((7 * i) % count);
    }
    if (repeats) {  // a single repeat, at a random position
        const std::size_t at = random() % count;
        points[slots[(at + 1) % count]] = points[slots[at]];
    }
    std::vector<Point> ring(room);
    std::vector<Point> expected_ring(room);
    const RingFacts facts = form.trace(points.data(), slots.data(), count, ring.data());
    const RingFacts expected = portable.trace(points.data(), slots.data(), count, expected_ring.data());
    CHECK((facts.box == expected.box));
    CHECK(to_integer128(facts.twice_area) == to_integer128(expected.twice_area));
    CHECK(facts.has_repeats == expected.has_repeats);
    CHECK((expected.has_repeats || !repeats));
    ring.resize(count);
    expected_ring.resize(count);
    CHECK(ring == expected_ring);
    const auto smallest = std::min_element(ring.begin(), ring.end());
    CHECK(facts.smallest == static_cast<std::size_t>(smallest - ring.begin()));
    CHECK(facts.many_smallest == (std::count(ring.begin(), ring.end(), *smallest) > 1));
}

std::vector<std::uint32_t> turns_of(const std::vector<Point>& points) {
    std::vector<std::uint32_t> turns;
    int right = 0;
    int up = 0;
    for (std::size_t e = 0; e + 1 < points.size(); ++e) {
        const int own_right = (points[e + 1].x > points[e].x) - (points[e + 1].x < points[e].x);
        const int own_up = (points[e + 1].y > points[e].y) - (points[e + 1].y < points[e].y);
        if (own_right * right < 0 || own_up * up < 0) {
            turns.push_back(static_cast<std::uint32_t>(e));
            right = 0;
            up = 0;
        }
        right = own_right != 0 ? own_right : right;
        up = own_up != 0 ? own_up : up;
    }
    return turns;
}

/// Planes 20 units apart.
PlaneSet planes_from(std::int32_t lowest, std::size_t count) {
    Array<Layer> layers;
    layers.resize_discarding(count);
    for (std::size_t i = 0; i < count; ++i) {
        layers[i].plane = PlaneHeight(lowest + 20 * static_cast<std::int32_t>(i));
    }
    PlaneSet planes(nullptr);
    planes.build(layers);
    return planes;
}

TEST_CASE("a level takes its own forms, and one that the processor lacks is refused by name", "[engine][kernels]") {
    const auto forms = lamella::kernel_forms();
    CHECK(&lamella::best_of(forms, lamella::InstructionSet::portable) == &lamella::portable_of(forms));
    CHECK(&lamella::best_of(forms, lamella::instruction_set()) == &lamella::supported(forms).front().kernel);
    const shapes::Soup box = shapes::box({0, 0, 0}, {1, 1, 1});
    std::size_t refused = 0;
    for (std::size_t i = 0; i < lamella::instruction_set_names.size(); ++i) {
        const auto level = static_cast<lamella::InstructionSet>(i);
        lamella::Slicer slicer;
        lamella::SliceResult result;
        const auto info = slice_tuned(slicer, result, view_of(box), uniform(0.25), {.instructions = level});
        REQUIRE(info.ok() == lamella::runs(level));
        if (!info) {
            CHECK(info.error().code == lamella::ErrorCode::invalid_argument);
            CHECK(info.error().message.find(name_of(level)) != std::string::npos);
            ++refused;
        }
    }
    CHECK(refused > 0);  // no processor has those of x86 and of ARM
}

TEST_CASE("all forms of the kernels agree with the portable form", "[engine][kernels]") {
    std::mt19937 random(7);
    for (const auto& [needs, form] : supported(kernel_forms())) {
        for (const std::int32_t reach : {3, 1 << 20, grid_limit}) {
            for (std::size_t count = 1; count < 70; ++count) {
                check_ring(form, count, reach, false, random);
                check_ring(form, count, reach, true, random);
            }
        }
    }
}

TEST_CASE("areas are exact in boxes too wide for vectors, and beyond 64 bits", "[engine][kernels]") {
    constexpr std::int32_t far = grid_limit;
    std::vector<Point> along_x;
    std::vector<Point> along_y;
    for (std::int32_t i = 0; i < 12; ++i) {  // back and forth between the ends of one axis, 2^31 apart
        along_x.push_back({i % 4 < 2 ? -far : far, i < 6 ? i : 7 * i});
        along_y.push_back({along_x.back().y, along_x.back().x});
    }
    std::vector<Point> turns;
    for (int turn = 0; turn < 10; ++turn) {
        turns.insert(turns.end(), {{-far, -far}, {far, -far}, {far, far}, {-far, far}});
    }
    REQUIRE(rings::twice_area(turns) > INT64_MAX);
    for (std::vector<Point> points : {along_x, along_y, turns}) {
        const std::size_t count = points.size();
        const rings::Int128 area = rings::twice_area(points);
        const Integer128 expected{static_cast<std::uint64_t>(area), static_cast<std::int64_t>(area >> 64)};
        points.resize(count + padded_count, points[0]);
        std::vector<std::uint32_t> slots(points.size());
        std::iota(slots.begin(), slots.end(), 0U);
        for (const auto& [needs, form] : supported(kernel_forms())) {
            std::vector<Point> ring(points.size());
            CHECK(to_integer128(form.trace(points.data(), slots.data(), count, ring.data()).twice_area) == expected);
        }
    }
}

TEST_CASE("edges pierce a plane at the interpolated points", "[engine][kernels]") {
    std::mt19937 random(23);
    const auto even = [&random](std::int32_t reach) {
        return static_cast<std::int32_t>(random() % static_cast<unsigned>(reach / 2)) * 2 - reach / 2;
    };
    Worker worker;
    ActiveEdges edges(nullptr);
    for (Slot count = 1; count < 40; ++count) {
        edges.reserve(count, worker);
        std::vector<Point> expected;
        for (Slot slot = 0; slot < count; ++slot) {
            const GridVertex lower{even(1 << 29), even(1 << 29), -1000 - even(1 << 10)};
            const GridVertex upper{even(1 << 29), even(1 << 29), 1000 + even(1 << 10)};
            edges.put(slot, MeshEdge::between(lower, upper));
            const auto moved = [lower, upper](std::int64_t side) {  // exactly, ties to even
                const std::int64_t height = upper.z - lower.z;
                const std::int64_t all = side * (77 - lower.z);
                const std::int64_t whole = all / height - (all % height < 0 ? 1 : 0);
                const std::int64_t twice_rest = 2 * (all - whole * height);
                return static_cast<std::int32_t>(whole + (twice_rest + (whole & 1) > height ? 1 : 0));
            };
            expected.push_back({lower.x + moved(upper.x - lower.x), lower.y + moved(upper.y - lower.y)});
        }
        for (const auto& [needs, form] : supported(kernel_forms())) {
            std::vector<Point> points(count + padded_count);
            form.pierce(edges.arrays(0), 77, count, points.data());
            points.resize(count);
            CHECK(points == expected);
        }
    }
}

TEST_CASE("edges pierce a plane alike wherever they stand", "[engine][kernels]") {
    // What they move by is nearly a tie, which a double near 0 would tell from one, and one near 2^28 would not.
    constexpr std::int32_t far[padded_count] = {0, 1 << 28, -(1 << 28), 1 << 30, -(1 << 30)};
    constexpr std::int32_t low[padded_count] = {};
    const std::vector<double> up(padded_count, 0.5 + 0x1p-40);
    const std::vector<double> down(padded_count, -0.5 - 0x1p-40);
    for (const auto& [needs, form] : supported(kernel_forms())) {
        std::vector<Point> points(padded_count);
        form.pierce({far, far, low, up.data(), down.data()}, 1, 5, points.data());
        for (std::size_t e = 0; e < 5; ++e) {
            CHECK(points[e] == Point{far[e], far[e]});
        }
    }
}

TEST_CASE("select_equal finds the positions that a loop finds, and writes only within its padding", "[engine][kernels]") {
    std::mt19937 random(11);
    for (std::size_t count = 0; count < 100; ++count) {
        for (const std::uint32_t kinds : {1U, 2U, 40U}) {
            std::vector<std::uint32_t> values(count);
            std::vector<std::uint32_t> expected;
            for (std::size_t i = 0; i < count; ++i) {
                values[i] = 0xFFFFFFF0U + static_cast<std::uint32_t>(random()) % kinds % 16;
                if (values[i] == 0xFFFFFFF0U) {
                    expected.push_back(static_cast<std::uint32_t>(i));
                }
            }
            for (const auto& [needs, kernels] : supported(kernel_forms())) {
                std::vector<std::uint32_t> found(count + select_padding + 1, 77);
                const std::size_t n = kernels.select_equal(values.data(), count, 0xFFFFFFF0U, found.data());
                CHECK(found.back() == 77);
                found.resize(n);
                CHECK(found == expected);
            }
        }
    }
}

TEST_CASE("every form finds where paths turn, also along the axes", "[engine][crossings][kernels]") {
    std::mt19937 random(5);
    for (int round = 0; round < 4000; ++round) {
        const unsigned range = round % 2 == 0 ? 3 : 1000;
        std::vector<Point> points(1 + random() % 100);
        for (Point& point : points) {
            point = {static_cast<std::int32_t>(random() % range), static_cast<std::int32_t>(random() % range)};
        }
        if (round % 3 == 0) {  // long runs
            std::sort(points.begin(), points.end());
        }
        for (const auto& [needs, form] : supported(find_turns_forms())) {
            std::vector<std::uint32_t> turns(points.size());
            std::vector<Point> with_room = points;
            with_room.resize(points.size() + turn_lanes, points[random() % points.size()]);
            turns.resize(form(with_room.data(), points.size() - 1, turns.data()));
            REQUIRE(turns == turns_of(points));
        }
    }
}

TEST_CASE("every form adds a corner of a face alike", "[engine][volume][kernels]") {
    std::mt19937 random(7);
    const PlaneSet planes = planes_from(1, 37);
    const PlaneHeights heights(planes);
    for (int round = 0; round < 2000; ++round) {
        const auto low = 2 * static_cast<std::int32_t>(random() % 400) - 20;
        const auto high = low + 2 * static_cast<std::int32_t>(1 + random() % 300);
        const double bend = std::ldexp(static_cast<double>(random()) - 0x1p31, static_cast<int>(random() % 60));
        const PlaneIndex first = planes.first_above(low);
        const PlaneIndex last = planes.first_above(high);
        const auto sums_of = [&](const CornerKernels& form) {
            CornerSums sums(planes.size());
            form.rising(heights.z(), {double(low), double(high), bend, bend / 3, first, last}, sums);
            form.falling(heights.z(), {double(high), double(low), -bend, -bend / 3, first, last}, sums);
            return sums;
        };
        const CornerSums expected = sums_of(portable_of(corner_kernel_forms()));
        for (const auto& [needs, form] : supported(corner_kernel_forms())) {
            const CornerSums sums = sums_of(form);
            for (std::size_t i = 0; i <= planes.size(); ++i) {
                REQUIRE(sums.area(i) == expected.area(i));
                REQUIRE(sums.volume(i) == expected.volume(i));
            }
        }
    }
}

TEST_CASE("sums of millions of equal corners do not overflow their limbs", "[engine][volume]") {
    const PlaneSet planes = planes_from(101, 1);
    const PlaneHeights heights(planes);
    const GridTriangle face = {GridVertex{0, 0, 0}, {2'000'006, 14, 154}, {6, 2'000'002, 306}};
    FaceSums once(planes, heights, {60, 28});
    once.add(face);
    PlaneSums single;
    once.add_to(single, 0);
    REQUIRE(single.area != 0);
    constexpr int times = 6'000'000;
    FaceSums often(planes, heights, {60, 28});
    for (int i = 0; i < times; ++i) {
        often.add(face);
    }
    PlaneSums all;
    often.add_to(all, 0);
    CHECK(all.area == single.area * times);
    CHECK(all.volume == single.volume * times);
}

/// Of one triangle, as obvious as can be.
bool near_each_other(const float* t, float reach) {
    const auto near = [&](int a, int b) {
        const auto within = [&](int axis) { return std::abs(t[3 * a + axis] - t[3 * b + axis]) <= reach; };
        return within(0) && within(1) && within(2);
    };
    return near(0, 1) || near(1, 2) || near(2, 0);
}

TEST_CASE("each level measures a soup's blocks as an obvious loop does, and finds each number that is not finite",
          "[engine][kernels]") {
    std::mt19937 random(5);
    const std::size_t count = GENERATE(as<std::size_t>{}, 1, 2, 63, 64, 65, 200);
    constexpr double unit_mm = 0x1p-10;
    std::vector<float> xyz(9 * count);
    for (float& number : xyz) {  // of few values, so that vertices often agree on one axis or two
        number = static_cast<float>(random() % 8) + (random() % 2 == 0 ? 0.0F : static_cast<float>(3 * unit_mm));
    }
    for (std::size_t i = 0; i < instruction_set_names.size(); ++i) {
        BlockTable table(nullptr);
        table.instructions = static_cast<InstructionSet>(i);
        if (!runs(table.instructions)) {
            continue;
        }
        const auto measured = [&] {
            return measure_bounds(MeshView::soup(std::span<const float>(xyz)), {}, unit_mm, Parallel({.threads = 1}), table);
        };
        const Result<Bounds> box = measured();
        REQUIRE(box);
        Bounds expected = Bounds::empty();
        for (std::size_t block = 0; block < table.blocks.size(); ++block) {
            bool near = false;
            Bounds own = Bounds::empty();
            for (std::size_t t = 64 * block; t < std::min(count, 64 * (block + 1)); ++t) {
                near = near || near_each_other(&xyz[9 * t], static_cast<float>(table.near_mm));
                for (int number = 0; number < 9; ++number) {
                    const double mm = static_cast<double>(xyz[9 * t + static_cast<std::size_t>(number)]);
                    own.add(number % 3, mm, mm);
                }
            }
            const TriangleBlock& found = table.blocks[block];
            CHECK((found.near == near && found.low_mm == own.min_mm[2] && found.high_mm == own.max_mm[2]));
            expected.add(own);
        }
        for (int axis = 0; axis < 3; ++axis) {
            CHECK((box->min_mm[axis] == expected.min_mm[axis] && box->max_mm[axis] == expected.max_mm[axis]));
        }
        for (std::size_t at = 9 * (count - 1); at < 9 * count; ++at) {
            for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
                const float good = std::exchange(xyz[at], bad);
                const Result<Bounds> refused = measured();
                REQUIRE_FALSE(refused);
                CHECK(refused.error().triangle == static_cast<std::int64_t>(count - 1));
                xyz[at] = good;
            }
        }
    }
}

}  // namespace
