// Prints what lamella makes of a mesh file, and what it warns of: answer_lamella FILE
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "lamella/io/mesh_file.hpp"
#include "measure.hpp"

namespace {

sloppy::Point point_at(const lamella::MeshView& view, const std::byte* at) {
    sloppy::Point point{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (view.coordinate_type == lamella::CoordinateType::f64) {
            std::memcpy(&point[axis], at + axis * sizeof(double), sizeof(double));
        } else {
            float value = 0;
            std::memcpy(&value, at + axis * sizeof value, sizeof value);
            point[axis] = value;
        }
    }
    return point;
}

sloppy::Point corner(const lamella::MeshFile& mesh, std::size_t triangle, std::size_t corner) {
    const lamella::MeshView view = mesh.view();
    if (mesh.indices.empty()) {
        const std::size_t number = view.coordinate_type == lamella::CoordinateType::f64 ? sizeof(double) : sizeof(float);
        return point_at(view, view.vertices + triangle * view.stride + corner * 3 * number);
    }
    return point_at(view, view.vertices + mesh.indices.data()[3 * triangle + corner] * view.stride);
}

/// Without the file's path, which differs from machine to machine.
std::string without_path(const std::string& message, const std::filesystem::path& path) {
    return message.starts_with(path.string()) ? message.substr(path.string().size() + 2) : message;
}

}  // namespace

int main(int count, char** words) {
    if (count != 2) {
        return 2;
    }
    const std::filesystem::path path = words[1];
    const auto mesh = lamella::read_mesh(path);
    if (!mesh) {
        std::printf("refused: %s\n", without_path(mesh.error().message, path).c_str());
        return 0;
    }
    sloppy::Measure measure;
    for (std::size_t t = 0; t < mesh->triangle_count; ++t) {
        measure.add(corner(*mesh, t, 0), corner(*mesh, t, 1), corner(*mesh, t, 2));
    }
    std::printf("%s\n", measure.words().c_str());
    for (const std::string& warning : mesh->warnings) {
        std::printf("%s\n", without_path(warning, path).c_str());
    }
    return 0;
}
