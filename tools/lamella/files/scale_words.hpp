// Doubts that a mesh's size and place raise, in words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "files/mesh_input.hpp"
#include "lamella/mesh/inspect.hpp"

namespace lamella::cli {

/// Judges a mesh that is not sliced.
inline constexpr double common_layer_mm = 0.2;

/// A mesh as it was cut or examined.
struct MeasuredMesh {
    const double (&min_mm)[3];
    const double (&max_mm)[3];
    double unit_mm;                                             ///< of the grid
    std::optional<double> plane_distance_mm = common_layer_mm;  ///< the least from plane to plane, if there are two
    double detail_mm = common_layer_mm;                         ///< the least of that and the sides of voxels
    std::optional<double> farthest_mm{};                        ///< of the file's coordinates, where an image moved them
    bool moved = false;                                         ///< by a transform, so that coordinates are not the file's
};

/// Warnings, each one line that names the file: a grid too coarse, coordinates too far away, and a size that suggests
/// another unit where neither the file nor --unit states one.
std::vector<std::string> doubts_of_scale(const MeshArguments& arguments, const MeshFile& file, const MeasuredMesh& mesh);

/// ", boundary edges 0 on it and 44 by exact coordinates", after the grid, or nothing where they are as many.
std::string joined_by_grid(const MeshInfo& info);

/// For people, with at least six digits.
std::string measure_text(double value);

}  // namespace lamella::cli
