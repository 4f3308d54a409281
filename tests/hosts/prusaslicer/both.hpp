// The host's own slicing beside the adapter's, and the meshes that both are given. Under the adapter's licence:
// AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <functional>
#include <libslic3r/TriangleMesh.hpp>
#include <libslic3r/TriangleMeshSlicer.hpp>
#include <string>
#include <vector>

namespace Slic3r {

// Defined in the host's TriangleMeshSlicer.cpp, renamed by host.cmake.
std::vector<Polygons> slice_mesh_host(const indexed_triangle_set& mesh, const std::vector<float>& zs,
                                      const MeshSlicingParams& params, std::function<void()> throw_on_cancel);
Polygons slice_mesh_host(const indexed_triangle_set& mesh, const float plane_z, const MeshSlicingParams& params);
std::vector<ExPolygons> slice_mesh_ex_host(const indexed_triangle_set& mesh, const std::vector<float>& zs,
                                           const MeshSlicingParamsEx& params, std::function<void()> throw_on_cancel);
void slice_mesh_slabs_host(const indexed_triangle_set& mesh, const std::vector<float>& zs, const Transform3d& trafo,
                           std::vector<Polygons>* out_top, std::vector<Polygons>* out_bottom,
                           std::function<void()> throw_on_cancel);

}  // namespace Slic3r

namespace compare {

struct Model {
    std::string name;
    indexed_triangle_set mesh;
};

/// Planes every `layer_mm` from `first_mm` above the lowest vertex to the highest one, after `transform`.
std::vector<float> heights(const Model& model, double layer_mm, double first_mm,
                           const Slic3r::Transform3d& transform = Slic3r::Transform3d::Identity());

/// Compares layers by their symmetric differences, and prints a table. False if one is beyond the bound.
bool layers_agree(const std::vector<Model>& parts, const std::vector<Model>& organs);

const std::function<void()> never = [] {};

}  // namespace compare
