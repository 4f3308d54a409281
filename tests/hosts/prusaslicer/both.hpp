// The host's own slicing beside the adapter's, the meshes that both are given, and how they are compared and timed. Under
// the adapter's licence: AGPL-3.0-or-later (see adapter.cpp).
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

const std::function<void()> never = [] {};

using Layers = std::vector<Slic3r::ExPolygons>;
using Slicing = std::function<Layers(const Model& model, const std::vector<float>& zs)>;

/// A way to layers by both, and how far contours may lie apart on average.
struct Way {
    const char* name;
    Slicing host;
    Slicing ours;
    double bound_mm;
    bool by_area = false;  ///< of contours with the same area either may be kept
    Slic3r::Transform3d trafo = Slic3r::Transform3d::Identity();
    bool same_layers = false;  ///< both start with the same layers; else each rounds the mesh in its own way
};

/// Where a plane passes a few units beside a face that is nearly flat, a contour moves by many.
inline constexpr double points_mm = 1e-4;
/// Sharp corners are cut off differently.
inline constexpr double corners_mm = 5e-3;

/// Compares layers by their symmetric differences, and prints a table. False if one is beyond the bound.
bool layers_agree(const std::vector<Model>& parts, const std::vector<Model>& organs);

void print_agreement_head();
/// Prints a row: the mesh and layer in which both differ most. Any beyond the bound is a line after the table. The lowest
/// plane lies half a layer up, as hosts cut, or a layer up, where flat faces lie.
bool agree(const std::vector<Model>& models, double first_mm, const Way& way, const char* label, std::string& beyond);

struct Pair {
    double host_ms = 0;
    double ours_ms = 0;
};

/// Medians of runs that alternate, so that a machine which slows down slows both. The first of each is not counted.
Pair medians(const std::function<void()>& host, const std::function<void()>& ours);

/// Prints a cell, with a mark if it misses its bar: how many times faster it must be.
bool reaches(Pair pair, double bar);

/// Does operations on layers by both, compares what they give and times both: two tables. False if one is beyond the bound,
/// or ours is slower.
bool operations_agree(const std::vector<Model>& parts, const std::vector<Model>& organs);

}  // namespace compare
