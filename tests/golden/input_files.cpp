#include "golden/inputs.hpp"
#include "input/mesh_files.hpp"

namespace golden {

using lamella::models::Random;

namespace {

/// A closed body, a sheet of bent quads, and an L of six corners.
lamella::input_test::PolygonMesh polygons_of_all_kinds() {
    lamella::input_test::PolygonMesh polygons = lamella::input_test::mesh_of(mesh("voxel body"));
    constexpr std::int64_t side = 40;
    Random random(21);
    const auto first = static_cast<std::int64_t>(polygons.points());
    for (std::int64_t i = 0; i < side * side; ++i) {
        polygons.xyz.insert(polygons.xyz.end(), {double(i % side), double(i / side), between(random, -99, 99) / 64.0});
    }
    for (std::int64_t i = first; i + side + 1 < first + side * side; ++i) {
        if ((i - first) % side + 1 < side) {
            polygons.faces.push_back({i, i + 1, i + side + 1, i + side});
        }
    }
    const auto corner = static_cast<std::int64_t>(polygons.points());
    polygons.xyz.insert(polygons.xyz.end(), {0, 0, 50, 9, 0, 50, 9, 3, 50, 3, 3, 50, 3, 9, 50, 0, 9, 50});
    polygons.faces.push_back({corner, corner + 1, corner + 2, corner + 3, corner + 4, corner + 5});
    return polygons;
}

}  // namespace

std::map<std::string, std::string> mesh_files() {
    using namespace lamella::input_test;
    const std::string mirrored = "transform=\"0 1 0 1 0 0 0 0 0.5 3 4 -2\"";  // and turned and moved
    const Soup body = mesh("voxel body");
    const PolygonMesh polygons = polygons_of_all_kinds();
    // Stored, not deflated, since the bytes that zlib makes differ between its versions.
    std::vector<ZipPart> parts =
        package_parts(model_text(object(1, mesh_xml(mesh_of(body))), item(1) + item(1, mirrored), "unit=\"inch\""));
    for (ZipPart& part : parts) {
        part.deflated = false;
    }
    return {{"binary.stl", binary_stl(body, {.header = std::string(80, ' '), .normal = '\0'})},
            {"text.stl", text_stl(body, "body")},
            {"polygons.obj", obj(polygons)},
            {"polygons.off", off(polygons)},
            {"text.ply", Ply{.coordinate = "double", .comment = "unit mm"}(polygons)},
            {"little.ply", Ply{.encoding = "binary_little_endian", .comment = "unit mm"}(polygons)},
            {"text.vtk", Vtk{.title = "body"}(polygons)},
            {"text.vtp", Vtp{.decoys = false}({polygons})},
            {"bodies.3mf", zip(parts)}};
}

}  // namespace golden
