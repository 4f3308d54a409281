// Edges, vertices, loops, orientations, single faces and gaps.
#include <cmath>
#include <limits>

#include "check/findings.hpp"

namespace lamella::check_test {

using shapes::box;
using shapes::flipped;
using shapes::joined;
using shapes::triangle;

namespace {

/// A band of quads around the z axis, given half a turn on the way round.
Soup moebius_strip(int quads) {
    const auto at = [&](int i, double across) {
        const double turn = 2 * M_PI * i / quads;
        const double radius = 10 + across * std::cos(turn / 2);
        return Xyz{radius * std::cos(turn), radius * std::sin(turn), across * std::sin(turn / 2)};
    };
    Soup soup;
    for (int i = 0; i + 1 < quads; ++i) {
        const Soup piece = quad(at(i, -2), at(i + 1, -2), at(i + 1, 2), at(i, 2));
        soup.insert(soup.end(), piece.begin(), piece.end());
    }
    return joined({soup, quad(at(quads - 1, -2), at(0, 2), at(0, -2), at(quads - 1, 2))});
}

}  // namespace

TEST_CASE("a box is closed and clean", "[check]") {
    const MeshCheck check = findings_of(box({1, 2, 3}, {3, 4, 5}));
    CHECK(counts(check).empty());
    CHECK(check.clean());
    CHECK(check.closed);
    CHECK(make_verdict(check).value() == "closed and clean");
    REQUIRE(check.shells.size() == 1);
    CHECK(check.shells[0].volume_mm3 == 8);
    CHECK(check.shells[0].first_mm == Xyz{1, 2, 3});
    CHECK(check.shells[0].triangles == 12);
}

TEST_CASE("a missing face is four boundary edges in a loop", "[check]") {
    const MeshCheck check = findings_of(without(box({0, 0, 0}, {2, 2, 2}), 2, 2));
    CHECK(counts(check) == Counts{{"boundary_edges", 4}, {"boundary_loops", 1}});
    const FaultPlace& edge = first(check, Fault::boundary_edge);
    CHECK(edge.point_count == 2);
    CHECK(edge.points_mm[0] == Xyz{0, 0, 2});
    CHECK(edge.points_mm[1] == Xyz{0, 2, 2});
    CHECK(edge.parts == 1);
    const FaultPlace& loop = first(check, Fault::boundary_loop);
    CHECK(loop.points_mm[0] == Xyz{0, 0, 2});
    CHECK(loop.parts == 4);
    CHECK(loop.measure == 8);
    CHECK(loop.closed);
    CHECK(make_verdict(check).value() == "not clean: 4 boundary edges, 1 boundary loop");
    CHECK_FALSE(check.shells.at(0).closed);
}

TEST_CASE("holes that touch at a vertex are separate loops", "[check]") {
    // Two triangles of an octahedron that share only a vertex.
    const MeshCheck check = findings_of(without(without(shapes::octasphere({0, 0, 0}, 1, 0), 6, 1), 0, 1));
    CHECK(check.of(Fault::boundary_edge).count == 6);
    CHECK(check.of(Fault::boundary_loop).count == 2);
    CHECK(check.of(Fault::split_vertex).count == 1);
    for (const FaultPlace& loop : check.of(Fault::boundary_loop).places) {
        CHECK(loop.parts == 3);
        CHECK(loop.measure == Approx(3 * std::sqrt(2)));
        CHECK(loop.closed);
    }
}

TEST_CASE("boundary edges that end at an edge with three faces are an open chain", "[check]") {
    const MeshCheck check =
        findings_of(joined({triangle({0, 0, 0}, {0, 0, 2}, {2, 0, 0}), triangle({0, 0, 0}, {0, 0, 2}, {0, 3, 0}),
                            triangle({0, 0, 0}, {0, 0, 2}, {-4, -4, 0})}));
    CHECK(check.of(Fault::overfull_unbalanced).count == 1);
    CHECK(check.of(Fault::boundary_edge).count == 6);
    CHECK(check.of(Fault::boundary_loop).count == 2);  // three chains from one end of the edge to the other: a loop, and one
    std::uint64_t closed = 0;
    for (const FaultPlace& loop : check.of(Fault::boundary_loop).places) {
        closed += loop.closed ? 1 : 0;
        CHECK(loop.parts == (loop.closed ? 4 : 2));
    }
    CHECK(closed == 1);
}

TEST_CASE("cubes that share an edge have a balanced over-full edge", "[check]") {
    const MeshCheck check = findings_of(joined({box({0, 0, 0}, {1, 1, 1}), box({1, 1, 0}, {2, 2, 1})}));
    CHECK(counts(check) == Counts{{"overfull_edges_balanced", 1}, {"split_vertices", 2}});
    const FaultPlace& edge = first(check, Fault::overfull_balanced);
    CHECK(edge.points_mm[0] == Xyz{1, 1, 0});
    CHECK(edge.points_mm[1] == Xyz{1, 1, 1});
    CHECK(edge.parts == 4);
    CHECK(first(check, Fault::split_vertex).parts == 2);
    CHECK(check.shells.size() == 1);
    CHECK(check.shells[0].closed);
    CHECK(check.shells[0].volume_mm3 == 2);
}

TEST_CASE("cubes that share a vertex have a split vertex", "[check]") {
    const MeshCheck check = findings_of(joined({box({0, 0, 0}, {1, 1, 1}), box({1, 1, 1}, {2, 2, 2})}));
    CHECK(counts(check) == Counts{{"split_vertices", 1}});
    const FaultPlace& vertex = first(check, Fault::split_vertex);
    CHECK(vertex.point_count == 1);
    CHECK(vertex.points_mm[0] == Xyz{1, 1, 1});
    CHECK(vertex.parts == 2);
    CHECK(check.shells.size() == 2);
}

TEST_CASE("a flipped patch is distinguished from the faces around it", "[check]") {
    const Soup cube = box({0, 0, 0}, {1, 1, 1});
    const MeshCheck few = findings_of(joined({flipped(only(cube, 0, 2)), without(cube, 0, 2)}));
    CHECK(counts(few) == Counts{{"mismatched_edges", 4}, {"flipped_faces", 2}});
    CHECK(first(few, Fault::flipped_face).triangles[0] < 2);
    CHECK(first(few, Fault::flipped_face).point_count == 3);
    const MeshCheck most = findings_of(joined({flipped(only(cube, 0, 10)), without(cube, 0, 10)}));
    CHECK(counts(most) == Counts{{"mismatched_edges", 4}, {"flipped_faces", 2}});
    CHECK(first(most, Fault::flipped_face).triangles[0] >= 10);
}

TEST_CASE("of two faces of opposite orientation the second is flipped", "[check]") {
    const MeshCheck check =
        findings_of(joined({triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), triangle({1, 0, 0}, {0, 1, 0}, {1, 1, 0})}));
    CHECK(check.of(Fault::mismatched_edge).count == 1);
    CHECK(check.of(Fault::flipped_face).count == 1);
    CHECK(first(check, Fault::flipped_face).triangles[0] == 1);
}

TEST_CASE("a Moebius strip has one side and one boundary", "[check]") {
    const MeshCheck check = findings_of(moebius_strip(20));
    CHECK(counts(check) ==
          Counts{{"boundary_edges", 40}, {"boundary_loops", 1}, {"mismatched_edges", 1}, {"one_sided_patches", 1}});
    CHECK(first(check, Fault::boundary_loop).parts == 40);
}

TEST_CASE("faces on the same vertices are duplicates or opposite", "[check]") {
    const Soup cube = box({0, 0, 0}, {1, 1, 1});
    const Soup face = only(cube, 5, 1);
    const MeshCheck twice = findings_of(joined({cube, face}));
    CHECK(counts(twice) == Counts{{"duplicate_faces", 1}, {"overfull_edges_unbalanced", 3}, {"split_vertices", 3}});
    CHECK(first(twice, Fault::duplicate_face).triangles == std::array<std::int64_t, 2>{5, 12});
    const MeshCheck opposite = findings_of(joined({cube, flipped(face)}));
    CHECK(counts(opposite) == Counts{{"opposite_faces", 1}, {"overfull_edges_unbalanced", 3}, {"split_vertices", 3}});
    const MeshCheck folded = findings_of(joined({face, flipped(face)}));
    CHECK(counts(folded) == Counts{{"opposite_faces", 1}});
    CHECK(folded.shells.at(0).closed);
    CHECK(folded.shells.at(0).orientation == 0);
    const MeshCheck many = findings_of(joined({face, face, face, flipped(face), flipped(face)}));
    CHECK(many.of(Fault::duplicate_face).count == 3);
    CHECK(many.of(Fault::opposite_face).count == 2);
}

TEST_CASE("faces without area are found, collapsed or not", "[check]") {
    const Soup cube = box({0, 0, 0}, {4, 4, 4});
    const MeshCheck collapsed =
        findings_of(joined({cube, triangle({0, 0, 0}, {0, 0, 0}, {4, 0, 0}), triangle({9, 9, 9}, {9, 9, 9}, {9, 9, 9})}));
    CHECK(counts(collapsed) == Counts{{"collapsed_faces", 2}});
    CHECK(collapsed.degenerate == 2);
    CHECK(first(collapsed, Fault::collapsed_face).triangles[0] == 12);
    const MeshCheck flat = findings_of(joined({cube, triangle({9, 0, 0}, {10, 0, 0}, {12, 0, 0})}));
    CHECK(flat.of(Fault::zero_area_face).count == 1);
    CHECK(first(flat, Fault::zero_area_face).triangles[0] == 12);
    CHECK(flat.of(Fault::needle_face).count + flat.of(Fault::cap_face).count == 0);
    CHECK_FALSE(flat.clean());
}

TEST_CASE("collapsing is judged on the grid", "[check]") {
    const Soup soup = joined({triangle({0, 0, 0}, {0.3, 0, 0}, {0, 8, 0}), triangle({0, 0, 10}, {9, 0, 10}, {0, 8, 10})});
    CHECK(findings_of(soup).of(Fault::collapsed_face).count == 0);
    CHECK(findings_of(soup, {.frame = {.grid_mm = 1}}).of(Fault::collapsed_face).count == 1);
}

TEST_CASE("needles and caps are found from the ratio on", "[check]") {
    const auto shape = [](const Soup& soup) { return counts(findings_of(soup)); };
    CHECK(shape(triangle({0, 0, 0}, {100, 0, 0}, {0, 1, 0})).count("needle_faces") == 1);
    CHECK(shape(triangle({0, 0, 0}, {90, 0, 0}, {0, 1, 0})).count("needle_faces") == 0);
    CHECK(shape(triangle({0, 0, 0}, {100, 0, 0}, {50, 1, 0})).count("cap_faces") == 1);
    CHECK(shape(triangle({0, 0, 0}, {99, 0, 0}, {50, 1, 0})).count("cap_faces") == 0);
    const MeshCheck cap = findings_of(triangle({0, 0, 0}, {1000, 0, 0}, {500, 0, 2}));
    CHECK(first(cap, Fault::cap_face).measure == Approx(500));
    // Slivers alone leave a mesh clean, and are named.
    const MeshCheck thin = findings_of(box({0, 0, 0}, {1, 1, 200}));
    CHECK(thin.clean());
    CHECK(make_verdict(thin).value() == "closed and clean, with 8 needles");
    CHECK(make_verdict(findings_of(box({0, 0, 0}, {1, 1, 200}), {.sliver_ratio = 201})).value() == "closed and clean");
}

TEST_CASE("a T-junction without width is found", "[check]") {
    // The top of a box, one of its triangles split at the middle of an edge to a side that is not.
    const Soup cube = shapes::box({0, 0, 0}, {2, 2, 2});
    const Soup split =
        joined({without(cube, 2, 1), triangle({0, 0, 2}, {1, 0, 2}, {2, 2, 2}), triangle({1, 0, 2}, {2, 0, 2}, {2, 2, 2})});
    for (const double tolerance_mm : {0.01, 0.0}) {
        const MeshCheck check = findings_of(split, {.tolerance_mm = tolerance_mm});
        CHECK(counts(check) ==
              Counts{{"boundary_edges", 3}, {"boundary_loops", 1}, {"t_junctions", 1}, {"touching_faces", 2}});
        const FaultPlace& place = first(check, Fault::t_junction);
        CHECK(place.points_mm[0] == Xyz{1, 0, 2});
        CHECK(place.points_mm[1] == Xyz{1, 0, 2});
        CHECK(place.measure == 0);
    }
}

TEST_CASE("a crack is found from its width on, with the T-junction along it", "[check]") {
    const double width = 1.0 / 256;
    const Soup left = quad({0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0});
    const Soup right = joined({quad({1 + width, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1 + width, 1, 0}),
                               quad({1 + width, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1 + width, 2, 0})});
    const MeshCheck wide = findings_of(joined({left, right}), {.tolerance_mm = width});
    CHECK(wide.of(Fault::crack).count == 2);
    CHECK(first(wide, Fault::crack).measure == width);
    CHECK(first(wide, Fault::crack).points_mm[0] == Xyz{1, 0, 0});
    CHECK(first(wide, Fault::crack).points_mm[1] == Xyz{1 + width, 0, 0});
    CHECK(wide.of(Fault::t_junction).count == 1);
    CHECK(first(wide, Fault::t_junction).measure == width);
    CHECK(first(wide, Fault::t_junction).points_mm[0] == Xyz{1 + width, 1, 0});
    CHECK(first(wide, Fault::t_junction).points_mm[1] == Xyz{1, 1, 0});
    CHECK(wide.of(Fault::touching_faces).count == 0);
    const MeshCheck narrow = findings_of(joined({left, right}), {.tolerance_mm = 0.99 * width});
    CHECK(narrow.of(Fault::crack).count == 0);
    CHECK(narrow.of(Fault::t_junction).count == 0);
}

TEST_CASE("the ends of a short edge are no crack", "[check]") {
    const MeshCheck check = findings_of(triangle({0, 0, 0}, {0.5, 0, 0}, {0, 9, 0}), {.tolerance_mm = 1});
    CHECK(check.of(Fault::crack).count == 0);
    CHECK(check.of(Fault::t_junction).count == 0);
}

TEST_CASE("a corner near a side of its own triangle makes that flat, and no T-junction", "[check]") {
    const MeshCheck flat = findings_of(triangle({9, 0, 0}, {10, 0, 0}, {12, 0, 0}));
    CHECK(counts(flat) == Counts{{"boundary_edges", 3}, {"boundary_loops", 1}, {"zero_area_faces", 1}});
    const MeshCheck cap = findings_of(triangle({0, 0, 0}, {2, 0, 0}, {1, 1.0 / 256, 0}));
    CHECK(counts(cap) == Counts{{"boundary_edges", 3}, {"boundary_loops", 1}, {"cap_faces", 1}});
}

TEST_CASE("a tolerance larger than the mesh is accepted", "[check]") {
    const Soup two = joined({triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), triangle({5, 5, 5}, {6, 5, 5}, {5, 6, 5})});
    const MeshCheck check = findings_of(two, {.tolerance_mm = 1e300});
    CHECK(check.of(Fault::crack).count == 9);
    CHECK(check.of(Fault::t_junction).count == 0);
}

TEST_CASE("a closed mesh has no gaps, however close its sheets", "[check]") {
    CHECK(findings_of(shapes::box({0, 0, 0}, {9, 9, 1.0 / 1024})).clean());
}

TEST_CASE("only as many places as asked for are kept, all are counted", "[check]") {
    const MeshCheck check = findings_of(shapes::random_soup(3, 40, 20), {.most_places = 3});
    CHECK(check.of(Fault::boundary_edge).count > 100);
    CHECK(check.of(Fault::boundary_edge).places.size() == 3);
    CHECK(check.of(Fault::crossing_faces).places.size() == 3);
    const MeshCheck none = findings_of(shapes::random_soup(3, 40, 20), {.most_places = 0});
    CHECK(counts(none) == counts(check));
    CHECK(none.of(Fault::boundary_edge).places.empty());
}

TEST_CASE("unusable input and options are refused", "[check]") {
    CHECK(check(MeshView{}).error().code == ErrorCode::empty_mesh);
    Soup soup = box({0, 0, 0}, {1, 1, 1});
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

}  // namespace lamella::check_test
