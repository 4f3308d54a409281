// Orientation and nesting of one layer against written-down answers and a brute-force oracle.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "layer_sample.hpp"

using lamella::Nester;
using lamella::NestItem;
using lamella::Point;
using lamella::Role;
using lamella::test::LayerSample;

namespace {

/// Nests `sample` and compares every output with the oracle's.
void check_against_oracle(const LayerSample& sample) {
    std::vector<NestItem> items = sample.items();
    Nester(nullptr).nest(items);
    REQUIRE(lamella::test::first_difference(items, sample.expected()) == -1);
}

/// The outputs of a layer whose contours were put in with `order`, as indices of the unshuffled contours.
std::vector<NestItem> nest_permuted(const LayerSample& sample, const std::vector<std::size_t>& order, Nester& nester) {
    const std::vector<NestItem> plain = sample.items();
    std::vector<NestItem> shuffled;
    for (const std::size_t i : order) {
        shuffled.push_back(plain[i]);
    }
    nester.nest(shuffled);
    std::vector<NestItem> back(plain.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        back[order[i]] = shuffled[i];
        if (shuffled[i].parent >= 0) {
            back[order[i]].parent = static_cast<std::int32_t>(order[static_cast<std::size_t>(shuffled[i].parent)]);
        }
    }
    return back;
}

}  // namespace

TEST_CASE("an empty layer and a layer of one contour", "[nesting]") {
    Nester nester(nullptr);
    nester.nest({});
    LayerSample sample;
    sample.add_box({0, 0}, {10, 10}, false);
    std::vector<NestItem> items = sample.items();
    nester.nest(items);
    CHECK(items[0].role == Role::outer);
    CHECK(items[0].parent == -1);
    CHECK(items[0].sense == 1);
    CHECK_FALSE(items[0].reverse);
    CHECK(items[0].flags == 0);
}

TEST_CASE("a hole belongs to the smallest contour around it", "[nesting]") {
    LayerSample sample;
    sample.add_box({30, 30}, {40, 40}, true);
    sample.add_box({0, 0}, {100, 100}, false);
    sample.add_box({20, 20}, {50, 50}, false);
    sample.add_box({10, 10}, {90, 90}, true);
    std::vector<NestItem> items = sample.items();
    Nester(nullptr).nest(items);
    CHECK(items[0].parent == 2);
    CHECK(items[1].parent == -1);
    CHECK(items[2].parent == 3);
    CHECK(items[3].parent == 1);
    CHECK(items[0].role == Role::hole);
    CHECK(items[2].role == Role::outer);
    CHECK(items[3].role == Role::hole);
    CHECK(std::none_of(items.begin(), items.end(), [](const NestItem& item) { return item.reverse || item.flags != 0; }));
}

TEST_CASE("an inverted shell is turned round and marked", "[nesting]") {
    LayerSample sample;
    sample.add_box({0, 0}, {100, 100}, true);
    sample.add_box({10, 10}, {90, 90}, false);
    sample.add_box({200, 0}, {300, 100}, false);
    std::vector<NestItem> items = sample.items();
    items[0].flags = lamella::sense_mixed;
    Nester(nullptr).nest(items);
    CHECK(items[0].role == Role::outer);
    CHECK(items[0].sense == -1);
    CHECK(items[0].reverse);
    CHECK(items[0].flags == (lamella::sense_mixed | lamella::sense_overruled));
    CHECK(items[1].role == Role::hole);
    CHECK(items[1].sense == 1);
    CHECK(items[1].reverse);
    CHECK(items[1].flags == lamella::sense_overruled);
    CHECK(items[2].role == Role::outer);
    CHECK(items[2].flags == 0);
}

TEST_CASE("shells of equal sense nest without being turned", "[nesting]") {
    LayerSample sample;  // windings from outside in: 1, 2, 1, 0, and then one below zero
    sample.add_box({0, 0}, {100, 100}, false);
    sample.add_box({10, 10}, {90, 90}, false);
    sample.add_box({20, 20}, {80, 80}, true);
    sample.add_box({30, 30}, {70, 70}, true);
    sample.add_box({40, 40}, {60, 60}, true);
    std::vector<NestItem> items = sample.items();
    Nester(nullptr).nest(items);
    const Role roles[] = {Role::outer, Role::outer, Role::hole, Role::hole, Role::outer};
    for (std::size_t i = 0; i < items.size(); ++i) {
        CHECK(items[i].parent == static_cast<std::int32_t>(i) - 1);
        CHECK(items[i].role == roles[i]);
        CHECK((items[i].flags == lamella::sense_overruled) == (i == 4));
        CHECK(items[i].reverse == (i == 4));
    }
}

TEST_CASE("open and flat contours take no part", "[nesting]") {
    LayerSample sample;
    sample.add_box({0, 0}, {100, 100}, false);
    sample.add({{10, 10}, {50, 50}}, true);
    sample.add({{20, 10}, {80, 10}, {80, 90}}, false);
    sample.add_box({40, 12}, {60, 20}, true);
    std::vector<NestItem> items = sample.items();
    Nester(nullptr).nest(items);
    CHECK(items[1].role == Role::flat);
    CHECK(items[2].role == Role::open);
    CHECK(items[1].parent == -1);
    CHECK(items[2].parent == -1);
    CHECK(items[1].sense == 0);
    CHECK(items[2].sense == 0);
    CHECK(items[3].parent == 0);
}

TEST_CASE("a start on a boundary is not inside", "[nesting]") {
    LayerSample sample;
    sample.add_box({0, 0}, {100, 100}, false);
    sample.add_box({0, 20}, {30, 40}, true);                     // starts on the left edge
    sample.add({{10, 0}, {60, 10}, {10, 20}}, true);             // on the bottom edge
    sample.add({{0, 0}, {90, 10}, {10, 90}}, true);              // at the corner
    sample.add({{40, 40}, {50, 30}, {60, 40}, {50, 50}}, true);  // on the edge of the one before
    sample.add({{40, 40}, {50, 50}, {60, 40}, {50, 30}}, true);  // its twin: neither is inside the other
    sample.add({{45, 35}, {52, 35}, {50, 40}}, true);            // on an edge of the twins
    sample.add({{50, 50}, {60, 60}, {40, 60}}, true);            // on their corner and the edge of 3
    std::vector<NestItem> items = sample.items();
    Nester(nullptr).nest(items);
    const std::int32_t parents[] = {-1, -1, -1, -1, 3, 3, 3, 0};
    for (std::size_t i = 0; i < items.size(); ++i) {
        CAPTURE(i);
        CHECK(items[i].parent == parents[i]);
    }
    check_against_oracle(sample);
}

TEST_CASE("the whole range of the grid is exact", "[nesting]") {
    constexpr std::int32_t far = lamella::grid_limit;
    LayerSample sample;
    sample.add({{-far, -far}, {far, far - 1}, {far, far}}, true);
    sample.add({{0, 0}, {2, 1}, {1, 1}}, true);  // starts on or beside the long edges
    sample.add({{-1, -1}, {2, 1}, {1, 1}}, true);
    sample.add({{far - 2, far - 2}, {far - 1, far - 2}, {far - 1, far - 1}}, true);
    sample.add_box({-far, -far}, {far, far}, true);
    check_against_oracle(sample);
}

TEST_CASE("random layers agree with the oracle", "[nesting]") {
    std::mt19937 random(GENERATE(1U, 2U, 3U, 4U));
    for (int round = 0; round < 1500; ++round) {
        CAPTURE(round);
        check_against_oracle(lamella::test::random_layer(random));
    }
}

TEST_CASE("nesting does not depend on the order of contours or on earlier layers", "[nesting]") {
    std::mt19937 random(7);
    Nester nester(nullptr);
    for (int round = 0; round < 300; ++round) {
        LayerSample sample = lamella::test::random_layer(random);
        sample.drop_repeated();  // equal contours are told apart by index only
        std::vector<std::size_t> order(sample.size());
        for (std::size_t i = 0; i < order.size(); ++i) {
            order[i] = i;
        }
        std::shuffle(order.begin(), order.end(), random);
        CAPTURE(round);
        REQUIRE(lamella::test::first_difference(nest_permuted(sample, order, nester), sample.expected()) == -1);
    }
}
