// The parts of nesting, each compared with a brute-force answer: sorting by keys, starts within boxes, points within
// contours.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <random>

#include "base/vector.hpp"
#include "layer_sample.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/nesting/inside.hpp"
#include "slicing/nesting/order.hpp"

using lamella::Point;
using lamella::Vector;
using lamella::nesting::ManyInside;
using lamella::nesting::SortKey;
using lamella::test::below;

namespace {

using Keys = Vector<SortKey>;

bool before(const SortKey& a, const SortKey& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
}

bool equal(const SortKey& a, const SortKey& b) {
    return a.key == b.key && a.index == b.index;
}

/// Points sorted by x. If `size` is small, many share an x or a y.
Keys random_starts(std::mt19937& random, int count, int size) {
    Keys keys;
    for (int i = 0; i < count; ++i) {
        keys.push_back({lamella::nesting::key_of({below(random, size) - size / 2, below(random, size) - size / 2}), 0});
    }
    std::sort(keys.begin(), keys.end(), before);
    return keys;
}

Point point_of(const SortKey& key) {
    return {lamella::nesting::x_of(key.key), lamella::nesting::y_of(key.key)};
}

struct Box {
    Point min, max;
};

Box random_box(std::mt19937& random, int size) {
    const Point a{below(random, size) - size / 2, below(random, size) - size / 2};
    const Point b{below(random, size) - size / 2, below(random, size) - size / 2};
    return {{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}};
}

/// The starts strictly within the box, except those already taken off.
std::vector<std::uint32_t> expected_within(const Keys& starts, const std::vector<bool>& taken_off, const Box& box) {
    std::vector<std::uint32_t> within;
    for (std::uint32_t i = 0; i < starts.size(); ++i) {
        const Point p = point_of(starts[i]);
        if (!taken_off[i] && box.min.x < p.x && p.x < box.max.x && box.min.y < p.y && p.y < box.max.y) {
            within.push_back(i);
        }
    }
    return within;
}

std::vector<std::uint32_t> sorted(const Vector<std::uint32_t>& found) {
    std::vector<std::uint32_t> copy(found.begin(), found.end());
    std::sort(copy.begin(), copy.end());
    return copy;
}

}  // namespace

TEST_CASE("keys are sorted whatever their number and distribution", "[nesting]") {
    std::mt19937_64 random(1);
    const int count = GENERATE(0, 1, 2, 24, 25, 100, 1023, 1024, 5000);
    Keys spare;
    for (int spread = 0; spread < 6; ++spread) {
        Keys keys;
        for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
            const std::uint64_t number = random();
            const std::uint64_t kinds[] = {
                number,                                                   // all bits vary
                number % 7,                                               // few values
                (number % 3 << 62) + (number >> 40),                      // clusters that one digit hardly separates
                0x8000'0000'0000'0000U - 50 + number % 100,               // across a carry into all bits
                (0x7FFF'FFF0U + number % 32) << 32 | (0x8000'0000U - i),  // points around the origin, in reverse
                number % 50 == 0 ? number : static_cast<std::uint64_t>(count) - i,  // close together, with a few outliers
            };
            keys.push_back({kinds[spread], i});
        }
        Keys expected = keys;
        std::sort(expected.begin(), expected.end(), before);
        lamella::StopPace pace;
        lamella::nesting::sort_keys(keys, spare, pace);
        CAPTURE(spread);
        REQUIRE(std::equal(keys.begin(), keys.end(), expected.begin(), expected.end(), equal));
    }
}

TEST_CASE("the tree of starts finds the starts within a box", "[nesting]") {
    std::mt19937 random(GENERATE(1U, 2U, 3U));
    const int count = GENERATE(1, 15, 16, 17, 300, 5000);
    const int size = GENERATE(3, 60, 1 << 30);
    const double aspect = GENERATE(0.0, 1.0, 1e9);
    const Keys starts = random_starts(random, count, size);
    lamella::Worker worker;
    lamella::PointTree tree(worker);
    for (const Keys& keys : {random_starts(random, 6000, size), starts}) {  // earlier contents must leave no trace
        tree.assign(
            keys.size(), [&](std::size_t i) { return point_of(keys[i]); }, aspect);
    }
    std::vector<bool> taken_off(starts.size(), false);
    for (int round = 0; round < 40; ++round) {
        const Box box = random_box(random, size);
        Vector<std::uint32_t> in_tree;
        tree.find_in(lamella::grown({box.min, box.max}, -1), [&](Point, std::uint32_t start) {
            in_tree.push_back(start);
            return true;
        });
        const std::vector<std::uint32_t> expected = expected_within(starts, taken_off, box);
        REQUIRE(sorted(in_tree) == expected);
        for (const std::uint32_t start : expected) {
            if (below(random, 3) == 0) {
                taken_off[start] = true;
                tree.take_off(start);
            }
        }
    }
}

TEST_CASE("testing many points at once gives the answers of testing them one by one", "[nesting]") {
    std::mt19937 random(GENERATE(5U, 6U));
    lamella::Worker worker;
    ManyInside many(worker);
    for (int round = 0; round < 400; ++round) {
        const int size = 2 + (1 << below(random, 25));
        const std::vector<Point> points = lamella::test::random_walk(random, size);
        const int bunch = 1 + below(random, size);  // most points lie within a part of the contour's height
        const int count = 1 + below(random, 200);
        many.clear();
        std::vector<std::uint32_t> expected;
        for (int i = 0; i < count; ++i) {
            const Point query{below(random, size + 2) - 1, below(random, below(random, 8) == 0 ? size + 2 : bunch) - 1};
            many.add(query, static_cast<std::uint32_t>(i));
            if (rings::strictly_around(points, query)) {
                expected.push_back(static_cast<std::uint32_t>(i));
            }
        }
        Vector<std::uint32_t> inside;
        many.test(points.data(), static_cast<std::uint32_t>(points.size()), inside);
        REQUIRE(sorted(inside) == expected);
    }
}

TEST_CASE("testing many points at once is exact at the limits of the grid", "[nesting]") {
    constexpr std::int32_t far = lamella::grid_limit;
    const std::vector<Point> points = {{-far, -far}, {far, -far}, {far, far}, {-far, far}};
    lamella::Worker worker;
    ManyInside many(worker);
    const Point queries[] = {{0, -far}, {0, 1 - far}, {0, far - 1}, {0, far},
                             {-far, 0}, {far, 0},     {far - 1, 0}, {1 - far, 0}};
    for (std::uint32_t i = 0; i < std::size(queries); ++i) {
        many.add(queries[i], i);
    }
    Vector<std::uint32_t> inside;
    many.test(points.data(), 4, inside);
    CHECK(sorted(inside) == std::vector<std::uint32_t>{1, 2, 6, 7});
}

TEST_CASE("all forms of the edge test agree", "[nesting]") {
    std::mt19937 random(9);
    const auto forms = lamella::supported(lamella::nesting::add_edges_forms());
    for (int round = 0; round < 20000; ++round) {
        const int size = 2 + below(random, 30);
        std::vector<Point> points = lamella::test::random_walk(random, size);
        for (int more = below(random, 5); more > 0; --more) {  // up to about 200; repeats do no harm
            const std::vector<Point> walk = lamella::test::random_walk(random, size);
            points.insert(points.end(), walk.begin(), walk.end());
        }
        const int away = round % 3 == 0 ? -100 : 0;  // also covers negative coordinates only
        for (Point& p : points) {
            p = {p.x + away, p.y + away};
        }
        const Point query{below(random, size) + away, below(random, size) + away};
        const auto count = static_cast<std::uint32_t>(points.size());
        const bool expected = rings::strictly_around(points, query);
        for (std::size_t form = 0; form < forms.size(); ++form) {
            CAPTURE(round, form);
            REQUIRE(strictly_inside(forms[form].kernel, points.data(), count, query) == expected);
        }
    }
}
