// How two triangles meet, against another way to tell: separating axes.
#include "mesh/check/meeting.hpp"

#include <algorithm>
#include <array>
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

/// True if triangles that share the vertex at corner i of one and j of the other have more than it in common, which is to
/// say that the far side of one meets the angle of the other.
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

struct GridTriangle {
    std::array<std::uint32_t, 3> ids;
    std::array<GridVertex, 3> vertices;

    ExactFace exact() const { return {ids, vertices}; }
    RealFace real() const { return {ids, vertices}; }
};

/// For the filter before the exact test: triangles with area on the vertices of a lattice of 5 x 5 x 5, `spread` grid units
/// apart, each moved by up to `jitter`.
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
