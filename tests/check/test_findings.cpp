// Small meshes, and all that is found in each. Text of one: the kinds of faults with their counts and the first place of
// each (points, triangles by #, the number of parts by x, a measure, whether a loop is closed), then the shells by their
// volumes. Shells turned by where they lie.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "check/findings.hpp"

namespace lamella::check_test {

using namespace shapes;

namespace {

void add_place(std::ostream& out, const FaultPlace& place) {
    out << " at";
    for (int i = 0; i < place.point_count; ++i) {
        const auto [x, y, z] = place.points_mm[static_cast<std::size_t>(i)];
        out << ' ' << x << ',' << y << ',' << z;
    }
    for (const std::int64_t face : place.triangles) {
        out << (face < 0 ? "" : " #" + std::to_string(face));
    }
    out << (place.parts == 0 ? "" : " x" + std::to_string(place.parts));
    if (place.measure != 0) {
        out << " measure " << place.measure;
    }
    out << (place.closed ? " closed" : "");
}

std::string text_of(const MeshCheck& check) {
    std::ostringstream out;
    const FaultFinding* last = nullptr;
    for (std::size_t i = 0; i < fault_count; ++i) {
        if (const FaultFinding& finding = check.findings[i]; finding.count > 0) {
            out << (last == nullptr ? "" : ", ") << finding.count << ' ' << words_for(static_cast<Fault>(i), finding.count);
            last = &finding;
        }
    }
    if (last != nullptr) {
        add_place(out, last->places.at(0));
    }
    const auto is_open = [](const MeshShell& shell) { return !shell.closed; };
    if (std::all_of(check.shells.begin(), check.shells.end(), is_open)) {
        return out.str();
    }
    for (const MeshShell& shell : check.shells) {
        out << (out.view().empty() ? "" : "; ") << (shell.closed ? "shell " : "open shell ") << shell.volume_mm3;
        if (shell.depth > 0) {
            out << " depth " << shell.depth << " in " << shell.parent;
        }
    }
    return out.str();
}

struct Row {
    const char* name;
    Soup soup;
    const char* found;
};

void check_rows(const std::vector<Row>& rows, const CheckOptions& options = {}) {
    for (const Row& row : rows) {
        INFO(row.name);
        CHECK(text_of(findings_of(row.soup, options)) == row.found);
    }
}

Soup cube(double size) {
    return box({0, 0, 0}, {size, size, size});
}

/// A band of quads around the z axis, given half a turn on the way round.
Soup moebius_strip(int quads) {
    const auto at = [&](int i, double across) {
        const double turn = 2 * M_PI * i / quads;
        const double radius = 10 + across * std::cos(turn / 2);
        return Xyz{radius * std::cos(turn), radius * std::sin(turn), across * std::sin(turn / 2)};
    };
    Soup soup = quad(at(quads - 1, -2), at(0, 2), at(0, -2), at(quads - 1, 2));
    for (int i = 0; i + 1 < quads; ++i) {
        append(soup, quad(at(i, -2), at(i + 1, -2), at(i + 1, 2), at(i, 2)));
    }
    return soup;
}

/// Six shells within one another and six beside each other, by turns.
Soup nest() {
    Soup soup;
    for (int i = 0; i < 6; ++i) {
        const Soup shell = box({1.0 * i, 1.0 * i, 1.0 * i}, {40.0 - i, 40.0 - i, 40.0 - i});
        soup = joined({i % 2 == 0 ? shell : flipped(shell), soup, box({100.0 + 3 * i, 0, 0}, {101.0 + 3 * i, 1, 1})});
    }
    return soup;
}

const Soup large = tetrahedron({0, 0, 0}, {0, 30, 0}, {30, 0, 0}, {0, 0, 30});
const Soup spike = tetrahedron({4, 4, -4}, {4, 6, -4}, {6, 4, -4}, {5, 5, 4});

TEST_CASE("faults of edges and vertices are found", "[check]") {
    const Soup fan = joined({triangle({0, 0, 0}, {0, 0, 2}, {2, 0, 0}), triangle({0, 0, 0}, {0, 0, 2}, {0, 3, 0}),
                             triangle({0, 0, 0}, {0, 0, 2}, {-4, -4, 0})});
    const Soup octahedron = octasphere({0, 0, 0}, 1, 0);
    check_rows({
        {"a closed box has none", box({1, 2, 3}, {3, 4, 5}), "shell 8"},
        {"a sphere", octasphere({1, 2, 3}, 30, 5), "shell 112929"},
        {"however close the sheets", box({0, 0, 0}, {9, 9, 1.0 / 1024}),
         "8 needles at 0,0,0 0,0,0.000976562 0,9,0 #10 measure 9216; shell 0.0791016"},
        {"a missing side is four boundary edges in a loop", without(cube(2), 2, 2),
         "4 boundary edges, 1 boundary loop at 0,0,2 #3 x4 measure 8 closed"},
        {"holes that touch at a vertex are separate loops", without(without(octahedron, 6, 1), 0, 1),
         "6 boundary edges, 2 boundary loops, 1 split vertex at 1,0,0 #1 x2"},
        {"of three chains between the ends of an edge with three faces two make a loop", fan,
         "6 boundary edges, 2 boundary loops, 1 unbalanced over-full edge, 2 split vertices at 0,0,0 #2 x3"},
        {"cubes that share an edge", joined({cube(1), box({1, 1, 0}, {2, 2, 1})}),
         "1 balanced over-full edge, 2 split vertices at 1,1,0 #0 x2; shell 2"},
        {"cubes that share a vertex", joined({cube(1), box({1, 1, 1}, {2, 2, 2})}),
         "1 split vertex at 1,1,1 #3 x2; shell 1; shell 1"},
        {"a Moebius strip has one side and one boundary", moebius_strip(20),
         "40 boundary edges, 1 boundary loop, 1 mismatched edge, 1 one-sided patch at -6.41155,-8.82474,-1.78201 "
         "-5.34415,-7.3556,1.78201 -8.59017,-6.24112,-1.90211 #26"},
    });
    check_rows({{"the same moved by a transform", without(cube(2), 2, 2),
                 "4 boundary edges, 1 boundary loop at 0,0,20 #3 x4 measure 80 closed"}},
               {.frame = {.transform = Transform::scale(10)}});
}

TEST_CASE("faults of single faces are found", "[check]") {
    const Soup face = only(cube(1), 5, 1);
    const Soup two = joined({triangle({0, 0, 0}, {0.3, 0, 0}, {0, 8, 0}), triangle({0, 0, 10}, {9, 0, 10}, {0, 8, 10})});
    const Soup flat = triangle({9, 0, 0}, {10, 0, 0}, {12, 0, 0});
    check_rows({
        {"a flipped patch, before those around it", joined({flipped(only(cube(1), 0, 2)), without(cube(1), 0, 2)}),
         "4 mismatched edges, 2 flipped faces at 0,0,0 1,1,0 0,1,0 #0"},
        {"most are flipped", joined({flipped(only(cube(1), 0, 10)), without(cube(1), 0, 10)}),
         "4 mismatched edges, 2 flipped faces at 0,0,0 0,0,1 0,1,0 #10"},
        {"of two the second", joined({triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), triangle({1, 0, 0}, {0, 1, 0}, {1, 1, 0})}),
         "4 boundary edges, 1 boundary loop, 1 mismatched edge, 1 flipped face at 0,1,0 1,1,0 1,0,0 #1"},
        {"a duplicate", joined({cube(1), face}),
         "3 unbalanced over-full edges, 3 split vertices, 1 duplicate face at 0,0,0 1,0,1 0,0,1 #5 #12"},
        {"an opposite face", joined({cube(1), flipped(face)}),
         "3 unbalanced over-full edges, 3 split vertices, 1 pair of opposite faces at 0,0,0 0,0,1 1,0,1 #12 #5"},
        {"a face and its opposite alone", joined({face, flipped(face)}),
         "1 pair of opposite faces at 0,0,0 0,0,1 1,0,1 #1 #0; shell 0"},
        {"five on one place", joined({face, face, face, flipped(face), flipped(face)}),
         "3 unbalanced over-full edges, 3 split vertices, 3 duplicate faces, 2 pairs of opposite faces at 0,0,0 0,0,1 1,0,1 "
         "#3 #0"},
        {"collapsed faces",
         joined({cube(4), triangle({0, 0, 0}, {0, 0, 0}, {4, 0, 0}), triangle({9, 9, 9}, {9, 9, 9}, {9, 9, 9})}),
         "2 collapsed faces at 0,0,0 0,0,0 4,0,0 #12; shell 64"},
        {"no face collapses on a fine grid", two,
         "6 boundary edges, 2 boundary loops at 0,0,0 #0 x3 measure 16.3056 closed"},
        {"a face without area", flat, "3 boundary edges, 1 boundary loop, 1 face without area at 9,0,0 10,0,0 12,0,0 #0"},
        {"a needle from the ratio on", triangle({0, 0, 0}, {100, 0, 0}, {0, 1, 0}),
         "3 boundary edges, 1 boundary loop, 1 needle at 0,0,0 100,0,0 0,1,0 #0 measure 100.01"},
        {"a needle below it", triangle({0, 0, 0}, {90, 0, 0}, {0, 1, 0}),
         "3 boundary edges, 1 boundary loop at 0,0,0 #0 x3 measure 181.006 closed"},
        {"a cap", triangle({0, 0, 0}, {100, 0, 0}, {50, 1, 0}),
         "3 boundary edges, 1 boundary loop, 1 cap at 0,0,0 100,0,0 50,1,0 #0 measure 100"},
        {"a cap below the ratio", triangle({0, 0, 0}, {99, 0, 0}, {50, 1, 0}),
         "3 boundary edges, 1 boundary loop at 0,0,0 #0 x3 measure 198.02 closed"},
        {"needles of a box", box({0, 0, 0}, {1, 1, 200}), "8 needles at 0,0,0 0,0,200 0,1,0 #10 measure 200.005; shell 200"},
    });
    check_rows({{"none by another ratio", box({0, 0, 0}, {1, 1, 200}), "shell 200"}}, {.sliver_ratio = 201});
    check_rows({{"a face that collapses on a coarse grid", two,
                 "3 boundary edges, 1 boundary loop, 1 collapsed face at 0,0,0 0,0,0 0,8,0 #0"}},
               {.frame = {.grid_mm = 1}});
}

TEST_CASE("gaps are found", "[check]") {
    // The top of a box, one of its triangles split at the middle of an edge to a side that is not.
    const Soup split = joined(
        {without(cube(2), 2, 1), triangle({0, 0, 2}, {1, 0, 2}, {2, 2, 2}), triangle({1, 0, 2}, {2, 0, 2}, {2, 2, 2})});
    constexpr double width = 1.0 / 256;
    const Soup cracked = joined({quad({0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0}),
                                 quad({1 + width, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1 + width, 1, 0}),
                                 quad({1 + width, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1 + width, 2, 0})});
    const Soup two = joined({triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), triangle({5, 5, 5}, {6, 5, 5}, {5, 6, 5})});
    check_rows({
        {"a T-junction without width", split,
         "3 boundary edges, 1 boundary loop, 2 touches of faces, 1 T-junction at 1,0,2 1,0,2 #4"},
        {"a corner near a side of its own triangle is none", triangle({0, 0, 0}, {2, 0, 0}, {1, 1.0 / 256, 0}),
         "3 boundary edges, 1 boundary loop, 1 cap at 0,0,0 2,0,0 1,0.00390625,0 #0 measure 512"},
    });
    check_rows({{"a tolerance larger than the mesh", two,
                 "6 boundary edges, 2 boundary loops, 9 cracks at 0,0,0 5,5,5 measure 8.66025"}},
               {.tolerance_mm = 1e300});
    check_rows({{"the ends of a short edge are none", triangle({0, 0, 0}, {0.5, 0, 0}, {0, 9, 0}),
                 "3 boundary edges, 1 boundary loop at 0,0,0 #0 x3 measure 18.5139 closed"}},
               {.tolerance_mm = 1});
    check_rows(
        {{"no crack below its width", cracked, "10 boundary edges, 2 boundary loops at 0,0,0 #0 x4 measure 6 closed"}},
        {.tolerance_mm = 0.99 * width});
    check_rows({{"a crack from its width on, with the T-junction along it", cracked,
                 "10 boundary edges, 2 boundary loops, 1 T-junction, 2 cracks at 1,0,0 1.00391,0,0 measure 0.00390625"}},
               {.tolerance_mm = width});
    check_rows({{"a T-junction without tolerance", split,
                 "3 boundary edges, 1 boundary loop, 2 touches of faces, 1 T-junction at 1,0,2 1,0,2 #4"}},
               {.tolerance_mm = 0});
}

TEST_CASE("faces that meet are found", "[check]") {
    check_rows({
        {"a tip through a face crosses it three times", joined({large, spike}),
         "3 crossings of faces at 4.5,4.5,0 4.5,5.5,0 #0 #6; shell 4500; shell 5.33333"},
        {"boxes stacked askew overlap where both diagonals lie on x = y", joined({cube(2), box({1, 1, 2}, {3, 3, 4})}),
         "2 overlaps of faces, 16 touches of faces at 1,1.5,2 #3 #22; shell 8; shell 8"},
    });
    for (const FaultPlace& place : findings_of(joined({large, spike})).of(Fault::crossing_faces).places) {
        REQUIRE(place.point_count == 2);
        CHECK(place.points_mm[0][2] == Approx(0).margin(1e-9));  // the face that is pierced lies in z = 0
        CHECK(place.points_mm[1][2] == Approx(0).margin(1e-9));
        CHECK(place.triangles[0] != place.triangles[1]);
    }
}

TEST_CASE("a body exported a thousand times meets another as often as if exported once", "[check]") {
    Soup soup = spike;
    for (int i = 0; i < 1000; ++i) {
        append(soup, large);
    }
    const MeshCheck check = findings_of(joined({soup, flipped(large)}));
    CHECK(check.complete());
    CHECK(check.of(Fault::crossing_faces).count == 3);
    CHECK(check.of(Fault::duplicate_face).count == 3996);
}

TEST_CASE("shells, their orientations and nesting are found", "[check]") {
    const Soup inner = box({3, 3, 3}, {6, 6, 6});
    const Soup solids = joined({cube(9), box({2, 2, 2}, {20, 8, 8})});
    const Soup through = box({3, 3, 3}, {12, 7, 7});
    const Soup elsewhere = joined({box({0, 0, 40}, {9, 9, 49}), box({3, 3, 43}, {6, 6, 46})});
    const Soup all_of_the_grid = box({-1023, -1023, -1023}, {1023, 1023, 1023});
    check_rows({
        {"a cavity", joined({cube(9), flipped(inner)}), "shell 729; shell -27 depth 1 in 0"},
        {"a solid in a solid", joined({inner, cube(9)}),
         "1 shell of wrong sense at 3,3,3 #10 measure 27; shell 729; shell 27 depth 1 in 0"},
        {"an inverted solid", flipped(cube(9)), "1 shell of wrong sense at 0,0,0 #10 measure -729; shell -729"},
        {"a nest", nest(),
         "shell 64000; shell -54872 depth 1 in 0; shell 46656 depth 2 in 1; shell -39304 depth 3 in 2; shell 32768 depth 4 "
         "in 3; shell -27000 depth 5 in 4; shell 1; shell 1; shell 1; shell 1; shell 1; shell 1"},
        {"a cavity whose first vertices all lie on the outer shell", joined({cube(9), flipped(box({0, 3, 3}, {4, 5, 5}))}),
         "3 overlaps of faces, 10 touches of faces at 0,3,4 #10 #17; shell 729; shell -16 depth 1 in 0"},
        {"a solid that touches from outside", joined({cube(9), box({9, 3, 3}, {12, 5, 5})}),
         "4 overlaps of faces, 15 touches of faces at 9,3,4 #7 #17; shell 729; shell 12"},
        {"a solid through a wall", joined({cube(9), through}),
         "8 crossings of faces, 4 touches of faces at 9,3,5 #16 #6; shell 729; shell 144 depth 1 in 0"},
        {"through an edge", joined({cube(9), box({3, 3, 0}, {12, 7, 4})}),
         "8 crossings of faces, 3 overlaps of faces, 12 touches of faces at 3,5,0 #0 #22; shell 729; shell 144"},
        {"through a corner", joined({cube(9), box({3, 0, 0}, {12, 4, 4})}),
         "4 crossings of faces, 6 overlaps of faces, 23 touches of faces at 3,0,2 #5 #22; shell 729; shell 144"},
        {"an inverted one beside it", joined({cube(9), flipped(moved(through, {-12, 0, 0}))}),
         "1 shell of wrong sense, 4 overlaps of faces, 10 touches of faces at 0,3,5 #17 #11; shell -144; shell 729"},
        {"a cavity within both of two that cross", joined({solids, flipped(box({4, 4, 4}, {5, 5, 5}))}),
         "8 crossings of faces, 4 touches of faces at 9,2,5 #16 #6; shell 729; shell 648 depth 1 in 0; shell -1 depth 2 in "
         "1"},
        {"a solid in a solid apart from these", joined({solids, elsewhere}),
         "1 shell of wrong sense, 8 crossings of faces, 4 touches of faces at 9,2,5 #16 #6; shell 729; shell 729; shell 648 "
         "depth 1 in 0; shell 27 depth 1 in 1"},
        {"an open shell is around nothing", joined({without(cube(9), 3, 1), inner}),
         "3 boundary edges, 1 boundary loop at 0,0,9 #10 x3 measure 30.7279 closed; open shell 0; shell 27"},
        {"an open shell within a closed one", joined({cube(9), triangle({3, 3, 3}, {4, 3, 3}, {3, 4, 3})}),
         "3 boundary edges, 1 boundary loop at 3,3,3 #12 x3 measure 3.41421 closed; shell 729; open shell 0 depth 1 in 0"},
    });
    const MeshCheck largest = findings_of(all_of_the_grid, {.frame = {.grid_mm = default_grid_mm}});
    CHECK(largest.shells.at(0).volume_mm3 == 2046.0 * 2046.0 * 2046.0);
}

TEST_CASE("rays through edges and vertices of the shell around count once", "[check]") {
    // The inner corners stand straight below vertices, edges and diagonals of the outer top, and beside vertical faces.
    const Soup outer = octasphere({0, 0, 0}, 8, 1);
    for (const double x : {-1.0, 0.0, 1.0}) {
        for (const double y : {-1.0, 0.0, 1.0}) {
            const MeshCheck inside = findings_of(joined({outer, flipped(box({x, y, -1}, {x + 1, y + 1, 0}))}));
            CHECK(inside.shells.at(1).depth == 1);
            const MeshCheck below = findings_of(joined({outer, box({x, y, -20}, {x + 1, y + 1, -19})}));
            CHECK(below.shells.at(0).depth + below.shells.at(1).depth == 0);
        }
    }
}

TEST_CASE("a search of piled up triangles ends at its budget, reports that, and finds all else", "[check]") {
    Soup soup;
    for (int i = 0; i < 12'000; ++i) {  // all boxes meet, and no two triangles
        append(soup, triangle({0, 0, 0.5 * i}, {1, 0, 9000 + 0.5 * i}, {0, 1, 9000 + 0.5 * i}));
    }
    const CheckOptions options{.tolerance_mm = 0};
    const MeshCheck fewer = findings_of(only(soup, 0, 1000), options);
    CHECK(fewer.complete());
    CHECK(make_verdict(fewer).value() == "not clean: 3000 boundary edges, 1000 boundary loops");
    // Groups of faces far before and behind the pile, which takes nothing from them.
    for (const double at : {-20'060.0, -20'040.0, -20'020.0, -20'000.0, 20'000.0, 20'020.0, 20'040.0, 20'060.0}) {
        append(soup, triangle({at, at, at}, {at + 8, at, at}, {at, at + 8, at}));
        append(soup, triangle({at + 1, at + 1, at - 4}, {at + 1, at + 1, at + 4}, {at + 8, at + 8, at}));
    }
    const MeshCheck check = findings_of(soup, options);
    CHECK(check.of(Fault::crossing_faces).at_least);
    CHECK(check.of(Fault::crossing_faces).count == 8);
    CHECK(check.of(Fault::touching_faces).at_least);
    CHECK_FALSE(check.of(Fault::boundary_edge).at_least);
    CHECK_FALSE(check.complete());
    CHECK(make_verdict(check).value() ==
          "not clean: 36048 boundary edges, 12016 boundary loops, at least 8 crossings of faces, as far as was searched");
}

TEST_CASE("only as many places as asked for are kept, all are counted", "[check]") {
    const MeshCheck check = findings_of(random_soup(3, 40, 20), {.most_places = 3});
    const MeshCheck none = findings_of(random_soup(3, 40, 20), {.most_places = 0});
    CHECK(check.of(Fault::boundary_edge).count > 100);
    for (std::size_t i = 0; i < fault_count; ++i) {
        CHECK(check.findings[i].places.size() == std::min<std::uint64_t>(3, check.findings[i].count));
        CHECK(none.findings[i].count == check.findings[i].count);
        CHECK(none.findings[i].places.empty());
    }
}

TEST_CASE("unusable input and options are refused", "[check]") {
    CHECK(check(MeshView{}).error().code == ErrorCode::empty_mesh);
    Soup soup = cube(1);
    const MeshView view = MeshView::soup(std::span<const double>(soup));
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {-1.0, infinity, no_number}) {
        CHECK(check(view, {.tolerance_mm = bad}).error().code == ErrorCode::invalid_argument);
    }
    for (const double bad : {1.0, -5.0, no_number}) {
        CHECK(check(view, {.sliver_ratio = bad}).error().code == ErrorCode::invalid_argument);
    }
    soup[13] = no_number;
    CHECK(check(view).error().triangle == 1);
}

OrientedMesh oriented(const Soup& soup, double mm_per_unit = 1, const Context& context = {}) {
    MeshView mesh = MeshView::soup(std::span<const double>(soup));
    mesh.mm_per_unit = mm_per_unit;
    Result<OrientedMesh> turned = orient_shells(mesh, 0, context);
    REQUIRE(turned.ok());
    CHECK(turned->complete);
    return std::move(turned).value();
}

double volume_of(const OrientedMesh& oriented) {
    return check(oriented.view(), {.counts_only = true}).value().volume_mm3;
}

TEST_CASE("orient: shells are turned outwards, and inwards within an odd number of others", "[check][orient]") {
    const Soup nested[] = {box({0, 0, 0}, {10, 10, 10}), box({1, 1, 1}, {9, 9, 9}), box({2, 2, 2}, {8, 8, 8})};
    for (int turns = 0; turns < 8; ++turns) {
        Soup soup;
        for (int shell = 0; shell < 3; ++shell) {
            soup = joined({soup, (turns >> shell & 1) != 0 ? flipped(nested[shell]) : nested[shell]});
        }
        const OrientedMesh turned = oriented(soup);
        CHECK(turned.shells == 3);
        CHECK(turned.turned_shells == static_cast<std::uint64_t>((turns & 1) + (turns >> 2 & 1) + (~turns >> 1 & 1)));
        CHECK(volume_of(turned) == 1000 - 512 + 216);
    }
}

TEST_CASE("orient: a shell that touches another from inside lies within it; one that crosses it does not",
          "[check][orient]") {
    const Soup body = box({0, 0, 0}, {10, 10, 10});
    CHECK(volume_of(oriented(joined({body, box({0, 3, 1}, {5, 7, 9})}))) == 840);
    CHECK(volume_of(oriented(joined({body, flipped(box({5, 5, 2}, {15, 15, 8}))}))) == 1600);
    CHECK(volume_of(oriented(joined({body, flipped(box({0, 0, 5}, {10, 10, 15}))}))) == 2000);
    CHECK(volume_of(oriented(joined({flipped(body), flipped(box({10, 0, 0}, {12, 3, 3}))}))) == 1018);
    // All corners of the ball lie within the box, or nearly: its faces cross those of the box.
    CHECK(oriented(joined({body, flipped(octasphere({5, 5, 5}, 5.5, 3))})).turned_shells == 1);
    CHECK(oriented(joined({body, octasphere({5, 5, 5}, 4.5, 3)})).turned_shells == 1);
}

TEST_CASE("orient: what is open stays; the answer has the unit, and does not depend on threads", "[check][orient]") {
    Soup open = box({0, 0, 0}, {1, 1, 1});
    open.resize(90);
    CHECK(oriented(flipped(open)).turned_shells == 0);
    const Soup both = joined({open, flipped(box({3, 0, 0}, {4, 1, 1}))});
    const Result<OrientedMesh> beside = orient_shells(MeshView::soup(std::span<const double>(both)));
    REQUIRE(beside.ok());
    CHECK(beside->turned_shells == 1);
    CHECK_FALSE(beside->complete);
    const Soup many = random_tetrahedra(7, 200, 60);
    const OrientedMesh one = oriented(many, 10, {.threads = 1});
    const OrientedMesh several = oriented(many, 10, {.threads = 5});
    CHECK(one.mesh.mm_per_unit == 10);
    CHECK(one.turned_shells > 0);
    CHECK(std::equal(one.mesh.indices.begin(), one.mesh.indices.end(), several.mesh.indices.begin()));
}

}  // namespace
}  // namespace lamella::check_test
