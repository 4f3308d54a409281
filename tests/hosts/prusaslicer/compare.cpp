// Slices with the host's own functions and with the adapter's, compares the layers, and times both. Prints markdown.
// Under the adapter's licence: AGPL-3.0-or-later (see adapter.cpp).
//
//     lamella_compare agree|time PARTS_FOLDER ORGANS_FOLDER
//
// PARTS_FOLDER holds the host's test meshes (.obj); ORGANS_FOLDER liver.stl, femur.stl and brain.stl.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <libslic3r/Format/OBJ.hpp>
#include <stdexcept>
#include <string_view>

#include "both.hpp"

namespace compare {
namespace {

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

}  // namespace

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
    if (task != "agree" && task != "time") {
        std::fprintf(stderr, "usage: lamella_compare agree|time PARTS_FOLDER ORGANS_FOLDER\n");
        return 2;
    }
    try {
        const std::vector<Model> organs = organs_in(argv[3]);
        if (task == "time") {
            return time_both(organs) ? 0 : 1;
        }
        const std::vector<Model> parts = parts_in(argv[2]);
        const bool layers = layers_agree(parts, organs);
        const bool calls = calls_agree(parts.front());
        return layers && calls ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
}
