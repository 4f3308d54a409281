// Slices one mesh again and again: prints its hash and the fastest time, in ms, on 1 and on 2 threads.
//
// Made on the spot, the mesh is the same on every platform, and so is the hash.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <span>
#include <vector>

#include "lamella/lamella.hpp"
#include "models/models.hpp"

int main() {
    const std::vector<float> soup = lamella::models::make_soup({.shape = lamella::models::Shape::bone, .triangles = 40'000});
    const lamella::MeshView mesh = lamella::MeshView::soup(std::span<const float>(soup));
    lamella::Slicer slicer;
    lamella::SliceResult result;
    for (const int threads : {1, 2}) {
        double best_ms = 1e9;
        for (int i = 0; i < 21; ++i) {
            const auto start = std::chrono::steady_clock::now();
            const auto done = slicer.slice_to(result, mesh, {.layer_height_mm = 0.1}, {.threads = threads});
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
            if (!done) {
                std::fprintf(stderr, "%s\n", done.error().message.c_str());
                return 1;
            }
            best_ms = std::min(best_ms, took.count());
        }
        std::printf("%d %016llx %.2f\n", threads, static_cast<unsigned long long>(result.hash()), best_ms);
    }
}
