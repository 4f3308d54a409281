#include "files/scale_words.hpp"

#include <algorithm>
#include <cmath>

#include "lamella/mesh/scale.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

constexpr double longest_mm = 10'000;  // of what is printed, or scanned
constexpr double shortest_mm = 1;

struct Unit {
    const char* name;
    const char* words;
    double mm;
};
constexpr Unit metre{"m", "metres", 1000};
constexpr Unit micrometre{"um", "micrometres", 0.001};

/// "in metres? --unit m", unless the mesh would be out of proportion in that unit too.
std::string question(const Unit& unit, double length_mm) {
    const double length_so_mm = length_mm * unit.mm;
    return length_so_mm < shortest_mm || length_so_mm > longest_mm
               ? "in another unit? see --unit"
               : std::string("in ") + unit.words + "? --unit " + unit.name;
}

std::optional<std::string> doubt_of_unit(const MeasuredMesh& mesh) {
    double length_mm = 0;
    for (int axis = 0; axis < 3; ++axis) {
        length_mm = std::max(length_mm, mesh.max_mm[axis] - mesh.min_mm[axis]);
    }
    const double height_mm = mesh.max_mm[2] - mesh.min_mm[2];
    if (length_mm > longest_mm) {
        return "the mesh is " + measure_text(length_mm) + " mm long: " + question(micrometre, length_mm);
    }
    // A plate may be thinner than a layer. What would be longer than 10 m in metres is not in metres.
    if (mesh.plane_distance_mm && height_mm < *mesh.plane_distance_mm && length_mm * metre.mm <= longest_mm) {
        return "the mesh is " + measure_text(height_mm) + " mm high, less than a layer: " + question(metre, length_mm);
    }
    return std::nullopt;
}

}  // namespace

std::vector<std::string> doubts_of_scale(const MeshArguments& arguments, const MeshFile& file, const MeasuredMesh& mesh) {
    std::vector<std::string> doubts;
    const auto add = [&](const std::string& text) { doubts.push_back(arguments.name() + ": " + text); };
    if (!file.states_unit && !arguments.unit) {
        if (const std::optional<std::string> doubt = doubt_of_unit(mesh)) {
            add(*doubt);
        }
    }
    const MeshScale scale = judge_scale(mesh.min_mm, mesh.max_mm, file.coordinate_type, mesh.unit_mm);
    if (scale.coarse_grid) {
        add("the grid of " + exact_text(mesh.unit_mm) + " mm is coarse for a mesh of " + measure_text(scale.diagonal_mm) +
            " mm from corner to corner; " +
            (scale.finest_unit_mm < mesh.unit_mm
                 ? "--grid auto takes " + exact_text(scale.finest_unit_mm) + " mm"
                 : "none finer reaches the coordinate of " + measure_text(scale.farthest_mm) + " mm"));
    }
    const double farthest = mesh.farthest_mm.value_or(scale.farthest_mm);
    const double there[3] = {farthest, farthest, farthest};
    const MeshScale stored = judge_scale(there, there, file.coordinate_type, mesh.unit_mm, mesh.detail_mm);
    if (stored.coarse_numbers && !mesh.moved) {
        add("coordinates of up to " + measure_text(farthest) + " mm are stored in steps of " +
            measure_text(stored.number_step_mm) + " mm, more than a tenth of " + exact_text(mesh.detail_mm) +
            " mm, the layer height or voxel; it lost precision before it was read");
    }
    return doubts;
}

std::string joined_by_grid(const MeshInfo& info) {
    return info.exact_boundary_edges == info.boundary_edges
               ? ""
               : ", boundary edges " + grouped(info.boundary_edges) + " on it and " + grouped(info.exact_boundary_edges) +
                     " by exact coordinates";
}

std::string measure_text(double value) {
    if (value == 0 || !std::isfinite(value)) {
        return rounded(value, 3);
    }
    const int digits_before_point = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
    return rounded(value, std::max(3, 6 - digits_before_point));
}

}  // namespace lamella::cli
