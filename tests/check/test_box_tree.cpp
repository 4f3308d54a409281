// The tree of boxes, and what numbers its items, against looking at everything.
#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "base/distribute.hpp"
#include "mesh/check/grid_mesh.hpp"
#include "slicing/grid/box_tree.hpp"

namespace lamella::check_test {

namespace {

bool overlap(const SpaceBox& a, const SpaceBox& b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y && a.low.z <= b.high.z &&
           b.low.z <= a.high.z;
}

/// Boxes of up to `size` a side, on a lattice, so that many touch.
std::vector<SpaceBox> drawn_boxes(std::size_t count, int size) {
    std::mt19937 random(static_cast<std::mt19937::result_type>(count));
    std::vector<SpaceBox> boxes(count);
    for (SpaceBox& box : boxes) {
        const auto drawn = [&](int numbers) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(numbers)); };
        box.low = {drawn(100) - 50, drawn(100) - 50, drawn(100) - 50};
        box.high = {box.low.x + drawn(size), box.low.y + drawn(size), box.low.z + drawn(size)};
    }
    return boxes;
}

using Tree = BoxTree<GridVertex>;

Tree tree_of(const std::vector<SpaceBox>& boxes, int threads) {
    Tree tree;
    tree.assign(
        boxes.size(), [&](std::size_t i) { return boxes[i]; }, Parallel({.threads = threads}));
    return tree;
}

}  // namespace

TEST_CASE("the tree finds the boxes that meet a box, and every pair that meets once", "[check]") {
    const std::size_t count = GENERATE(as<std::size_t>(), 0, 1, 7, 8, 9, 63, 64, 65, 700, 1500);
    const std::vector<SpaceBox> boxes = drawn_boxes(count, 15);
    const Tree tree = tree_of(boxes, 2);
    using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
    const auto meeting = [&](const std::vector<SpaceBox>& queries, bool later_only) {
        Pairs pairs;
        for (std::size_t i = 0; i < queries.size(); ++i) {
            for (std::size_t j = later_only ? i + 1 : 0; j < count; ++j) {
                if (overlap(queries[i], boxes[j])) {
                    pairs.push_back({i, j});
                }
            }
        }
        return pairs;
    };
    const auto sorted = [](Pairs pairs) {
        std::sort(pairs.begin(), pairs.end());
        return pairs;
    };
    const std::vector<SpaceBox> queries = drawn_boxes(50, 30);
    Pairs found;
    for (std::size_t i = 0; i < queries.size(); ++i) {
        tree.search(queries[i], ~std::size_t{0}, [&](std::size_t item) { found.push_back({i, item}); });
    }
    CHECK(sorted(found) == meeting(queries, false));
    found.clear();
    for (std::size_t group = 0; group < tree.groups(); ++group) {
        tree.search_pairs(group, ~std::size_t{0}, [&](std::size_t item, LaneBits bits) {
            each_lane(bits, [&](std::size_t lane) { found.push_back({tree.group_begin(group) + lane, item}); });
        });
    }
    CHECK(sorted(found) == meeting(boxes, true));
}

TEST_CASE("a search of the tree ends soon after its limit", "[check]") {
    const std::vector<SpaceBox> boxes(5000, SpaceBox{{0, 0, 0}, {1, 1, 1}});
    const Tree tree = tree_of(boxes, 1);
    std::size_t visits = 0;
    const std::size_t cost = tree.search(boxes[0], 1000, [&](std::size_t) { ++visits; });
    CHECK(cost >= 1000);
    CHECK(cost < 1000 + 2 * Tree::fan * Tree::visit_cost);
    CHECK(visits >= 8);
    CHECK(visits < 24);
}

TEST_CASE("Morton keys take the axes' bits by turns", "[check]") {
    MeshCheck mesh;
    mesh.grid_mm = 1;
    mesh.box.max_mm.fill(2'000'000);  // 21 bits: every bit counts
    const MortonOrder order(mesh);
    std::mt19937 random(3);
    for (int round = 0; round < 200; ++round) {
        const auto drawn = [&] { return static_cast<std::int32_t>(random() % 1'000'001) * 2; };
        const GridVertex v{drawn(), drawn(), drawn()};
        std::uint64_t wanted = 0;
        for (int bit = 20; bit >= 0; --bit) {
            for (const std::int32_t coordinate : {v.x, v.y, v.z}) {
                wanted = wanted << 1 | static_cast<std::uint64_t>(coordinate >> bit & 1);
            }
        }
        CHECK(order.key(v) == wanted);
    }
}

TEST_CASE("indices come in order from any number of threads", "[check]") {
    for (const int threads : {1, 4}) {
        for (const std::size_t count : std::array<std::size_t, 4>{0, 1, 16384, 100'000}) {
            const auto test = [](std::size_t i) { return i % 7 == 3 || i % 16384 < 2; };
            const Array<std::uint32_t> found = indices_where(count, Parallel({.threads = threads}), nullptr, test);
            std::vector<std::uint32_t> wanted;
            for (std::uint32_t i = 0; i < count; ++i) {
                if (test(i)) {
                    wanted.push_back(i);
                }
            }
            CHECK(std::equal(found.begin(), found.end(), wanted.begin(), wanted.end()));
        }
    }
}

}  // namespace lamella::check_test
