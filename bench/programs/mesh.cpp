#include "mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <system_error>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/io/mesh_file.hpp"
#include "timing.hpp"

namespace lamella::bench {

namespace {

struct Corner {
    float x, y, z;
};

std::vector<Corner> ring(double x, double y, double z, double radius, std::uint32_t sides) {
    std::vector<Corner> corners;
    for (std::uint32_t i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides;
        corners.push_back({static_cast<float>(x + radius * std::cos(angle)),
                           static_cast<float>(y + radius * std::sin(angle)), static_cast<float>(z)});
    }
    return corners;
}

}  // namespace

void Mesh::measure() noexcept {
    low_mm = high_mm = soup.empty() ? 0 : static_cast<double>(soup[2]);
    rise_mm = 0;
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        const auto [low, high] = std::minmax({soup[t + 2], soup[t + 5], soup[t + 8]});
        low_mm = std::min(low_mm, static_cast<double>(low));
        high_mm = std::max(high_mm, static_cast<double>(high));
        rise_mm += static_cast<double>(high) - static_cast<double>(low);
    }
}

Mesh load_mesh(const std::filesystem::path& file) {
    const MeshFile stl = checked(read_mesh(file));
    Mesh mesh;
    mesh.file = file;
    mesh.soup.resize_discarding(9 * stl.triangle_count);
    const MeshView view = stl.view();
    Parallel().run_ranges(stl.triangle_count, 1 << 14, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t t = begin; t < end; ++t) {
            std::memcpy(mesh.soup.data() + 9 * t, view.vertex_at(t), 9 * sizeof(float));
        }
    });
    mesh.measure();
    return mesh;
}

std::filesystem::path cached_mesh(const models::Recipe& recipe, const std::filesystem::path& cache) {
    std::error_code ignored;
    std::filesystem::create_directories(cache, ignored);
    std::string name = std::string(models::shape_names[static_cast<std::size_t>(recipe.shape)]) + "-" +
                       std::to_string(recipe.triangles) + "-" + std::to_string(std::llround(recipe.height_mm)) + "mm";
    if (recipe.segments) {
        name += "-m" + std::to_string(*recipe.segments) + "-" + std::to_string(std::llround(recipe.layer_height_mm * 1000)) +
                "um";
    }
    const std::filesystem::path file = cache / (name + (recipe.order == models::Order::random ? "-random.stl" : ".stl"));
    if (!std::filesystem::exists(file, ignored)) {
        checked(models::write_stl(recipe, file));
    }
    return file;
}

Mesh make_columns(std::uint32_t count, std::uint32_t sides, double height_mm) {
    Mesh mesh;
    mesh.soup.resize_discarding(std::size_t{9} * count * (2 * sides + 2 * (sides - 2)));
    float* out = mesh.soup.data();
    const auto triangle = [&out](const Corner& a, const Corner& b, const Corner& c) {
        for (const Corner& corner : {a, b, c}) {
            *out++ = corner.x;
            *out++ = corner.y;
            *out++ = corner.z;
        }
    };
    const auto row = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
    for (std::uint32_t column = 0; column < count; ++column) {
        const double x = column % row;
        const double y = column / row;  // NOLINT(bugprone-integer-division): the row's number
        const std::vector<Corner> low = ring(x, y, 0, 0.40, sides);
        const std::vector<Corner> high = ring(x, y, height_mm, 0.45, sides);
        for (std::uint32_t i = 0; i < sides; ++i) {
            const std::uint32_t next = (i + 1) % sides;
            triangle(low[i], low[next], high[i]);
            triangle(low[next], high[next], high[i]);
        }
        for (std::uint32_t i = 1; i + 1 < sides; ++i) {
            triangle(low[0], low[i + 1], low[i]);
            triangle(high[0], high[i], high[i + 1]);
        }
    }
    mesh.measure();
    return mesh;
}

}  // namespace lamella::bench
