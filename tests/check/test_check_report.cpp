// The report and the marks.
#include <array>
#include <cstdio>
#include <sstream>

#include <nlohmann/json.hpp>

#include "check/findings.hpp"
#include "temp_folder.hpp"

namespace lamella::check_test {

TEST_CASE("the report holds every kind, its count and its first places", "[check]") {
    const MeshCheck check = findings_of(without(shapes::box({0, 0, 0}, {2, 2, 2}), 2, 2));
    const std::vector<std::string> lines = {"w"};
    const ReportMember warnings{.key = "warnings", .value = std::span<const std::string>(lines)};
    const ReportParts parts{.mesh_name = "a\xff.stl", .members = {&warnings, 1}};
    const auto json = nlohmann::json::parse(make_check_json(check, parts, 3).value());
    CHECK(json["mesh"] == "a\\xff.stl");
    CHECK(json["warnings"][0] == "w");
    CHECK(json["triangles"] == 10);
    CHECK(json["clean"] == false);
    CHECK(json["verdict"] == "not clean: 4 boundary edges, 1 boundary loop");
    CHECK(json["findings"].size() == fault_count);
    for (const auto& [key, finding] : json["findings"].items()) {
        CHECK(finding["at_least"] == false);
        CHECK(finding["count"] == (key == "boundary_edges" ? 4 : key == "boundary_loops" ? 1 : 0));
    }
    CHECK(json["findings"]["boundary_edges"]["places"].size() == 3);
    const auto& loop = json["findings"]["boundary_loops"]["places"][0];
    CHECK(loop["edges"] == 4);
    CHECK(loop["length_mm"] == 8.0);
    CHECK(loop["closed"] == true);
    CHECK(loop["points_mm"] == nlohmann::json({{0.0, 0.0, 2.0}}));
    CHECK(json["shells"]["count"] == 1);
    CHECK(json["shells"]["first"][0]["volume_mm3"].is_null());
    CHECK_FALSE(json.contains("file"));
    const MeshFile file;
    CHECK(nlohmann::json::parse(make_check_json(check, {.file = &file}).value())["file"]["mm_per_unit"] == 1.0);
}

TEST_CASE("a finding cut short is reported as at least so many", "[check]") {
    MeshCheck check;
    check.findings[static_cast<std::size_t>(Fault::crossing_faces)] = {.count = 7, .at_least = true, .places = {}};
    CHECK(make_verdict(check).value() == "not clean: at least 7 crossings of faces, as far as was searched");
}

TEST_CASE("marks are an ASCII PLY of points and edges", "[check]") {
    const Soup cube = shapes::box({0, 0, 0}, {1, 1, 1});
    const MeshCheck check = findings_of(shapes::joined({cube, only(cube, 5, 1), shapes::moved(cube, {1, 1, 1})}));
    const TempFolder folder;
    REQUIRE(write_marks(check, folder / "marks.ply").ok());
    std::istringstream ply(bytes_of(folder / "marks.ply"));
    // Three edges, four vertices and the duplicate face's three corners; four edges each of two points, and three.
    std::string line;
    std::size_t points = 0;
    std::size_t edges = 0;
    REQUIRE(std::getline(ply, line));
    CHECK(line == "ply");
    while (std::getline(ply, line) && line != "end_header") {
        (void)std::sscanf(line.c_str(), "element vertex %zu", &points);
        (void)std::sscanf(line.c_str(), "element edge %zu", &edges);
    }
    CHECK(points == 3 * 2 + 4 + 3);
    CHECK(edges == 3 + 3);
    for (std::size_t i = 0; i < points; ++i) {
        std::array<double, 6> row{-1, -1, -1, -1, -1, -1};
        for (double& number : row) {
            ply >> number;
        }
        const auto [x, y, z, red, green, blue] = row;
        CHECK((x >= 0 && x <= 2 && y >= 0 && z >= 0 && z <= 2));
        CHECK((red >= 0 && red < 256 && green >= 0 && blue >= 0 && blue < 256));
    }
    for (std::size_t i = 0; i < edges; ++i) {
        std::size_t from = points;
        std::size_t to = points;
        int colour = -1;
        ply >> from >> to >> colour >> colour >> colour;
        CHECK((from < points && to < points && from != to));
    }
    CHECK(ply.good());
    ply >> line;
    CHECK(ply.eof());
}

TEST_CASE("marks that cannot be written are an error that names the file", "[check]") {
    const Status status = write_marks(MeshCheck{}, "no/such/folder/marks.ply");
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().code == ErrorCode::unwritable_file);
    CHECK_THAT(status.error().message, Catch::Contains("marks.ply"));
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
