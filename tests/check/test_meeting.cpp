// How two triangles meet, against another way to tell: the corners of what they have in common; and that check() finds all
// that do.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "check/findings.hpp"
#include "mesh/check/meeting.hpp"

namespace lamella::check_test {

namespace {

/// True if a point has weights above 0 at exactly the chosen corners in both triangles, and no other point has: it is a
/// corner of what they have in common. Bits 0 to 2 choose corners of `a`, bits 3 to 5 of `b`. By elimination, in multiples
/// of `unit`.
bool is_common_corner(const ExactFace& a, const ExactFace& b, unsigned chosen, double unit) {
    constexpr double least = 1e-9;
    std::array<std::array<double, 7>, 5> rows{};  // x, y, z and the sums of weights; last what they come to
    rows[3][6] = rows[4][6] = 1;
    for (std::size_t i = 0; i < 6; ++i) {
        const GridVector& at = i < 3 ? a.corners[i] : b.corners[i - 3];
        const double sign = i < 3 ? 1 / unit : -1 / unit;
        rows[0][i] = sign * static_cast<double>(at.x);
        rows[1][i] = sign * static_cast<double>(at.y);
        rows[2][i] = sign * static_cast<double>(at.z);
        rows[i < 3 ? 3 : 4][i] = 1;
    }
    auto row = rows.begin();
    for (std::size_t i = 0; i < 6; ++i) {
        if ((chosen >> i & 1) == 0) {
            continue;
        }
        const auto pivot = std::max_element(
            row, rows.end(), [i](const auto& one, const auto& other) { return std::abs(one[i]) < std::abs(other[i]); });
        if (pivot == rows.end() || std::abs((*pivot)[i]) < least) {
            return false;  // other weights give the same point
        }
        std::swap(*row, *pivot);
        for (auto other = rows.begin(); other != rows.end(); ++other) {
            const double times = other == row ? 1 - 1 / (*row)[i] : (*other)[i] / (*row)[i];
            std::transform(other->begin(), other->end(), row->begin(), other->begin(),
                           [times](double own, double taken) { return own - times * taken; });
        }
        ++row;
    }
    return std::all_of(rows.begin(), row, [](const auto& done) { return done[6] > least; }) &&
           std::all_of(row, rows.end(), [](const auto& left) { return std::abs(left[6]) < least; });
}

/// By the corners of what the triangles have in common. Where together they weigh all six corners, so does their middle: it
/// lies inside both.
Meeting expected(const ExactFace& a, const ExactFace& b, double unit) {
    unsigned shared = 0;
    for (std::size_t k = 0; k < 9; ++k) {
        shared |= a.ids[k / 3] == b.ids[k % 3] ? 1U << (k / 3) | 8U << (k % 3) : 0;
    }
    unsigned weighed = 0;
    bool touch = false;
    for (unsigned chosen = 1; chosen < 64; ++chosen) {
        if (is_common_corner(a, b, chosen, unit)) {
            weighed |= chosen;
            touch = touch || (chosen & ~shared) != 0;
        }
    }
    if (shared == 63 || !touch) {
        return Meeting::none;
    }
    const bool one_plane =
        std::all_of(b.corners.begin(), b.corners.end(), [&](const GridVector& p) { return a.height(p) == 0; });
    return weighed != 63 ? Meeting::touch : one_plane ? Meeting::overlap : Meeting::cross;
}

struct GridTriangle {
    std::array<std::uint32_t, 3> ids;
    std::array<GridVertex, 3> vertices;

    ExactFace exact() const { return {ids, vertices}; }
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

TEST_CASE("triangles meet where both have a point, which separating axes find in either order", "[check]") {
    const Lattice lattice = GENERATE(values<Lattice>({{3, 3, 2},
                                                      {4, 4, 2},
                                                      {6, 2, 2},
                                                      {5, 1, 2},
                                                      {9, 9, 2},
                                                      {5, 5, 400'000'000},
                                                      {5, 1, 400'000'000},
                                                      {5, 5, 1000, 400},
                                                      {5, 5, 400'000'000, 3},
                                                      {5, 5, 300'000'000, 90'000'000}}));
    CAPTURE(lattice.side, lattice.depth, lattice.spread, lattice.jitter);
    std::array<std::size_t, 4> seen{};
    const std::vector<GridTriangle> triangles = drawn_triangles(150, lattice);
    for (const GridTriangle& face : triangles) {
        for (const GridTriangle& other : triangles) {
            const Meeting meeting = meet(face.exact(), other.exact());
            REQUIRE(meeting == meet(other.exact(), face.exact()));
            if (lattice.jitter == 0) {  // doubles do not tell what is nearly a point from what is one
                REQUIRE(meeting == expected(face.exact(), other.exact(), lattice.spread / 2));
            }
            ++seen[static_cast<std::size_t>(meeting)];
        }
    }
    const auto [none, touch, cross, overlap] = seen;
    CHECK((cross > 0) == (lattice.depth > 1));
    CHECK((lattice.jitter > 0 || touch > 0));
    CHECK((lattice.jitter > 0 || lattice.side == 9 || overlap > 0));
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

/// A cone without its base: `faces` around the apex, which go round it `rounds` times, up and down by turns.
Soup cone(int faces, int rounds) {
    const auto rim = [&](int i) -> Xyz {
        const double angle = 2 * std::numbers::pi * rounds * (i % faces) / faces;
        return {std::round(500 * std::cos(angle)), std::round(500 * std::sin(angle)), 50.0 * (i % faces)};
    };
    Soup soup;
    for (int i = 0; i < faces; ++i) {
        soup = shapes::joined({soup, shapes::triangle({0, 0, 0}, rim(i), rim(i + 1))});
    }
    return soup;
}

/// A ball on a lattice, its corners moved by up to `by`, without some faces where `open`: flat, doubled and open places.
Soup rough_ball(std::uint64_t seed, double by, bool open) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> jitter(-by, by);
    std::map<Xyz, Xyz> moved;
    Soup soup = shapes::octasphere({0, 0, 0}, 10, 2);
    for (std::size_t i = 0; i < soup.size(); i += 3) {
        const Xyz at{soup[i], soup[i + 1], soup[i + 2]};
        const auto there = [&](double from) { return std::round(from + jitter(random)); };
        const auto place = moved.try_emplace(at, Xyz{there(at[0]), there(at[1]), there(at[2])}).first;
        std::copy(place->second.begin(), place->second.end(), soup.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return open ? without(soup, 3, 2) : soup;
}

/// How often two faces of whole mm meet in each way, by testing all pairs; faces on the same vertices are tested once.
std::array<std::uint64_t, 4> meetings_in(const Soup& soup) {
    std::map<GridVertex, std::uint32_t> numbers;
    std::set<std::set<std::uint32_t>> known;
    std::vector<ExactFace> faces;
    for (std::size_t at = 0; at < soup.size(); at += 9) {
        std::array<GridVertex, 3> corners;
        std::array<std::uint32_t, 3> ids{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto grid = [&](std::size_t axis) { return 2 * static_cast<std::int32_t>(soup[at + 3 * i + axis]); };
            corners[i] = {grid(0), grid(1), grid(2)};
            ids[i] = numbers.try_emplace(corners[i], static_cast<std::uint32_t>(numbers.size())).first->second;
        }
        const bool is_new = known.insert({ids.begin(), ids.end()}).second;
        if (const ExactFace face(ids, corners); is_new && face.has_area()) {
            faces.push_back(face);
        }
    }
    std::array<std::uint64_t, 4> counts{};
    for (std::size_t i = 0; i < faces.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            ++counts[static_cast<std::size_t>(meet(faces[i], faces[j]))];
        }
    }
    return counts;
}

TEST_CASE("every pair of faces that meet is found, whatever the faces around their vertices do", "[check]") {
    std::vector<Soup> soups = {cone(7, 1), cone(7, 2), cone(15, 4)};
    for (std::uint64_t seed = 0; seed < 24; ++seed) {  // small and large triangles, coincidences of every kind
        soups.push_back(rough_ball(seed, 0.4 * static_cast<double>(seed % 8), seed % 3 == 0));
        soups.push_back(shapes::joined({shapes::random_soup(seed, 60, 40), shapes::random_soup(seed + 100, 60, 3),
                                        shapes::moved(shapes::random_soup(seed + 200, 60, 6), {15, 15, 15})}));
    }
    std::array<std::uint64_t, 4> seen{};
    for (const Soup& soup : soups) {
        const auto [none, touch, cross, overlap] = meetings_in(soup);
        const MeshCheck check = findings_of(soup);
        INFO("soup " << &soup - soups.data());
        CHECK(check.of(Fault::touching_faces).count == touch);
        CHECK(check.of(Fault::crossing_faces).count == cross);
        CHECK(check.of(Fault::overlapping_faces).count == overlap);
        seen = {none, seen[1] + touch, seen[2] + cross, seen[3] + overlap};
    }
    CHECK((seen[1] > 100 && seen[2] > 1000 && seen[3] > 10));
}

}  // namespace
}  // namespace lamella::check_test
