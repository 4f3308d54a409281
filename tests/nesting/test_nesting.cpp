// Orientation and nesting of one layer, compared with a brute-force oracle; and its parts: sorting by keys, points within
// contours.
#include <tuple>

#include <catch2/catch.hpp>

#include "engine/polygons.hpp"
#include "oracle/oracle.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/nesting/order.hpp"

using namespace lamella;
using namespace polygons;
using lamella::nesting::SortKey;

namespace {

using polygons::Ring;

constexpr std::int32_t far = grid_limit;

struct Contour {
    Ring points;
    bool closed = true;
};
using Layer = std::vector<Contour>;

/// What Nester::nest gets. It points into the layer.
std::vector<NestItem> items_of(const Layer& layer) {
    std::vector<NestItem> items;
    for (const auto& [points, closed] : layer) {
        NestItem item;
        item.points = points.data();
        item.count = static_cast<std::uint32_t>(points.size());
        item.closed = closed;
        if (closed) {
            item.start = static_cast<std::uint32_t>(std::min_element(points.begin(), points.end()) - points.begin());
            const rings::Int128 area = rings::twice_area(points);
            item.twice_area = {static_cast<std::uint64_t>(area), static_cast<std::int64_t>(area >> 64)};
            item.box = FlatBox::around(points);
        }
        items.push_back(item);
    }
    return items;
}

/// Parent, role, orientation, flags, and whether it is turned round.
using Answer = std::tuple<int, Role, int, unsigned, bool>;

std::vector<Answer> expected_of(const Layer& layer) {
    oracle::Layer nested;
    for (const auto& [points, closed] : layer) {
        oracle::Contour& own = nested.emplace_back();
        own.points = closed ? rings::from_smallest(points) : points;
        own.twice_area = closed ? rings::twice_area(own.points) : 0;
        own.orientation = (own.twice_area > 0) - (own.twice_area < 0);
        own.role = closed ? Role::flat : Role::open;
    }
    const oracle::Layer as_given = nested;
    oracle::find_parents(nested);
    oracle::decide_roles(nested);
    std::vector<Answer> answers;
    for (std::size_t i = 0; i < nested.size(); ++i) {
        const oracle::Contour& own = nested[i];
        answers.emplace_back(own.parent, own.role, own.orientation, own.flags, own.twice_area != as_given[i].twice_area);
    }
    return answers;
}

/// By a nester that has seen other layers before.
void check_against_oracle(const Layer& layer) {
    static Worker worker;
    static Nester nester(worker);
    std::vector<NestItem> items = items_of(layer);
    nester.nest(items);
    std::vector<Answer> answers;
    answers.reserve(items.size());
    for (const NestItem& item : items) {
        answers.emplace_back(item.parent, item.role, item.orientation, item.flags, item.reverse);
    }
    REQUIRE((answers == expected_of(layer)));
}

/// From any of its points on, either way round.
Ring turned(std::mt19937& random, Ring ring) {
    std::rotate(ring.begin(), ring.begin() + below(random, static_cast<int>(ring.size())), ring.end());
    return random() % 2 == 0 ? ring : reversed(ring);
}

/// Without points equal to the one before, the last to the first.
Ring distinct(Ring ring) {
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    while (ring.size() > 1 && ring.back() == ring.front()) {
        ring.pop_back();
    }
    return ring;
}

Ring random_walk(std::mt19937& random, int size) {
    Ring ring;
    while (ring.size() < 2) {
        ring = distinct(lattice_points(random, 1, 2 + random() % 40, size, 1)[0]);
    }
    return ring;
}

/// A few contours of mixed kinds (nested, touching, equal, crossing, flat, open) on a small grid, so that coordinates
/// often coincide. Some layers hold many contours.
Layer random_layer(std::mt19937& random) {
    Layer layer;
    const int size = 1 + (1 << below(random, 8));
    for (int left = below(random, 4) == 0 ? 20 + below(random, 60) : 1 + below(random, 8); left > 0; --left) {
        const int x = below(random, size);
        const int y = below(random, size);
        const int kind = below(random, 8);
        const Ring ring = kind < 2    ? random_walk(random, size)
                          : kind == 2 ? Ring{{x, y}, {x + 5, y}, {x + 9, y}}
                          : kind < 5  ? box(x, y, x + 1 + below(random, size), y + 1 + below(random, size))
                                      : distinct(round({x, y}, 2 + below(random, size), 3 + below(random, 60), 0));
        layer.push_back({turned(random, ring), kind != 1});
    }
    return layer;
}

/// Fills `low` to `high` with contours that nest and touch but do not cross: boxes, and L shapes whose boxes overlap
/// others.
void add_nested(Layer& layer, std::mt19937& random, Point low, Point high, int depth) {
    if (depth == 0 || high.x - low.x < 4 || high.y - low.y < 4) {
        return;
    }
    const int gap = below(random, 2);  // 0: touches the contour around it
    const Point a{low.x + gap, low.y + gap};
    const Point b{high.x - gap, high.y - gap};
    const Point mid{a.x + 1 + below(random, b.x - a.x - 1), a.y + 1 + below(random, b.y - a.y - 1)};
    const Ring corner = {a, {b.x, a.y}, {b.x, mid.y}, mid, {mid.x, b.y}, {a.x, b.y}};
    layer.push_back({turned(random, below(random, 3) == 0 ? corner : box(a.x, a.y, b.x, b.y))});
    add_nested(layer, random, a, mid, depth - 1);
    add_nested(layer, random, mid, b, depth - 1);
    add_nested(layer, random, {a.x, mid.y}, {mid.x, b.y}, depth - 1);
    add_nested(layer, random, {mid.x, a.y}, {b.x, mid.y}, depth - 1);
}

/// Keeps the first of equal contours, which only their numbers tell apart.
void drop_repeated(Layer& layer) {
    std::vector<Ring> known;
    std::erase_if(layer, [&](const Contour& contour) {
        known.push_back(rings::from_smallest(contour.points));
        return std::find(known.begin(), known.end() - 1, known.back()) != known.end() - 1;
    });
}

/// Four corners, so many times round.
Ring turns(std::int32_t reach, int count) {
    Ring ring;
    for (int i = 0; i < count; ++i) {
        ring.insert(ring.end(), {{-reach, -reach}, {reach, -reach}, {reach, reach}, {-reach, reach}});
    }
    return ring;
}

TEST_CASE("random layers agree with the oracle", "[nesting]") {
    std::mt19937 random(GENERATE(1U, 2U, 3U, 4U));
    for (int round = 0; round < 1500; ++round) {
        CAPTURE(round);
        check_against_oracle(random_layer(random));
    }
}

TEST_CASE("layers of many contours agree with the oracle", "[nesting]") {
    std::mt19937 random(GENERATE(11U, 12U, 13U));
    for (int round = 0; round < 20; ++round) {
        Layer layer;
        const int size = 100 << below(random, 12);
        add_nested(layer, random, {-size, -size}, {size, size}, 5);
        drop_repeated(layer);
        CAPTURE(round, size, layer.size());
        check_against_oracle(layer);
    }
    Layer concentric;
    Layer side_by_side;
    Layer crossing;
    for (int i = 0; i < 1500; ++i) {
        concentric.push_back({turned(random, round({0, 0}, 1000.0 + 100.0 * i, 8, 0))});
        side_by_side.push_back({round({3000 * (i % 39), 3000 * (i / 39)}, 1000.0 + i % 7, 8, 0)});
        const Point low{below(random, 300), below(random, 300)};
        const int width = i % 2 == 0 ? 500 : 1;
        crossing.push_back(
            {turned(random, box(low.x, low.y, low.x + width + below(random, 40), low.y + 1 + below(random, 60)))});
    }
    drop_repeated(crossing);
    for (const Layer& layer : {concentric, side_by_side, crossing}) {
        check_against_oracle(layer);
    }
}

TEST_CASE("nesting is exact up to the limits of the grid, and for areas beyond 64 bits", "[nesting]") {
    check_against_oracle({{{{-far, -far}, {far, far - 1}, {far, far}}},
                          {{{0, 0}, {2, 1}, {1, 1}}},  // these start on or beside the long edges
                          {{{-1, -1}, {2, 1}, {1, 1}}},
                          {{{far - 2, far - 2}, {far - 1, far - 2}, {far - 1, far - 1}}},
                          {box(-far, -far, far, far)}});
    // The third is larger in area than the contour around it.
    check_against_oracle({{turns(far, 5)}, {turns(far - 1, 3)}, {turns(far - 2, 4)}, {box(0, 0, 1, 1)}});
}

TEST_CASE("keys are sorted whatever their number and distribution", "[nesting]") {
    using Keys = Vector<SortKey>;
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
        std::sort(expected.begin(), expected.end(), lamella::nesting::before);
        StopPace pace;
        lamella::nesting::sort_keys(keys, spare, pace);
        CAPTURE(spread);
        REQUIRE(std::equal(keys.begin(), keys.end(), expected.begin(), expected.end(),
                           [](const SortKey& a, const SortKey& b) { return a.key == b.key && a.index == b.index; }));
    }
}

TEST_CASE("points within a contour are found by every form of the edge test, one by one and many at once", "[nesting]") {
    std::mt19937 random(9);
    const auto forms = supported(lamella::nesting::add_edges_forms());
    const auto sifting = supported(lamella::nesting::sift_edges_forms());
    for (int turn = 0; turn < 800; ++turn) {
        const int size = 2 + (turn % 2 == 0 ? below(random, 30) : 1 << below(random, 25));
        Ring ring = random_walk(random, size);
        for (int more = below(random, 5); more > 0; --more) {  // repeats do no harm
            const Ring walk = random_walk(random, size);
            ring.insert(ring.end(), walk.begin(), walk.end());
        }
        const auto count = static_cast<std::uint32_t>(ring.size());
        Ring queries;
        std::vector<std::uint32_t> expected;
        const int bunch = 1 + below(random, size);  // most points lie within a part of the contour's height
        for (std::uint32_t i = 0; i < 1 + random() % 200; ++i) {
            const int height = below(random, 8) == 0 ? size + 2 : bunch;
            const Point query{below(random, size + 2) - 1 - size / 2, below(random, height) - 1 - size / 2};
            queries.push_back(query);
            const bool inside = rings::strictly_around(ring, query);
            if (inside) {
                expected.push_back(i);
            }
            for (const auto& [needs, form] : forms) {
                REQUIRE(lamella::nesting::strictly_inside(form, ring.data(), count, query) == inside);
            }
        }
        for (const auto& [needs, form] : sifting) {
            Worker worker(nullptr, needs);
            lamella::nesting::ManyInside many(worker);
            for (std::uint32_t i = 0; i < queries.size(); ++i) {
                many.add(queries[i], i);
            }
            Vector<std::uint32_t> found;
            many.test(ring.data(), count, found);
            std::sort(found.begin(), found.end());
            REQUIRE(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
        }
    }
}

}  // namespace
