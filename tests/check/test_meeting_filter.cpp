// The filter before the exact test of two triangles, against that test.
#include <array>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "mesh/check/meeting.hpp"

namespace lamella::check_test {

namespace {

struct GridTriangle {
    std::array<std::uint32_t, 3> ids;
    std::array<GridVertex, 3> vertices;

    ExactFace exact() const { return {ids, vertices}; }
    RealFace real() const { return {ids, vertices}; }
};

/// Triangles with area on the vertices of a lattice of 5 x 5 x 5, `spread` grid units apart, each moved by up to `jitter`.
std::vector<GridTriangle> drawn_triangles(std::size_t count, std::int32_t spread, std::int32_t jitter) {
    constexpr std::uint32_t side = 5;
    std::mt19937 random(static_cast<std::mt19937::result_type>(spread + jitter));
    const auto moved = [&](std::uint32_t at) {
        const std::int32_t units =
            jitter == 0 ? 0 : static_cast<std::int32_t>(random() % (2 * static_cast<unsigned>(jitter)));
        return 2 * ((static_cast<std::int32_t>(at) - 2) * (spread / 2) + (units - jitter) / 2);
    };
    std::vector<GridVertex> vertices;
    for (std::uint32_t id = 0; id < side * side * side; ++id) {
        vertices.push_back({moved(id % side), moved(id / side % side), moved(id / side / side)});
    }
    std::vector<GridTriangle> triangles;
    while (triangles.size() < count) {
        GridTriangle drawn{};
        for (std::size_t i = 0; i < 3; ++i) {
            drawn.ids[i] = static_cast<std::uint32_t>(random() % vertices.size());
            drawn.vertices[i] = vertices[drawn.ids[i]];
        }
        if (drawn.exact().has_area()) {
            triangles.push_back(drawn);
        }
    }
    return triangles;
}

}  // namespace

TEST_CASE("the filter drops no pair of triangles that meet, and most that do not", "[check]") {
    const auto [spread, jitter] = GENERATE(std::pair{2, 0}, std::pair{400'000'000, 0}, std::pair{400'000'000, 3},
                                           std::pair{1000, 400}, std::pair{300'000'000, 90'000'000});
    const std::vector<GridTriangle> triangles = drawn_triangles(400, spread, jitter);
    std::size_t apart = 0;
    std::size_t kept = 0;
    for (const GridTriangle& face : triangles) {
        for (const GridTriangle& other : triangles) {
            const bool meets = meet(face.exact(), other.exact()) != Meeting::none;
            const bool is_kept = !are_apart(face.real(), other.real());
            REQUIRE((is_kept || !meets));
            apart += meets ? 0 : 1;
            kept += is_kept && !meets ? 1 : 0;
        }
    }
    CHECK(apart > 1000);
    CHECK(kept < apart * 3 / 4);
}

}  // namespace lamella::check_test
