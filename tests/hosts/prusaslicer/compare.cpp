// Slices with the host's own functions and with the adapter's, compares the layers, and times both. Prints markdown.
// Under the adapter's licence: AGPL-3.0-or-later (see adapter.cpp).
//
//     lamella_compare agree|time|operations PARTS_FOLDER ORGANS_FOLDER
//
// PARTS_FOLDER holds the host's test meshes (.obj); ORGANS_FOLDER liver.stl, femur.stl and brain.stl.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <libslic3r/Format/OBJ.hpp>
#include <stdexcept>
#include <string_view>

#include "both.hpp"

namespace compare {
namespace {

using namespace Slic3r;

namespace fs = std::filesystem;

Model read(const fs::path& path) {
    Slic3r::TriangleMesh mesh;
    const bool read = path.extension() == ".obj" ? Slic3r::load_obj(path.c_str(), &mesh) : mesh.ReadSTLFile(path.c_str());
    if (!read || mesh.empty()) {
        throw std::runtime_error(path.string() + ": no mesh");
    }
    return {path.stem().string(), std::move(mesh.its)};
}

std::vector<Model> parts_in(const fs::path& folder) {
    std::vector<fs::path> paths;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() == ".obj") {
            paths.push_back(entry.path());
        }
    }
    std::sort(paths.begin(), paths.end());
    std::vector<Model> models;
    std::transform(paths.begin(), paths.end(), std::back_inserter(models), read);
    return models;
}

std::vector<Model> organs_in(const fs::path& folder) {
    return {read(folder / "liver.stl"), read(folder / "femur.stl"), read(folder / "brain.stl")};
}

template <class Work>
double milliseconds(const Work& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> times) {
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

Pair time_loops(const Model& model, const std::vector<float>& zs) {
    const MeshSlicingParams params;
    return medians([&] { slice_mesh_host(model.mesh, zs, params, never); },
                   [&] { slice_mesh(model.mesh, zs, params, never); });
}

Pair time_regions(const Model& model, const std::vector<float>& zs, float closing_mm) {
    MeshSlicingParamsEx params;
    params.closing_radius = closing_mm;
    return medians([&] { slice_mesh_ex_host(model.mesh, zs, params, never); },
                   [&] { slice_mesh_ex(model.mesh, zs, params, never); });
}

// Per call, over planes spread over the whole height.
Pair time_single_planes(const Model& model) {
    constexpr std::size_t planes = 31;
    const std::vector<float> all = heights(model, 0.2, 0.1);
    std::vector<float> some;
    for (std::size_t plane = 0; plane < planes; ++plane) {
        some.push_back(all[(2 * plane + 1) * all.size() / (2 * planes)]);
    }
    const MeshSlicingParams params;
    const auto over_planes = [&](const auto& slice) {
        return [&some, slice] {
            for (const float z : some) {
                slice(z);
            }
        };
    };
    const Pair sums = medians(over_planes([&](float z) { slice_mesh_host(model.mesh, z, params); }),
                              over_planes([&](float z) { slice_mesh(model.mesh, z, params); }));
    return {sums.host_ms / planes, sums.ours_ms / planes};
}

/// Times both, alternately, and prints the tables. False if the adapter is not as much faster as it must be: at 0.2 mm 12
/// times for loops and 8 times for regions with closing; elsewhere no slower.
bool time_both(const std::vector<Model>& organs) {
    std::printf("| | slice_mesh | slice_mesh_ex, closing 0 | slice_mesh_ex, closing 0.049 |\n|---|---|---|---|\n");
    bool all = true;
    for (const Model& model : organs) {
        for (const double layer_mm : {0.2, 0.032}) {
            const bool barred = layer_mm == 0.2;
            const std::vector<float> zs = heights(model, layer_mm, layer_mm / 2);
            std::printf("| %s %g mm |", model.name.c_str(), layer_mm);
            all = reaches(time_loops(model, zs), barred ? 12 : 1) && all;
            all = reaches(time_regions(model, zs, 0), 1) && all;
            all = reaches(time_regions(model, zs, 0.049F), barred ? 8 : 1) && all;
            std::printf("\n");
        }
    }
    std::printf("\n| one plane a call | slice_mesh |\n|---|---|\n");
    for (const Model& model : organs) {
        std::printf("| %s |", model.name.c_str());
        all = reaches(time_single_planes(model), 1) && all;
        std::printf("\n");
    }
    return all;
}

}  // namespace

Pair medians(const std::function<void()>& host, const std::function<void()>& ours) {
    constexpr std::size_t least_runs = 3;
    constexpr std::size_t most_runs = 7;
    constexpr double enough_ms = 20000;
    std::vector<double> host_ms;
    std::vector<double> ours_ms;
    double spent_ms = milliseconds(host) + milliseconds(ours);
    while (host_ms.size() < least_runs || (host_ms.size() < most_runs && spent_ms < enough_ms)) {
        host_ms.push_back(milliseconds(host));
        ours_ms.push_back(milliseconds(ours));
        spent_ms += host_ms.back() + ours_ms.back();
    }
    return {median(host_ms), median(ours_ms)};
}

bool reaches(Pair pair, double bar) {
    const double times = pair.host_ms / pair.ours_ms;
    std::printf(" %.3g -> %.3g (%.1f%s) |", pair.host_ms, pair.ours_ms, times, times < bar ? ", below the bar" : "");
    std::fflush(stdout);
    return times >= bar;
}

std::vector<float> heights(const Model& model, double layer_mm, double first_mm, const Slic3r::Transform3d& transform) {
    double low = std::numeric_limits<double>::max();
    double high = std::numeric_limits<double>::lowest();
    for (const stl_vertex& vertex : model.mesh.vertices) {
        const double z = (transform * vertex.cast<double>()).z();
        low = std::min(low, z);
        high = std::max(high, z);
    }
    std::vector<float> made;
    for (std::size_t layer = 0; low + first_mm + layer_mm * static_cast<double>(layer) < high; ++layer) {
        made.push_back(static_cast<float>(low + first_mm + layer_mm * static_cast<double>(layer)));
    }
    return made;
}

}  // namespace compare

int main(int argc, char** argv) {
    using namespace compare;
    const std::string_view task = argc == 4 ? argv[1] : "";
    if (task != "agree" && task != "time" && task != "operations") {
        std::fprintf(stderr, "usage: lamella_compare agree|time|operations PARTS_FOLDER ORGANS_FOLDER\n");
        return 2;
    }
    try {
        const std::vector<compare::Model> organs = organs_in(argv[3]);
        if (task == "time") {
            return time_both(organs) ? 0 : 1;
        }
        const std::vector<compare::Model> parts = parts_in(argv[2]);
        return (task == "agree" ? layers_agree(parts, organs) : operations_agree(parts, organs)) ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
}
