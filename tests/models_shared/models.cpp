// Real meshes and their known answers.
#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "models_shared/real_meshes.hpp"

using lamella::SliceResult;

namespace {

lamella::MeshFile mesh_of(const std::filesystem::path& file) {
    lamella::Result<lamella::MeshFile> mesh = lamella::read_mesh(file);
    INFO((mesh ? std::string() : mesh.error().message));
    REQUIRE(mesh.ok());
    return std::move(mesh).value();
}

SliceResult sliced(const lamella::MeshFile& mesh, const lamella::SliceOptions& options) {
    lamella::Result<SliceResult> result = slice(mesh.view(), options);
    INFO((result ? std::string() : result.error().message));
    REQUIRE(result.ok());
    const lamella::Status valid = validate(*result);
    INFO((valid ? std::string() : valid.error().message));
    REQUIRE(valid.ok());
    return std::move(result).value();
}

lamella::SliceOptions at_layer_height(double mm) {
    lamella::SliceOptions options;
    options.plan.spacing = lamella::UniformLayers{mm};
    return options;
}

struct KnownAnswer {
    const char* file;
    std::uint64_t kept;
    std::size_t planes;
    std::uint64_t segments;
    std::size_t contours;
    std::uint64_t holes;
};

}  // namespace

TEST_CASE("counts are those of the paper's program and its table", "[counts]") {
    const KnownAnswer known = GENERATE(KnownAnswer{"liver.stl", 38'142, 6'242, 2'342'005, 15'790, 9'490},
                                       KnownAnswer{"femur.stl", 42'110, 3'155, 1'180'826, 3'338, 30});
    const lamella::MeshFile mesh = mesh_of(folder / known.file);
    lamella::SliceOptions options = at_layer_height(0.032);
    std::get<lamella::UniformLayers>(options.plan.spacing).first_height_mm = 0.008;
    options.unit_mm = 0.004;
    const auto form = GENERATE(lamella::ContourForm::swept, lamella::ContourForm::assembled);
    options.tuning.form = form;
    const SliceResult result = sliced(mesh, options);
    INFO(known.file);
    CHECK(result.summary.triangles - result.summary.degenerate == known.kept);
    CHECK(result.layers.size() == known.planes);
    CHECK(result.summary.segments == known.segments);
    CHECK(result.contours.size() == known.contours);
    CHECK(result.summary.holes == known.holes);
    CHECK(result.summary.open_contours == 0);
}

TEST_CASE("areas times layer height are the volume of closed meshes", "[volume]") {
    const char* file = GENERATE("liver.stl", "femur.stl", "brain.stl", "hip_femur.stl");
    const lamella::MeshFile mesh = mesh_of(folder / file);
    const lamella::Result<lamella::MeshInfo> info = inspect(mesh.view());
    REQUIRE(info.ok());
    INFO(file);
    CHECK(info->closed);
    const SliceResult result = sliced(mesh, at_layer_height(0.032));
    CHECK(result.summary.open_contours == 0);
    double volume = 0;
    for (const lamella::Layer& layer : result.layers) {
        volume += result.area_mm2(layer) * 0.032;
    }
    CHECK(std::abs(volume - info->volume_mm3) < 1e-5 * std::abs(info->volume_mm3));
}

TEST_CASE("bones with boundary edges slice, their open polylines flagged", "[open]") {
    std::size_t bones = 0;
    std::size_t with_open = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "bones")) {
        if (entry.path().extension() != ".stl") {
            continue;
        }
        const lamella::MeshFile mesh = mesh_of(entry.path());
        const lamella::Result<lamella::MeshInfo> info = inspect(mesh.view());
        REQUIRE(info.ok());
        INFO(entry.path());
        const SliceResult result = sliced(mesh, at_layer_height(0.032));
        // A closed mesh never has open contours; one with boundary edges as tall as a layer has some.
        CHECK((result.summary.open_contours == 0 || info->boundary_edges > 0));
        ++bones;
        with_open += result.summary.open_contours > 0 ? 1 : 0;
    }
    CHECK(bones == 8);
    CHECK(with_open == 7);
}
