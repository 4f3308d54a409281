#include <cstdio>
#include <vector>

#include <lamella/lamella.hpp>

int main() {
    // A tetrahedron of 20 mm: layers of 0.5 mm, a triangle in each.
    const std::vector<float> xyz = {0, 0, 0, 20, 0, 0, 0, 20, 0, 0, 0, 20};
    const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    lamella::SliceOptions options;
    options.plan.spacing = lamella::UniformLayers{.layer_height_mm = 0.5};
    const auto result = lamella::slice(lamella::MeshView::indexed(xyz, indices), options);
    if (!result) {
        std::fprintf(stderr, "%s\n", result.error().message.c_str());
        return 1;
    }
    std::printf("%zu layers, %zu contours\n", result->layers.size(), result->contours.size());
}
