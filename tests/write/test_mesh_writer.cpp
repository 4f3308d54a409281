// Meshes that are written come back as they were.
#include <array>
#include <atomic>
#include <cstring>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "lamella/io/mesh_writer.hpp"
#include "temp_folder.hpp"

using namespace lamella;

namespace {

MeshFile read_back(const std::filesystem::path& path) {
    Result<MeshFile> mesh = read_mesh(path);
    INFO((mesh ? "" : mesh.error().message));
    REQUIRE(mesh.ok());
    CHECK(mesh->warnings.empty());
    return std::move(mesh).value();
}

/// A tetrahedron of doubles with a vertex that no float is.
std::string off_of(const std::string& number) {
    return "OFF\n4 4 0\n0 0 0\n" + number + " 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
}

std::vector<double> corners_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    const bool is_double = view.coordinate_type == CoordinateType::f64;
    const std::size_t bytes = is_double ? sizeof(double) : sizeof(float);
    std::vector<double> corners;
    for (std::size_t t = 0; t < view.triangle_count; ++t) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const auto* at =
                static_cast<const std::byte*>(view.vertices) +
                (view.indices == nullptr ? t * view.stride + corner * 3 * bytes : view.vertex_of(t, corner) * view.stride);
            for (std::size_t axis = 0; axis < 3; ++axis, at += bytes) {
                float single = 0;
                double number = 0;
                is_double ? std::memcpy(&number, at, bytes) : std::memcpy(&single, at, bytes);
                corners.push_back(is_double ? number : static_cast<double>(single));
            }
        }
    }
    return corners;
}

}  // namespace

TEST_CASE("a mesh written as PLY keeps its vertices, indices and doubles", "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = read_back(folder.write("a.off", off_of("1.1")));
    const Result<WrittenMesh> written = write_mesh(mesh, folder / "b.PLY");
    REQUIRE(written.ok());
    CHECK_FALSE(written->rounded);
    const MeshFile back = read_back(folder / "b.PLY");
    CHECK(back.coordinate_type == CoordinateType::f64);
    CHECK(back.vertex_count == 4);
    CHECK(std::equal(back.indices.begin(), back.indices.end(), mesh.indices.begin(), mesh.indices.end()));
    CHECK(corners_of(back) == corners_of(mesh));
}

TEST_CASE("a mesh written as STL is one of floats, and says whether that rounded it", "[write][mesh_writer]") {
    const TempFolder folder;
    for (const auto& [number, rounded] : {std::pair<std::string, bool>{"1.5", false}, {"1.1", true}}) {
        const MeshFile mesh = read_back(folder.write("a.off", off_of(number)));
        const Result<WrittenMesh> written = write_mesh(mesh, folder / "b.stl");
        REQUIRE(written.ok());
        CHECK(written->rounded == rounded);
        std::vector<double> expected = corners_of(mesh);
        for (double& each : expected) {
            each = static_cast<double>(static_cast<float>(each));
        }
        CHECK(corners_of(read_back(folder / "b.stl")) == expected);
    }
}

TEST_CASE("soup written as PLY has three vertices a triangle", "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = read_back(folder.write("a.off", off_of("2")));
    REQUIRE(write_mesh(mesh, folder / "soup.stl").ok());
    const MeshFile soup = read_back(folder / "soup.stl");
    REQUIRE(write_mesh(soup, folder / "b.ply").ok());
    const MeshFile back = read_back(folder / "b.ply");
    CHECK(back.vertex_count == 12);
    CHECK(corners_of(back) == corners_of(soup));
}

TEST_CASE("a written mesh states the patient frame of the one read", "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = read_back(folder.write("a.obj", "# SPACE=RAS\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n"));
    REQUIRE(mesh.patient_frame == PatientFrame::ras);
    for (const char* const name : {"b.stl", "b.ply"}) {
        REQUIRE(write_mesh(mesh, folder / name).ok());
        CHECK(read_back(folder / name).patient_frame == PatientFrame::ras);
    }
}

TEST_CASE("a mesh that cannot be written leaves no file", "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = read_back(folder.write("a.off", off_of("1e39")));
    const Error beyond = write_mesh(mesh, folder / "b.stl").error();
    CHECK(beyond.code == ErrorCode::invalid_argument);
    CHECK(beyond.message == "cannot write '" + (folder / "b.stl").string() +
                                "': a coordinate is too large for the floats of STL; PLY takes it");
    CHECK(write_mesh(mesh, folder / "b.obj").error().code == ErrorCode::invalid_argument);
    CHECK(write_mesh(mesh, folder / "none" / "b.ply").error().code == ErrorCode::unwritable_file);
    std::atomic<bool> stop = true;
    CHECK(write_mesh(mesh, folder / "b.ply", {.stop = StopCheck::when(stop)}).error().code == ErrorCode::cancelled);
    CHECK(folder.names() == std::vector<std::string>{"a.off"});
}
