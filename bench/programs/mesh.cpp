#include "mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <system_error>

#include "base/parallel.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella::bench {

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

Result<Mesh> load_mesh(const std::filesystem::path& file) {
    const Result<MeshFile> stl = read_mesh(file);
    if (!stl) {
        return stl.error();
    }
    Mesh mesh;
    mesh.file = file;
    mesh.soup.resize_discarding(9 * stl->triangle_count);
    const MeshView view = stl->view();
    Parallel().run_ranges(stl->triangle_count, 1 << 14, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t t = begin; t < end; ++t) {
            std::memcpy(mesh.soup.data() + 9 * t, view.vertices + t * view.stride, 9 * sizeof(float));
        }
    });
    mesh.measure();
    return mesh;
}

Result<std::filesystem::path> cached_mesh(const models::Recipe& recipe, const std::filesystem::path& cache) {
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
        if (const Result<std::uint64_t> made = models::write_stl(recipe, file); !made) {
            return made.error();
        }
    }
    return file;
}

}  // namespace lamella::bench
