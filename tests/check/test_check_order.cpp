// The findings do not depend on the order of triangles and vertices, and the numbers that they give are those of the input.
#include <algorithm>

#include "check/findings.hpp"

namespace lamella::check_test {

namespace {

/// Meshes with faults of every kind that random corners bring about.
Soup faulty(std::uint64_t seed) {
    return shapes::joined({shapes::random_soup(seed, 60, 4), shapes::random_tetrahedra(seed, 25, 9),
                           shapes::moved(shapes::random_tetrahedra(seed + 1, 10, 3), {40, 0, 0}),
                           shapes::box({-1, -1, -1}, {100, 100, 100})});
}

bool has_corner(const Soup& soup, std::int64_t triangle, const Xyz& point) {
    for (std::size_t i = 0; i < 3; ++i) {
        const double* const at = soup.data() + 9 * triangle + 3 * i;
        if (Xyz{at[0], at[1], at[2]} == point) {
            return true;
        }
    }
    return false;
}

/// The report without the numbers of triangles, which alone may depend on the order of the input.
std::string text_without_triangles(MeshCheck check) {
    for (FaultFinding& finding : check.findings) {
        for (FaultPlace& place : finding.places) {
            place.triangles = {-1, -1};
        }
    }
    for (MeshShell& shell : check.shells) {
        shell.triangle = -1;
    }
    return make_check_json(check, {}, 1000).value();
}

}  // namespace

TEST_CASE("the report is the same in any order", "[check]") {
    const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 13)));
    const Soup soup = faulty(seed);
    const CheckOptions options{.tolerance_mm = 1, .most_places = 25};
    const std::string one = text_without_triangles(findings_of(soup, options));
    for (std::uint64_t order = 0; order < 3; ++order) {
        CHECK(text_without_triangles(findings_of(shapes::shuffled(soup, order), options)) == one);
    }
}

TEST_CASE("indexed meshes and soup give the same report", "[check]") {
    const Soup soup = faulty(5);
    const shapes::Indexed mesh = shapes::indexed(soup);
    const Result<MeshCheck> found = check(mesh.view());
    REQUIRE(found.ok());
    CHECK(make_check_json(found.value(), {}, 1000).value() == make_check_json(findings_of(soup), {}, 1000).value());
}

TEST_CASE("counts agree with the census", "[check]") {
    const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 9)));
    const Soup soup = faulty(seed);
    const MeshCheck found = findings_of(soup);
    const MeshCheck counted =
        check(MeshView::soup(std::span<const double>(soup)), {.counts_only = true}, {.threads = 2}).value();
    CHECK(counts(counted).empty());
    for (const auto count :
         {&MeshCheck::degenerate, &MeshCheck::edges, &MeshCheck::boundary_edges, &MeshCheck::exact_boundary_edges,
          &MeshCheck::overfull_edges, &MeshCheck::mismatched_edges, &MeshCheck::shell_count}) {
        CHECK(counted.*count == found.*count);
    }
    CHECK(counted.closed == found.closed);
    CHECK(counted.box == found.box);
    CHECK(counted.volume_mm3 == found.volume_mm3);
}

TEST_CASE("places name triangles of the input", "[check]") {
    const Soup soup = shapes::shuffled(faulty(7), 1);
    const MeshCheck check = findings_of(soup, {.most_places = 1000});
    std::size_t seen = 0;
    for (const Fault fault :
         {Fault::boundary_edge, Fault::overfull_balanced, Fault::overfull_unbalanced, Fault::mismatched_edge,
          Fault::split_vertex, Fault::flipped_face, Fault::duplicate_face, Fault::opposite_face, Fault::collapsed_face,
          Fault::zero_area_face, Fault::misoriented_shell}) {
        for (const FaultPlace& place : check.of(fault).places) {
            for (int i = 0; i < place.point_count; ++i) {
                CHECK(has_corner(soup, place.triangles[0], place.points_mm[static_cast<std::size_t>(i)]));
            }
            ++seen;
        }
    }
    CHECK(seen > 100);
}

TEST_CASE("a transform moves the places with the mesh", "[check]") {
    const Soup soup = without(shapes::box({0, 0, 0}, {2, 2, 2}), 2, 2);
    const MeshCheck check = findings_of(soup, {.frame = {.transform = Transform::scale(10)}});
    CHECK(first(check, Fault::boundary_edge).points_mm[0] == Xyz{0, 0, 20});
    CHECK(first(check, Fault::boundary_loop).measure == 80);
}

}  // namespace lamella::check_test
