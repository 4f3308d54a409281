// How two triangles meet, against another way to tell: separating axes; and that check() finds all that do.
#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <vector>

#include "check/findings.hpp"
#include "mesh/check/meeting.hpp"

namespace lamella::check_test {

namespace {

using Points = std::vector<GridVector>;

/// Whether some axis parts two convex sets: on every axis that can, the differences a - b lie on both sides of 0 or on one.
struct Parting {
    bool apart = false;          ///< no point in common
    bool insides_apart = false;  ///< no point inside both, where they lie in different planes
};

/// Triangles, which may have no area.
Parting parting(const Points& a, const Points& b) {
    std::vector<GridVector> along;  // sides and normals; axes are normal to two of them
    for (const Points* p : {&a, &b}) {
        const GridVector sides[] = {(*p)[1] - (*p)[0], (*p)[2] - (*p)[1], (*p)[0] - (*p)[2]};
        along.insert(along.end(), std::begin(sides), std::end(sides));
        along.push_back(cross(sides[0], sides[1]));
    }
    Parting result;
    for (std::size_t i = 0; i < along.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (i % 4 == 3 && j % 4 == 3) {
                continue;  // two normals, whose product is too large and parts nothing that others do not
            }
            const GridVector axis = cross(along[i], along[j]);
            std::array<Int128, 9> differences{};
            for (std::size_t k = 0; k < differences.size(); ++k) {
                differences[k] = dot(axis, a[k / 3] - b[k % 3]);
            }
            const auto [low, high] = std::minmax_element(differences.begin(), differences.end());
            const bool says_nothing = *low == 0 && *high == 0;  // no axis, or both in one plane
            result.apart = result.apart || *low > 0 || *high < 0;
            result.insides_apart = result.insides_apart || (!says_nothing && (*low >= 0 || *high <= 0));
        }
    }
    return result;
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
    return !parting(side, angle).apart;
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
    const Parting parted = parting(corners_of(a), corners_of(b));
    if (shared == 3) {
        return Meeting::none;
    }
    if (!parted.insides_apart) {
        return one_plane ? Meeting::overlap : Meeting::cross;
    }
    const bool touch = shared == 0 ? !parted.apart : shared == 1 && more_than_vertex(a, i, b, j);
    return touch ? Meeting::touch : Meeting::none;
}

struct GridTriangle {
    std::array<std::uint32_t, 3> ids;
    std::array<GridVertex, 3> vertices;

    ExactFace exact() const { return {ids, vertices}; }
    RealFace real() const { return {ids, vertices}; }
};

struct Lattice {
    std::uint32_t side, depth;  ///< vertices along x and y, and along z
    std::int32_t spread;        ///< grid units between them
    std::int32_t jitter = 0;    ///< by which each is moved at most
};

/// Triangles with area on vertices of a lattice.
std::vector<GridTriangle> drawn_triangles(std::size_t count, const Lattice& on) {
    std::mt19937 random(static_cast<std::mt19937::result_type>(on.spread + on.jitter) + on.side);
    const auto moved = [&](std::uint32_t at, std::uint32_t side) {
        const std::int32_t units =
            on.jitter == 0 ? 0 : static_cast<std::int32_t>(random() % (2 * static_cast<unsigned>(on.jitter)));
        return 2 * ((static_cast<std::int32_t>(at) - static_cast<std::int32_t>(side / 2)) * (on.spread / 2) +
                    (units - on.jitter) / 2);
    };
    std::vector<GridVertex> vertices(on.side * on.side * on.depth);
    for (std::uint32_t id = 0; id < vertices.size(); ++id) {
        vertices[id] = {moved(id % on.side, on.side), moved(id / on.side % on.side, on.side),
                        moved(id / on.side / on.side, on.depth)};
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

TEST_CASE("triangles meet exactly where no separating axis exists, and the filter drops none that meet", "[check]") {
    const Lattice lattice = GENERATE(values<Lattice>({{3, 3, 2},
                                                      {4, 4, 2},
                                                      {6, 2, 2},
                                                      {5, 1, 2},
                                                      {9, 9, 2},
                                                      {5, 5, 1000, 400},
                                                      {5, 5, 400'000'000},
                                                      {5, 5, 400'000'000, 3},
                                                      {5, 5, 300'000'000, 90'000'000}}));
    CAPTURE(lattice.side, lattice.depth, lattice.spread, lattice.jitter);
    const std::vector<GridTriangle> triangles = drawn_triangles(300, lattice);
    std::array<std::size_t, 4> seen{};
    std::size_t kept = 0;
    for (const GridTriangle& face : triangles) {
        for (const GridTriangle& other : triangles) {
            const Meeting meeting = meet(face.exact(), other.exact());
            const bool is_kept = !are_apart(face.real(), other.real());
            if (lattice.spread < 1000) {  // the axes of larger ones do not fit 64 bits
                REQUIRE(meeting == expected(face.exact(), other.exact()));
            }
            REQUIRE((is_kept || meeting == Meeting::none));
            ++seen[static_cast<std::size_t>(meeting)];
            kept += is_kept && meeting == Meeting::none ? 1 : 0;
        }
    }
    const auto [none, touch, cross, overlap] = seen;
    CHECK((lattice.spread < 1000 || kept < none * 3 / 4));
    CHECK((cross > 0) == (lattice.depth > 1));
    CHECK((lattice.jitter > 0 || (touch > 0 && overlap > 0)));
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

TEST_CASE("every pair of faces that meet is found", "[check]") {
    // Small and large triangles, coincidences of every kind.
    const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 5)));
    const Soup soup = shapes::joined({shapes::random_soup(seed, 60, 40), shapes::random_soup(seed + 100, 60, 3),
                                      shapes::moved(shapes::random_soup(seed + 200, 100, 6), {15, 15, 15})});
    std::vector<ExactFace> faces;
    std::set<std::set<std::uint32_t>> known;  // faces on the same vertices are tested once
    for (std::size_t at = 0; at < soup.size(); at += 9) {
        std::array<GridVertex, 3> corners;
        std::array<std::uint32_t, 3> ids{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto grid = [&](std::size_t axis) { return 2 * static_cast<std::int32_t>(soup[at + 3 * i + axis]); };
            corners[i] = {grid(0), grid(1), grid(2)};
            ids[i] = static_cast<std::uint32_t>(corners[i].x + 1000 * (corners[i].y + 1000 * corners[i].z));
        }
        const bool is_new = known.insert({ids.begin(), ids.end()}).second;
        if (const ExactFace face(ids, corners); is_new && face.has_area()) {
            faces.push_back(face);
        }
    }
    std::array<std::uint64_t, 4> expected{};
    for (std::size_t i = 0; i < faces.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            ++expected[static_cast<std::size_t>(meet(faces[i], faces[j]))];
        }
    }
    const auto [none, touch, cross, overlap] = expected;
    CHECK((touch > 10 && cross > 100 && overlap > 0));
    const MeshCheck check = findings_of(soup);
    CHECK(check.of(Fault::touching_faces).count == touch);
    CHECK(check.of(Fault::crossing_faces).count == cross);
    CHECK(check.of(Fault::overlapping_faces).count == overlap);
}

}  // namespace lamella::check_test
