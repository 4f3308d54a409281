// Prints what lamella makes of a mesh file, and what it warns of: answer_lamella FILE. Of a mesh: how many triangles, and
// nine coordinates for each.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "lamella/io/mesh_file.hpp"

namespace {

std::array<double, 3> corner(const lamella::MeshView& view, std::size_t triangle, std::size_t corner) {
    const bool soup = view.indices == nullptr;
    const std::byte* const at = soup ? view.vertex_at(triangle) + corner * 3 * lamella::size_of(view.vertex_type)
                                     : view.vertex_at(view.vertex_of(triangle, corner));
    std::array<double, 3> point{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (view.vertex_type == lamella::Number::f64) {
            std::memcpy(&point[axis], at + axis * sizeof(double), sizeof(double));
        } else {
            float value = 0;
            std::memcpy(&value, at + axis * sizeof value, sizeof value);
            point[axis] = value;
        }
    }
    return point;
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
    const lamella::MeshView view = mesh->view();
    std::printf("%zu triangles\n", static_cast<std::size_t>(mesh->triangle_count));
    for (std::size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const auto [x, y, z] = corner(view, i / 3, i % 3);
        std::printf("%.17g %.17g %.17g%c", x, y, z, i % 3 == 2 ? '\n' : ' ');
    }
    for (const std::string& warning : mesh->warnings) {
        std::printf("%s\n", without_path(warning, path).c_str());
    }
    return 0;
}
