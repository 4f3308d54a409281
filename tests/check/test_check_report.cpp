// The report and the marks, and that they do not depend on the order of triangles and vertices. Their bytes: tests/golden;
// files that cannot be written: tests/cli.
#include <map>

#include <nlohmann/json.hpp>

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
    const double* const at = soup.data() + 9 * triangle;
    return point == Xyz{at[0], at[1], at[2]} || point == Xyz{at[3], at[4], at[5]} || point == Xyz{at[6], at[7], at[8]};
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

TEST_CASE("the report is the same in any order, and its counts are those of the census", "[check]") {
    const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 13)));
    const Soup soup = faulty(seed);
    const CheckOptions options{.tolerance_mm = 1, .most_places = 25};
    const MeshCheck found = findings_of(soup, options);
    for (std::uint64_t order = 0; order < 3; ++order) {
        CHECK(text_without_triangles(findings_of(shapes::shuffled(soup, order), options)) == text_without_triangles(found));
    }
    const shapes::Indexed mesh = shapes::indexed(soup);
    CHECK(make_check_json(check(mesh.view(), options).value(), {}, 1000).value() ==
          make_check_json(found, {}, 1000).value());
    const MeshCheck counted = check(mesh.view(), {.counts_only = true}, {.threads = 2}).value();
    CHECK(std::all_of(counted.findings.begin(), counted.findings.end(), [](const auto& each) { return each.count == 0; }));
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

TEST_CASE("the report holds every kind, its count and its first places", "[check]") {
    const MeshCheck check = findings_of(without(shapes::box({0, 0, 0}, {2, 2, 2}), 2, 2));
    const std::vector<std::string> lines = {"w"};
    const ReportMember warnings{.key = "warnings", .value = std::span<const std::string>(lines)};
    const MeshFile file;
    const ReportParts parts{.mesh_name = "a\xff.stl", .file = &file, .members = {&warnings, 1}};
    const auto json = nlohmann::json::parse(make_check_json(check, parts, 3).value());
    CHECK(json["mesh"] == "a\\xff.stl");
    CHECK(json["warnings"][0] == "w");
    CHECK(json["verdict"] == "not clean: 4 boundary edges, 1 boundary loop");
    CHECK(json["file"]["mm_per_unit"] == 1.0);
    CHECK(json["findings"].size() == fault_count);
    CHECK(json["findings"]["boundary_edges"]["places"].size() == 3);
    CHECK(json["findings"]["boundary_loops"].dump() ==
          R"({"at_least":false,"count":1,"places":[{"closed":true,"edges":4,"length_mm":8.0,)"
          R"("points_mm":[[0.0,0.0,2.0]],"triangles":[3]}]})");
    CHECK(json["shells"]["count"] == 1);
    CHECK(json["shells"]["first"][0]["volume_mm3"].is_null());
    CHECK_FALSE(nlohmann::json::parse(make_check_json(check, {}).value()).contains("file"));
}

TEST_CASE("a finding cut short is reported as at least so many", "[check]") {
    MeshCheck check;
    check.findings[static_cast<std::size_t>(Fault::crossing_faces)] = {.count = 7, .at_least = true, .places = {}};
    CHECK(make_verdict(check).value() == "not clean: at least 7 crossings of faces, as far as was searched");
    CHECK(make_verdict(findings_of(shapes::box({0, 0, 0}, {1, 1, 200}))).value() == "closed and clean, with 8 needles");
}

TEST_CASE("keys and words of faults are distinct", "[check]") {
    std::map<std::string_view, int> seen;
    for (std::size_t i = 0; i < fault_count; ++i) {
        ++seen[key_of(static_cast<Fault>(i))];
        CHECK(words_for(static_cast<Fault>(i), 1) != words_for(static_cast<Fault>(i), 2));
    }
    CHECK(seen.size() == fault_count);
}

}  // namespace lamella::check_test
