// Shells, their orientations and nesting.
#include "check/findings.hpp"

namespace lamella::check_test {

using shapes::box;
using shapes::flipped;
using shapes::joined;
using shapes::moved;

namespace {

std::vector<int> depths(const MeshCheck& check) {
    std::vector<int> found;
    for (const MeshShell& shell : check.shells) {
        found.push_back(shell.depth);
    }
    return found;
}

}  // namespace

TEST_CASE("a cavity has the opposite orientation, a solid in a solid the same", "[check]") {
    const Soup outer = box({0, 0, 0}, {9, 9, 9});
    const Soup inner = box({3, 3, 3}, {6, 6, 6});
    const MeshCheck cavity = findings_of(joined({outer, flipped(inner)}));
    CHECK(cavity.clean());
    REQUIRE(cavity.shells.size() == 2);
    CHECK(cavity.shells[0].orientation == 1);
    CHECK(cavity.shells[0].volume_mm3 == 729);
    CHECK(cavity.shells[0].parent == -1);
    CHECK(cavity.shells[1].orientation == -1);
    CHECK(cavity.shells[1].volume_mm3 == -27);
    CHECK(cavity.shells[1].depth == 1);
    CHECK(cavity.shells[1].parent == 0);

    const MeshCheck insert = findings_of(joined({inner, outer}));
    CHECK(counts(insert) == Counts{{"wrong_sense_shells", 1}});
    CHECK(depths(insert) == std::vector{0, 1});
    CHECK(first(insert, Fault::misoriented_shell).points_mm[0] == Xyz{3, 3, 3});
    CHECK(first(insert, Fault::misoriented_shell).measure == 27);

    CHECK(counts(findings_of(flipped(outer))) == Counts{{"wrong_sense_shells", 1}});
}

TEST_CASE("shells nested in one another have ascending depths", "[check]") {
    Soup soup;
    for (int i = 0; i < 12; ++i) {
        const double low = i;
        const Soup cube = box({low, low, low}, {40 - low, 40 - low, 40 - low});
        soup = joined({i % 2 == 0 ? cube : flipped(cube), soup, box({100.0 + 3 * i, 0, 0}, {101.0 + 3 * i, 1, 1})});
    }
    const MeshCheck check = findings_of(soup);
    CHECK(check.clean());
    REQUIRE(check.shells.size() == 24);
    for (int i = 0; i < 12; ++i) {
        CHECK(check.shells[static_cast<std::size_t>(i)].depth == i);
        CHECK(check.shells[static_cast<std::size_t>(i)].parent == i - 1);
        CHECK(check.shells[static_cast<std::size_t>(i) + 12].depth == 0);
    }
}

TEST_CASE("a shell that touches the one around it is still within", "[check]") {
    // Its first vertices all lie on the outer one's face x = 0; off that face it is found.
    const MeshCheck check = findings_of(joined({box({0, 0, 0}, {9, 9, 9}), flipped(box({0, 3, 3}, {4, 5, 5}))}));
    REQUIRE(check.shells.size() == 2);
    CHECK(depths(check) == std::vector{0, 1});
    CHECK(check.of(Fault::misoriented_shell).count == 0);
    CHECK(check.of(Fault::overlapping_faces).count > 0);
}

TEST_CASE("a shell beside another, touching it, is not within", "[check]") {
    const MeshCheck check = findings_of(joined({box({0, 0, 0}, {9, 9, 9}), box({9, 3, 3}, {12, 5, 5})}));
    REQUIRE(check.shells.size() == 2);
    CHECK(depths(check) == std::vector{0, 0});
}

TEST_CASE("rays through edges and vertices of the shell around count once", "[check]") {
    // The inner corners stand straight below vertices, edges and diagonals of the outer top, and beside vertical faces.
    const Soup outer = shapes::octasphere({0, 0, 0}, 8, 1);
    for (const double x : {-1.0, 0.0, 1.0}) {
        for (const double y : {-1.0, 0.0, 1.0}) {
            const MeshCheck inside = findings_of(joined({outer, flipped(box({x, y, -1}, {x + 1, y + 1, 0}))}));
            CHECK(inside.shells.at(1).depth == 1);
            const MeshCheck below = findings_of(joined({outer, box({x, y, -20}, {x + 1, y + 1, -19})}));
            CHECK(below.shells.at(0).depth + below.shells.at(1).depth == 0);
        }
    }
}

TEST_CASE("solids that interpenetrate have no wrong orientation, wherever rays start", "[check]") {
    // The spike's first vertex lies within the box, its last one outside; so do the corner's and the edge's.
    const Soup cube = box({0, 0, 0}, {9, 9, 9});
    for (const Xyz& low : {Xyz{3, 3, 3}, Xyz{3, 3, 0}, Xyz{3, 0, 0}}) {
        const Soup other = box(low, {12, low[1] + 4, low[2] + 4});
        const MeshCheck check = findings_of(joined({cube, other}));
        CHECK(check.of(Fault::crossing_faces).count + check.of(Fault::touching_faces).count > 0);
        CHECK(check.of(Fault::misoriented_shell).count == 0);
        CHECK(findings_of(joined({cube, flipped(moved(other, {-12, 0, 0}))})).of(Fault::misoriented_shell).count == 1);
    }
}

TEST_CASE("a cavity within two solids that interpenetrate has no wrong orientation", "[check]") {
    const Soup solids = joined({box({0, 0, 0}, {9, 9, 9}), box({2, 2, 2}, {20, 8, 8})});
    const MeshCheck check = findings_of(joined({solids, flipped(box({4, 4, 4}, {5, 5, 5}))}));
    CHECK(depths(check) == std::vector{0, 1, 2});
    CHECK(check.of(Fault::misoriented_shell).count == 0);
    // Apart from these it has one.
    const Soup elsewhere = joined({box({0, 0, 40}, {9, 9, 49}), box({3, 3, 43}, {6, 6, 46})});
    CHECK(findings_of(joined({solids, elsewhere})).of(Fault::misoriented_shell).count == 1);
}

TEST_CASE("only closed shells are around others", "[check]") {
    const MeshCheck check = findings_of(joined({without(box({0, 0, 0}, {9, 9, 9}), 3, 1), box({3, 3, 3}, {6, 6, 6})}));
    CHECK(depths(check) == std::vector{0, 0});
    CHECK_FALSE(check.shells[0].closed);
    CHECK(check.shells[0].volume_mm3 == 0);
    CHECK(check.of(Fault::misoriented_shell).count == 0);
    const MeshCheck loose =
        findings_of(joined({box({0, 0, 0}, {9, 9, 9}), shapes::triangle({3, 3, 3}, {4, 3, 3}, {3, 4, 3})}));
    CHECK(depths(loose) == std::vector{0, 1});
}

TEST_CASE("volumes are exact at the ends of the grid", "[check]") {
    const MeshCheck check =
        findings_of(box({-1023, -1023, -1023}, {1023, 1023, 1023}), {.frame = {.grid_mm = default_grid_mm}});
    CHECK(check.clean());
    CHECK(check.shells.at(0).volume_mm3 == 2046.0 * 2046.0 * 2046.0);
}

}  // namespace lamella::check_test
