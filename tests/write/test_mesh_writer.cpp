// Meshes that are written come back as they were.
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "input/read.hpp"
#include "lamella/io/mesh_writer.hpp"
#include "temp_folder.hpp"

using namespace lamella;
using input_test::triangles_of;

namespace {

MeshFile read_back(const std::filesystem::path& path) {
    MeshFile mesh = input_test::read_one(path);
    CHECK(mesh.warnings.empty());
    return mesh;
}

/// A tetrahedron of doubles with a vertex that may be no float, in a patient frame.
MeshFile tetrahedron(const TempFolder& folder, const std::string& number) {
    return read_back(folder.write(
        "a.off", "# SPACE=RAS\nOFF\n4 4 0\n0 0 0\n" + number + " 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"));
}

}  // namespace

TEST_CASE("a mesh written as PLY keeps its vertices, indices and doubles, and soup gets three vertices a triangle",
          "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = tetrahedron(folder, "1.1");
    CHECK_FALSE(value_of(write_mesh(mesh, folder / "b.PLY")).rounded);
    const MeshFile back = read_back(folder / "b.PLY");
    CHECK(back.vertex_type == Number::f64);
    CHECK(back.vertex_count == 4);
    CHECK(back.patient_frame == PatientFrame::ras);
    CHECK(std::equal(back.indices.begin(), back.indices.end(), mesh.indices.begin(), mesh.indices.end()));
    CHECK(triangles_of(back) == triangles_of(mesh));
    REQUIRE(write_mesh(mesh, folder / "soup.stl").ok());
    const MeshFile soup = read_back(folder / "soup.stl");
    REQUIRE(write_mesh(soup, folder / "c.ply").ok());
    CHECK(read_back(folder / "c.ply").vertex_count == 12);
    CHECK(triangles_of(read_back(folder / "c.ply")) == triangles_of(soup));
}

TEST_CASE("a mesh written as STL is one of floats, and says whether that rounded it", "[write][mesh_writer]") {
    const TempFolder folder;
    const std::string number = GENERATE("1.5", "1.1");
    const MeshFile mesh = tetrahedron(folder, number);
    CHECK(value_of(write_mesh(mesh, folder / "b.stl")).rounded == (number == "1.1"));
    input_test::Triangles expected = triangles_of(mesh);
    for (auto& triangle : expected) {
        for (double& coordinate : triangle) {
            coordinate = static_cast<double>(static_cast<float>(coordinate));
        }
    }
    CHECK(triangles_of(read_back(folder / "b.stl")) == expected);
    CHECK(read_back(folder / "b.stl").patient_frame == PatientFrame::ras);
}

TEST_CASE("a mesh that cannot be written leaves no file", "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = tetrahedron(folder, "1e39");
    const Error beyond = write_mesh(mesh, folder / "b.stl").error();
    CHECK(beyond.code == ErrorCode::invalid_argument);
    CHECK(beyond.message == "cannot write '" + (folder / "b.stl").string() +
                                "': a coordinate is too large for the floats of STL; PLY takes it");
    CHECK(write_mesh(mesh, folder / "b.obj").error().code == ErrorCode::invalid_argument);
    CHECK(write_mesh(mesh, folder / "none" / "b.ply").error().code == ErrorCode::unwritable_file);
    auto stop = []() noexcept { return true; };
    CHECK(write_mesh(mesh, folder / "b.ply", {.stop = stop}).error().code == ErrorCode::cancelled);
    CHECK(folder.names() == std::vector<std::string>{"a.off"});
}
