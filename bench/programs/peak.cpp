// Slices one mesh file, once, and prints the process's peak memory beside what the bound counts, as JSON.
//
//     lamella_peak MESH LAYER_HEIGHT_MM THREADS BAND_PLANES
#include <cstdlib>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "timed_runs.hpp"

int main(int count, char** words) try {
    using namespace lamella;  // NOLINT(google-build-using-namespace)
    if (count != 5) {
        std::cerr << "usage: lamella_peak MESH LAYER_HEIGHT_MM THREADS BAND_PLANES\n";
        return 2;
    }
    SliceOptions options;
    options.plan = LayerPlan{UniformLayers{.layer_height_mm = std::atof(words[2])}};
    options.control.threads = std::atoi(words[3]);
    options.tuning.band_planes = std::atoi(words[4]);
    const Result<MeshFile> mesh = read_mesh(words[1], ReadOptions{.control = {.threads = options.control.threads}});
    if (!mesh) {
        std::cerr << mesh.error().message << '\n';
        return 3;
    }
    const Result<SliceResult> result = slice(mesh->view(), options);
    if (!result) {
        std::cerr << result.error().message << '\n';
        return 3;
    }
    const std::uint64_t result_bytes = result->layers.size() * sizeof(Layer) + result->contours.size() * sizeof(Contour) +
                                       result->points.size() * sizeof(Point);
    const nlohmann::ordered_json report{{"mesh", words[1]},
                                        {"threads", options.control.threads},
                                        {"band_planes", options.tuning.band_planes},
                                        {"bands", result->summary.bands},
                                        {"peak_bytes", bench::peak_bytes()},
                                        {"input_bytes", mesh->bytes.size()},
                                        {"crossed", result->summary.crossed},
                                        {"result_bytes", result_bytes}};
    std::cout << report.dump() << '\n';
    return 0;
} catch (const std::exception& failure) {
    std::cerr << failure.what() << '\n';
    return 1;
}
