// Real meshes: known answers, findings, and what must hold whatever the mesh.
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/io.hpp"
#include "models_shared/real_meshes.hpp"
#include "oracle/oracle.hpp"

using namespace lamella;

namespace {

MeshFile mesh_of(const std::filesystem::path& file) {
    return value_of(read_mesh(file));
}

MeshCheck findings_of(const std::filesystem::path& file, int threads) {
    return value_of(check(mesh_of(file).view(), {}, {.threads = threads}));
}

/// Corners moved by up to `mm`, equal ones alike.
shapes::Soup roughened(shapes::Soup soup, double mm) {
    for (double& coordinate : soup) {
        coordinate += mm * std::sin(coordinate * 7919);
    }
    return soup;
}

std::uint64_t crossings_in(const SliceResult& result) {
    return value_of(audits::crossings_of(result)).count;
}

TEST_CASE("counts equal those of the paper's program and its table", "[counts]") {
    using Count = std::uint64_t;
    const auto [file, kept, planes, segments, contours, holes] =
        GENERATE(table<const char*, Count, Count, Count, Count, Count>(
            {{"liver.stl", 38'142, 6'242, 2'342'005, 15'790, 9'490}, {"femur.stl", 42'110, 3'155, 1'180'826, 3'338, 30}}));
    const MeshFile mesh = mesh_of(folder / file);
    const SliceOptions options{.layer_height_mm = 0.032, .planes = {.first_height_mm = 0.008}, .frame = {.grid_mm = 0.004}};
    const auto form = GENERATE(ContourForm::swept, ContourForm::assembled);
    const SliceResult result = sliced(mesh, options, {}, {.form = form});
    INFO(file);
    CHECK(result.info.triangles - result.info.degenerate == kept);
    CHECK(result.layers.size() == planes);
    CHECK(result.info.segments == segments);
    CHECK(result.contours.size() == contours);
    CHECK(result.info.holes == holes);
    CHECK(result.info.open_contours == 0);
}

TEST_CASE("areas times layer height give the volume of closed meshes", "[volume]") {
    const char* file = GENERATE("liver.stl", "femur.stl", "brain.stl", "hip_femur.stl");
    const MeshFile mesh = mesh_of(folder / file);
    const MeshCheck info = value_of(check(mesh.view(), {.counts_only = true}));
    INFO(file);
    CHECK(info.closed);
    const SliceResult result = sliced(mesh, uniform(0.032));
    CHECK(result.info.open_contours == 0);
    double volume = 0;
    for (const LayerView layer : result) {
        volume += layer.area_mm2() * 0.032;
    }
    CHECK(std::abs(volume - info.volume_mm3) < 1e-5 * std::abs(info.volume_mm3));
}

TEST_CASE("bones with boundary edges slice, with their open polylines flagged", "[open]") {
    std::size_t bones = 0;
    std::size_t with_open = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "bones")) {
        if (entry.path().extension() != ".stl") {
            continue;
        }
        const MeshFile mesh = mesh_of(entry.path());
        const MeshCheck info = value_of(check(mesh.view(), {.counts_only = true}));
        INFO(entry.path());
        const SliceResult result = sliced(mesh, uniform(0.032));
        // A closed mesh never has open contours. A mesh with boundary edges as tall as a layer has some.
        CHECK((result.info.open_contours == 0 || info.boundary_edges > 0));
        ++bones;
        with_open += result.info.open_contours > 0 ? 1 : 0;
    }
    CHECK(bones == 8);
    CHECK(with_open == 7);
}

TEST_CASE("check() finds the known faults of real meshes", "[check]") {
    const auto [file, verdict, shells] = GENERATE(table<const char*, const char*, std::size_t>(
        {{"liver.stl", "closed and clean", 1},
         {"femur.stl", "closed and clean, with 207 needles, 4 caps", 1},
         {"hip_femur.stl", "closed and clean", 1},
         {"brain.stl", "closed and clean", 2},
         {"bones/Left_first_rib.stl", "closed and clean", 1},
         {"bones/Fifth_lumbar_vertebra.stl",
          "not clean: 30 boundary edges, 6 boundary loops, 4 crossings of faces, 5 cracks", 1},
         {"bones/Frontal_bone.stl",
          "not clean: 268 boundary edges, 60 boundary loops, 9 split vertices, 51 crossings of faces, 28 T-junctions, 7 "
          "cracks",
          2},
         {"bones/Left_parietal_bone.stl",
          "not clean: 262 boundary edges, 61 boundary loops, 6 split vertices, 51 crossings of faces, 2 touches of faces, "
          "26 T-junctions, 12 cracks",
          1},
         {"bones/Right_seventh_rib.stl", "not clean: 4 boundary edges, 1 boundary loop, 2 T-junctions", 1}}));
    INFO(file);
    const MeshCheck one = findings_of(folder / file, 1);
    CHECK(make_verdict(one).value() == verdict);
    CHECK(one.shells.size() == shells);
    CHECK(make_check_json(one, {}).value() == make_check_json(findings_of(folder / file, 3), {}).value());
}

/// The pairs of a triangle and a plane between its vertices.
std::uint64_t crossings(const SliceResult& result, const shapes::Soup& soup) {
    const auto planes_below = [&](std::int32_t z) {
        return std::partition_point(result.layers.begin(), result.layers.end(),
                                    [z](const Layer& layer) { return layer.plane.z() < z; }) -
               result.layers.begin();
    };
    std::uint64_t found = 0;
    for (const oracle::Triangle& t : oracle::quantise(soup, result.info.grid_mm)) {
        const auto [low, high] = std::minmax({t[0].z, t[1].z, t[2].z});
        found += static_cast<std::uint64_t>(planes_below(high) - planes_below(low));
    }
    return found;
}

TEST_CASE("planes at the heights of all vertices lose no triangle of real meshes", "[vertex_heights]") {
    for (const std::filesystem::path& file : real_meshes()) {
        const shapes::Soup soup = soup_of(file);
        const MeshCheck info = *check(view_of(soup), {.counts_only = true});
        std::uint64_t open = 0;
        const std::vector<double> heights = oracle::vertex_heights(soup, info.grid_mm);  // thousands on whole millimetres
        for (std::size_t first = 0; first < heights.size(); first += 2000) {             // planes in one slice
            for (const PlaneSide side : {PlaneSide::below, PlaneSide::above}) {
                SliceOptions options;
                options.heights_mm.emplace(
                    heights.begin() + static_cast<std::ptrdiff_t>(first),
                    heights.begin() + static_cast<std::ptrdiff_t>(std::min(heights.size(), first + 2000)));
                options.planes.side = side;
                const SliceResult result = sliced(soup, options);
                INFO(file << ", from " << heights[first] << " mm, above " << (side == PlaneSide::above));
                CHECK(result.info.segments == crossings(result, soup));
                open += result.info.open_contours;
            }
        }
        INFO(file);
        CHECK((!info.closed || open == 0));
    }
}

TEST_CASE("closing agrees with closing everything on layers of real meshes", "[closing]") {
    const double radius_mm = GENERATE(0.049, 0.4);
    double worst = 0;
    for (const std::filesystem::path& file : real_meshes()) {
        const SliceResult result = sliced(soup_of(file), uniform(6));
        RegionRules rules{.fill_rule = FillRule::non_zero};
        for (const LayerView layer : result) {
            const regions::Polygons rings = regions::rings_of(layer);
            if (rings.empty()) {
                continue;
            }
            INFO(file << " at " << layer.plane_mm << " mm, radius " << radius_mm << " mm");
            rules.closing_mm = 0;
            const auto plain = regions::region(rings, rules, result.info.grid_mm);
            rules.closing_mm = radius_mm;
            const auto made = regions::region(rings, rules, result.info.grid_mm);
            const auto everywhere = regions::closed_everywhere(rings, rules, result.info.grid_mm);
            REQUIRE((plain.ok() && made.ok() && everywhere.ok()));
            CHECK(regions::broken_promise(*made) == "");
            const double difference = regions::difference_of(*made, *everywhere) * result.info.grid_mm;
            const double perimeter = regions::perimeter_of(regions::rings_of(*plain));
            CHECK(difference <= 5e-6 * perimeter);
            worst = std::max(worst, difference / perimeter);
        }
    }
    INFO("at most " << worst << " mm times the perimeter");
    CHECK(worst > 0);
}

TEST_CASE("simplified layers of real meshes are valid and cross no more", "[simplify]") {
    std::size_t before = 0;
    std::size_t after = 0;
    for (const std::filesystem::path& file : real_meshes()) {
        const shapes::Soup soup = soup_of(file);
        for (const double rough_mm : {0.0, 0.3}) {
            const shapes::Soup rough = roughened(soup, rough_mm);
            for (const FillRule rule : {FillRule::contours, FillRule::non_zero}) {
                SliceOptions options{.layer_height_mm = 3, .origins = true, .region = {.fill_rule = rule}};
                const SliceResult plain = sliced(rough, options);
                for (const double tolerance_mm : {0.02, 1.0}) {
                    INFO(file << ", rough by " << rough_mm << " mm, " << name_of(rule) << ", within " << tolerance_mm);
                    options.region.simplify_mm = tolerance_mm;
                    const SliceResult simplified = sliced(rough, options);
                    require_ok(audits::structure_of(simplified, view_of(rough)));
                    REQUIRE(simplified.contours.size() == plain.contours.size());
                    REQUIRE(crossings_in(simplified) <= crossings_in(plain));
                    before += plain.points.size();
                    after += simplified.points.size();
                }
            }
        }
    }
    CHECK(after < before / 2);
}

}  // namespace
