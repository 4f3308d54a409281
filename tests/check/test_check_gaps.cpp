// T-junctions and cracks.
#include "check/findings.hpp"

namespace lamella::check_test {

using shapes::joined;
using shapes::triangle;

TEST_CASE("a T-junction without width is found", "[check]") {
    // The top of a box, one of its triangles split at the middle of an edge to a side that is not.
    const Soup cube = shapes::box({0, 0, 0}, {2, 2, 2});
    const Soup split =
        joined({without(cube, 2, 1), triangle({0, 0, 2}, {1, 0, 2}, {2, 2, 2}), triangle({1, 0, 2}, {2, 0, 2}, {2, 2, 2})});
    CheckOptions exact;
    exact.tolerance_mm = 0;
    for (const CheckOptions& options : {CheckOptions{}, exact}) {
        const MeshCheck check = findings_of(split, options);
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
    CheckOptions options;
    options.tolerance_mm = width;
    const MeshCheck wide = findings_of(joined({left, right}), options);
    CHECK(wide.of(Fault::crack).count == 2);
    CHECK(first(wide, Fault::crack).measure == width);
    CHECK(first(wide, Fault::crack).points_mm[0] == Xyz{1, 0, 0});
    CHECK(first(wide, Fault::crack).points_mm[1] == Xyz{1 + width, 0, 0});
    CHECK(wide.of(Fault::t_junction).count == 1);
    CHECK(first(wide, Fault::t_junction).measure == width);
    CHECK(first(wide, Fault::t_junction).points_mm[0] == Xyz{1 + width, 1, 0});
    CHECK(first(wide, Fault::t_junction).points_mm[1] == Xyz{1, 1, 0});
    CHECK(wide.of(Fault::touching_faces).count == 0);
    options.tolerance_mm = 0.99 * width;
    const MeshCheck narrow = findings_of(joined({left, right}), options);
    CHECK(narrow.of(Fault::crack).count == 0);
    CHECK(narrow.of(Fault::t_junction).count == 0);
}

TEST_CASE("the ends of a short edge are no crack", "[check]") {
    CheckOptions options;
    options.tolerance_mm = 1;
    const MeshCheck check = findings_of(triangle({0, 0, 0}, {0.5, 0, 0}, {0, 9, 0}), options);
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
    CheckOptions options;
    options.tolerance_mm = 1e300;
    const MeshCheck check =
        findings_of(joined({triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), triangle({5, 5, 5}, {6, 5, 5}, {5, 6, 5})}), options);
    CHECK(check.of(Fault::crack).count == 9);
    CHECK(check.of(Fault::t_junction).count == 0);
}

TEST_CASE("a closed mesh has no gaps, however close its sheets", "[check]") {
    CHECK(findings_of(shapes::box({0, 0, 0}, {9, 9, 1.0 / 1024})).clean());
}

}  // namespace lamella::check_test
