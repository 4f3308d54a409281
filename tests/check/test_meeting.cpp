// How two triangles meet, against another way to tell: separating axes.
#include "mesh/check/meeting.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace lamella::check_test {

namespace {

using Points = std::vector<GridVector>;

/// Where the differences a - b lie along every axis that can part two convex sets: on both sides of 0 or on one.
struct Parting {
    bool apart = false;          ///< no point in common
    bool insides_apart = false;  ///< no point inside both, where they lie in different planes
};

Parting parting(const Points& a, const Points& b, const std::vector<GridVector>& axes) {
    Parting result;
    for (const GridVector& axis : axes) {
        if (axis == GridVector{}) {
            continue;
        }
        Int128 low = 0;
        Int128 high = 0;
        bool first = true;
        for (const GridVector& p : a) {
            for (const GridVector& q : b) {
                const Int128 at = dot(axis, p - q);
                low = first ? at : std::min(low, at);
                high = first ? at : std::max(high, at);
                first = false;
            }
        }
        const bool all_zero = low == 0 && high == 0;  // both in one plane: says nothing
        result.apart = result.apart || low > 0 || high < 0;
        result.insides_apart = result.insides_apart || (!all_zero && (low >= 0 || high <= 0));
    }
    return result;
}

std::vector<GridVector> axes_of(const Points& a, const Points& b) {
    const auto sides = [](const Points& p) { return Points{p[1] - p[0], p[2] - p[1], p[0] - p[2]}; };
    const GridVector normal_a = cross(sides(a)[0], sides(a)[1]);
    const GridVector normal_b = cross(sides(b)[0], sides(b)[1]);
    std::vector<GridVector> axes = {normal_a, normal_b};
    for (const GridVector& side : sides(a)) {
        axes.push_back(cross(normal_a, side));
        axes.push_back(cross(normal_b, side));
        for (const GridVector& other : sides(b)) {
            axes.push_back(cross(side, other));
        }
    }
    for (const GridVector& side : sides(b)) {
        axes.push_back(cross(normal_a, side));
        axes.push_back(cross(normal_b, side));
    }
    return axes;
}

Points corners_of(const ExactFace& face) {
    return {face.corners.begin(), face.corners.end()};
}

/// Of triangles that share the vertex at corner i of one and j of the other: whether they have more than it in common, which
/// is to say that the far side of one meets the angle of the other.
bool more_than_vertex(const ExactFace& a, std::size_t i, const ExactFace& b, std::size_t j) {
    constexpr std::int64_t far = 10'000;
    const Points side = {a.corners[(i + 1) % 3], a.corners[(i + 2) % 3], a.corners[(i + 2) % 3]};
    Points angle = {b.corners[j]};
    for (const std::size_t k : {(j + 1) % 3, (j + 2) % 3}) {
        const GridVector out = b.corners[k] - b.corners[j];
        angle.push_back({b.corners[j].x + far * out.x, b.corners[j].y + far * out.y, b.corners[j].z + far * out.z});
    }
    return !parting(side, angle, axes_of(side, angle)).apart;
}

Meeting expected(const ExactFace& a, const ExactFace& b) {
    int shared = 0;
    std::size_t i = 0;
    std::size_t j = 0;
    for (std::size_t k = 0; k < 9; ++k) {
        if (a.corners[k / 3] == b.corners[k % 3]) {
            ++shared;
            i = k / 3;
            j = k % 3;
        }
    }
    const bool one_plane =
        std::all_of(b.corners.begin(), b.corners.end(), [&](const GridVector& p) { return a.height(p) == 0; });
    const Points p = corners_of(a);
    const Points q = corners_of(b);
    const Parting parted = parting(p, q, axes_of(p, q));
    if (shared == 3) {
        return Meeting::none;
    }
    if (!parted.insides_apart) {
        return one_plane ? Meeting::overlap : Meeting::cross;
    }
    const bool touch = shared == 0 ? !parted.apart : shared == 1 && more_than_vertex(a, i, b, j);
    return touch ? Meeting::touch : Meeting::none;
}

class RandomFaces {
public:
    RandomFaces(std::uint64_t seed, std::int32_t range, std::int32_t depth) : random_(seed), range_(range), depth_(depth) {}

    ExactFace next() {
        for (;;) {
            const std::array<GridVertex, 3> corners = {vertex(), vertex(), vertex()};
            const ExactFace face({id(corners[0]), id(corners[1]), id(corners[2])}, corners);
            if (face.has_area()) {
                return face;
            }
        }
    }

private:
    std::int32_t below(std::int32_t count) {
        return static_cast<std::int32_t>(random_() % static_cast<std::uint64_t>(count));
    }
    GridVertex vertex() { return {2 * below(range_), 2 * below(range_), 2 * below(depth_)}; }
    static std::uint32_t id(const GridVertex& v) { return static_cast<std::uint32_t>(v.x + 100 * v.y + 10'000 * v.z); }

    std::mt19937_64 random_;
    std::int32_t range_;
    std::int32_t depth_;
};

}  // namespace

TEST_CASE("triangles meet exactly where no separating axis exists", "[check]") {
    const auto [range, depth] =
        GENERATE(std::pair{3, 3}, std::pair{4, 4}, std::pair{6, 2}, std::pair{5, 1}, std::pair{9, 9});
    RandomFaces faces(static_cast<std::uint64_t>(range * 10 + depth), range, depth);
    std::array<int, 4> seen{};
    for (int i = 0; i < 20'000; ++i) {
        const ExactFace a = faces.next();
        const ExactFace b = faces.next();
        const Meeting meeting = meet(a, b);
        ++seen[static_cast<std::size_t>(meeting)];
        if (meeting != expected(a, b) || meeting != meet(b, a)) {
            CAPTURE(i, static_cast<int>(meeting), static_cast<int>(expected(a, b)), static_cast<int>(meet(b, a)));
            FAIL("not the same");
        }
    }
    CHECK(seen[static_cast<std::size_t>(Meeting::none)] > 0);
    CHECK(seen[static_cast<std::size_t>(Meeting::touch)] > 0);
    CHECK((seen[static_cast<std::size_t>(Meeting::cross)] > 0) == (depth > 1));
    CHECK(seen[static_cast<std::size_t>(Meeting::overlap)] > 0);
}

TEST_CASE("the largest triangles of the grid are distinguished by one unit", "[check]") {
    constexpr std::int32_t far = grid_limit;
    const std::array<GridVertex, 3> floor = {GridVertex{-far, -far, -far}, {far, -far, -far}, {far, far, far}};
    const ExactFace face({0, 1, 2}, floor);
    // The plane is y = z: a needle through it just inside and just outside its edge y = x at height 0.
    const auto needle = [](std::int32_t x) {
        return std::array<GridVertex, 3>{GridVertex{x, -2, 2}, {x, 2, -2}, {x + (x < 0 ? -far : far), 0, 0}};
    };
    CHECK(meet(face, ExactFace({3, 4, 5}, needle(-2))) == Meeting::none);
    CHECK(meet(face, ExactFace({3, 4, 5}, needle(0))) == Meeting::cross);
    CHECK(contains(face, half(GridVertex{2, 2, 2})));
    CHECK_FALSE(contains(face, half(GridVertex{0, 2, 2})));
    CHECK_FALSE(contains(face, half(GridVertex{2, 0, 2})));
}

}  // namespace lamella::check_test
