// The loops of the report that are written for several instruction sets: all forms give the same, and what an obvious loop
// gives.
#include <algorithm>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "audit/face_sums.hpp"
#include "engine/slicing.hpp"
#include "slicing/edges/run_kernels.hpp"

using lamella::Point;

namespace {

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

struct Boxes {
    std::vector<std::int32_t> low_x;
    std::vector<std::int32_t> low_y;
    std::vector<std::int32_t> high_x;
    std::vector<std::int32_t> high_y;
    std::vector<std::uint32_t> run;

    lamella::BoxArrays arrays() const { return {low_x.data(), low_y.data(), high_x.data(), high_y.data(), run.data()}; }
    bool meet(std::size_t i, std::size_t j, std::int32_t from_x) const {
        return low_x[j] <= high_x[i] && low_x[i] <= high_x[j] && low_y[j] <= high_y[i] && low_y[i] <= high_y[j] &&
               std::max(low_x[i], low_x[j]) >= from_x && run[i] + 1 != run[j] && run[j] + 1 != run[i];
    }
};

Boxes random_boxes(std::mt19937& random, std::size_t count, int range) {
    const auto below = [&](int n) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(n)); };
    Boxes boxes;
    for (std::size_t i = 0; i < count; ++i) {
        boxes.low_x.push_back(below(range));
        boxes.high_x.push_back(boxes.low_x.back() + below(range / 2));
        boxes.low_y.push_back(below(range));
        boxes.run.push_back(static_cast<std::uint32_t>(below(range)));
    }
    std::sort(boxes.low_y.begin(), boxes.low_y.end());
    for (const std::int32_t low : boxes.low_y) {
        boxes.high_y.push_back(low + below(range / 2));
    }
    for (std::vector<std::int32_t>* numbers : {&boxes.low_x, &boxes.low_y, &boxes.high_x, &boxes.high_y}) {
        numbers->resize(count + lamella::run_lanes);
    }
    boxes.run.resize(count + lamella::run_lanes);
    return boxes;
}

}  // namespace

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
        for (const auto& [needs, form] : lamella::supported(lamella::run_kernel_forms())) {
            std::vector<std::uint32_t> turns(points.size());
            std::vector<Point> with_room = points;
            with_room.resize(points.size() + lamella::turn_lanes, points[random() % points.size()]);
            turns.resize(form.find_turns(with_room.data(), points.size() - 1, turns.data()));
            REQUIRE(turns == turns_of(points));
        }
    }
}

TEST_CASE("every form finds the boxes that meet a box", "[engine][crossings][kernels]") {
    std::mt19937 random(6);
    for (int round = 0; round < 1000; ++round) {
        const std::size_t count = 1 + random() % 40;
        const Boxes boxes = random_boxes(random, count, round % 2 == 0 ? 12 : 200);
        const auto from_x = static_cast<std::int32_t>(random() % 12);
        for (std::size_t i = 0; i < count; ++i) {
            std::vector<std::uint32_t> expected;
            std::size_t beside = 0;
            for (std::size_t j = i + 1; j < count; ++j) {
                beside += boxes.low_y[j] <= boxes.high_y[i] ? 1 : 0;
                if (boxes.meet(i, j, from_x)) {
                    expected.push_back(static_cast<std::uint32_t>(j));
                }
            }
            for (const auto& [needs, form] : lamella::supported(lamella::run_kernel_forms())) {
                std::vector<std::uint32_t> found(count);
                const lamella::BoxesMet meeting = form.find_meeting(boxes.arrays(), i, count, from_x, found.data());
                found.resize(meeting.found);
                REQUIRE(found == expected);
                REQUIRE(meeting.beside == beside);
            }
        }
    }
}

TEST_CASE("every form adds a corner of a face alike", "[engine][volume][kernels]") {
    std::mt19937 random(7);
    lamella::PlaneSet planes(nullptr);
    lamella::Array<lamella::Layer> layers;
    layers.resize_discarding(37);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        layers[i].plane = lamella::PlaneHeight(static_cast<std::int32_t>(20 * i + 1));
    }
    planes.build(layers);
    const lamella::PlaneHeights heights(planes);
    for (int round = 0; round < 2000; ++round) {
        const auto low = 2 * static_cast<std::int32_t>(random() % 400) - 20;
        const auto high = low + 2 * static_cast<std::int32_t>(1 + random() % 300);
        const double bend = std::ldexp(static_cast<double>(random()) - 0x1p31, static_cast<int>(random() % 60));
        const lamella::PlaneIndex first = planes.first_above(low);
        const lamella::PlaneIndex last = planes.first_above(high);
        const auto sums_of = [&](const lamella::CornerKernels& form) {
            lamella::CornerSums sums(planes.size());
            form.rising(heights.z(), {double(low), double(high), bend, bend / 3, first, last}, sums);
            form.falling(heights.z(), {double(high), double(low), -bend, -bend / 3, first, last}, sums);
            return sums;
        };
        const lamella::CornerSums expected = sums_of(lamella::portable_of(lamella::corner_kernel_forms()));
        for (const auto& [needs, form] : lamella::supported(lamella::corner_kernel_forms())) {
            const lamella::CornerSums sums = sums_of(form);
            for (std::size_t i = 0; i <= planes.size(); ++i) {
                REQUIRE(sums.area(i) == expected.area(i));
                REQUIRE(sums.volume(i) == expected.volume(i));
            }
        }
    }
}

TEST_CASE("sums of millions of equal corners do not overflow their limbs", "[engine][volume]") {
    lamella::PlaneSet planes(nullptr);
    lamella::Array<lamella::Layer> layers;
    layers.resize_discarding(1);
    layers[0].plane = lamella::PlaneHeight(101);
    planes.build(layers);
    const lamella::PlaneHeights heights(planes);
    const lamella::GridTriangle face = {lamella::GridVertex{0, 0, 0}, {2'000'006, 14, 154}, {6, 2'000'002, 306}};
    lamella::FaceSums once(planes, heights, {60, 28});
    once.add(face);
    lamella::PlaneSums single;
    once.add_to(single, 0);
    REQUIRE(single.area != 0);
    constexpr int times = 6'000'000;
    lamella::FaceSums often(planes, heights, {60, 28});
    for (int i = 0; i < times; ++i) {
        often.add(face);
    }
    lamella::PlaneSums all;
    often.add_to(all, 0);
    CHECK(all.area == single.area * times);
    CHECK(all.volume == single.volume * times);
}
