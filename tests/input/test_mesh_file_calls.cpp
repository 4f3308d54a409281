// A mesh file's unit reaches every call that is made on the file.
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "input/files.hpp"
#include "lamella/io.hpp"

namespace {

/// A tetrahedron of 2 x 2 x 2 units.
constexpr std::string_view off = "OFF\n4 4 0\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
constexpr double inch_mm = 25.4;

lamella::MeshFile in_inches() {
    const TempFolder folder;
    lamella::ReadOptions options;
    options.mm_per_unit = inch_mm;
    auto file = lamella::read_mesh(folder.write("inches.off", std::string(off)), options);
    REQUIRE(file.ok());
    return std::move(file).value();
}

}  // namespace

TEST_CASE("slicing a file in inches gives layers in mm", "[input][unit]") {
    const lamella::MeshFile file = in_inches();
    const auto result = slice(file, uniform(1));
    REQUIRE(result.ok());
    CHECK(result->layers.size() == 51);
    CHECK(result->summary.max_mm[2] == Approx(2 * inch_mm));
    lamella::Workspace workspace;
    lamella::SliceResult again;
    REQUIRE(slice(file, uniform(1), workspace, again).ok());
    CHECK(hash_result(again) == hash_result(*result));
}

TEST_CASE("the unit is applied before the transform", "[input][unit]") {
    lamella::SliceOptions options = uniform(1);
    options.transform.m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 100};
    const auto result = slice(in_inches(), options);
    REQUIRE(result.ok());
    CHECK(result->summary.min_mm[2] == 100);
    CHECK(result->summary.max_mm[2] == Approx(100 + 2 * inch_mm));
}

TEST_CASE("inspecting, checking and welding a file count in mm", "[input][unit]") {
    const lamella::MeshFile file = in_inches();
    const double side = 2 * inch_mm;
    const auto info = inspect(file);
    REQUIRE(info.ok());
    CHECK(info->volume_mm3 == Approx(side * side * side / 6));
    const auto found = check(file);
    REQUIRE(found.ok());
    CHECK(found->info.max_mm[0] == Approx(side));
    const auto apart = weld(file, {.tolerance_mm = side - 1});
    REQUIRE(apart.ok());
    CHECK(apart->joined == 0);
    const auto welded = weld(file, {.tolerance_mm = side + 1});
    REQUIRE(welded.ok());
    CHECK(welded->joined > 0);
    CHECK(welded->mm_per_unit == inch_mm);
    CHECK(welded->tolerance_mm == side + 1);
    const auto sliced_whole = slice(file, uniform(1));
    const auto sliced_welded = slice(*apart, uniform(1));
    REQUIRE((sliced_whole.ok() && sliced_welded.ok()));
    CHECK(hash_result(*sliced_welded) == hash_result(*sliced_whole));
}

TEST_CASE("points and heights of a result are told in mm", "[input][unit]") {
    const auto result = slice(in_inches(), uniform(1, 0x1p-10));
    REQUIRE(result.ok());
    const lamella::Layer& layer = result->layers[3];
    CHECK(result->to_mm(layer.plane) == Approx(layer.plane_mm).margin(2 * 0x1p-10));
    const lamella::Contour& contour = result->contours_of(layer)[0];
    const lamella::Point point = result->points_of(contour)[1];
    CHECK(result->to_mm(point).x == point.x * 0x1p-10);
    CHECK(result->to_mm(point).y == point.y * 0x1p-10);
    const double side = 2 * inch_mm - layer.plane_mm;
    CHECK(result->area_mm2(contour) == Approx(side * side / 2).epsilon(1e-3));
    CHECK(result->area_mm2(layer) == result->area_mm2(contour));
}
