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
    return value_of(lamella::read_mesh(folder.write("inches.off", off), {.mm_per_unit = inch_mm}));
}

}  // namespace

TEST_CASE("slicing a file in inches gives layers in mm, and its transform is in mm", "[input][unit]") {
    const lamella::MeshFile file = in_inches();
    lamella::SliceOptions options = uniform(1);
    const lamella::SliceResult result = sliced(file, options);
    CHECK(result.size() == 51);
    CHECK(result.info.box.max_mm[2] == Approx(2 * inch_mm));
    options.frame.transform.m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 100};
    const lamella::Box box = sliced(file, options).info.box;
    CHECK(box.min_mm[2] == 100);
    CHECK(box.max_mm[2] == Approx(100 + 2 * inch_mm));
}

TEST_CASE("checking and welding a file count in mm", "[input][unit]") {
    const lamella::MeshFile file = in_inches();
    const double side = 2 * inch_mm;
    for (const bool counts_only : {false, true}) {
        const auto found = value_of(check(file.view(), {.counts_only = counts_only}));
        CHECK(found.volume_mm3 == Approx(side * side * side / 6));
        CHECK(found.box.max_mm[0] == Approx(side));
    }
    const auto apart = value_of(weld(file.view(), side - 1));
    CHECK(apart.joined == 0);
    const auto welded = value_of(weld(file.view(), side + 1));
    CHECK(welded.joined > 0);
    CHECK(welded.mm_per_unit == inch_mm);
    CHECK(welded.tolerance_mm == side + 1);
    CHECK(sliced(apart, uniform(1)).hash() == sliced(file, uniform(1)).hash());
}

TEST_CASE("points and heights of a result are told in mm", "[input][unit]") {
    const lamella::SliceResult result = sliced(in_inches(), uniform(1, 0x1p-10));
    const lamella::LayerView layer = result[3];
    CHECK(layer.cut_mm() == Approx(layer.plane_mm).margin(2 * 0x1p-10));
    const lamella::Contour& contour = layer.contours[0];
    const lamella::Point point = layer.points_of(contour)[1];
    CHECK(layer.to_mm(point).x == point.x * 0x1p-10);
    CHECK(layer.to_mm(point).y == point.y * 0x1p-10);
    const double side = 2 * inch_mm - layer.plane_mm;
    CHECK(layer.area_mm2(contour) == Approx(side * side / 2).epsilon(1e-3));
    CHECK(layer.area_mm2() == layer.area_mm2(contour));
}
