// What the diagnosis finds in real meshes.
#include <filesystem>
#include <map>
#include <string>

#include <catch2/catch.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "models_shared/real_meshes.hpp"

namespace {

struct Known {
    const char* file;
    const char* verdict;
    std::size_t shells;
};

lamella::MeshCheck findings_of(const std::filesystem::path& file, int threads) {
    const lamella::Result<lamella::MeshFile> mesh = lamella::read_mesh(file);
    INFO((mesh ? std::string() : mesh.error().message));
    REQUIRE(mesh.ok());
    lamella::CheckOptions options;
    options.control.threads = threads;
    lamella::Result<lamella::MeshCheck> found = check(mesh->view(), options);
    INFO((found ? std::string() : found.error().message));
    REQUIRE(found.ok());
    return std::move(found).value();
}

}  // namespace

TEST_CASE("findings in real meshes are those known", "[check]") {
    const Known known = GENERATE(
        Known{"liver.stl", "closed and clean", 1}, Known{"femur.stl", "closed and clean, with 207 needles, 4 caps", 1},
        Known{"hip_femur.stl", "closed and clean", 1}, Known{"brain.stl", "closed and clean", 2},
        Known{"bones/Left_first_rib.stl", "closed and clean", 1},
        Known{"bones/Fifth_lumbar_vertebra.stl",
              "not clean: 30 boundary edges, 6 boundary loops, 4 crossings of faces, 5 cracks", 1},
        Known{"bones/Frontal_bone.stl",
              "not clean: 268 boundary edges, 60 boundary loops, 9 split vertices, 51 crossings of faces, 28 T-junctions, 7 "
              "cracks",
              2},
        Known{
            "bones/Left_parietal_bone.stl",
            "not clean: 262 boundary edges, 61 boundary loops, 6 split vertices, 51 crossings of faces, 2 touches of faces, "
            "26 T-junctions, 12 cracks",
            1},
        Known{"bones/Right_seventh_rib.stl", "not clean: 4 boundary edges, 1 boundary loop, 2 T-junctions", 1});
    INFO(known.file);
    const lamella::MeshCheck one = findings_of(folder / known.file, 1);
    CHECK(verdict(one) == known.verdict);
    CHECK(one.shells.size() == known.shells);
    CHECK(check_json(one, {}).value() == check_json(findings_of(folder / known.file, 3), {}).value());
}
