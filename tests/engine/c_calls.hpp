// What tests of lamella.h share.
#pragma once

#include <catch2/catch.hpp>

#include <memory>
#include <vector>

#include "lamella/lamella.h"

namespace c_calls {

struct Freed {
    void operator()(lamella_result* result) const { lamella_result_free(result); }
    void operator()(lamella_workspace* workspace) const { lamella_workspace_free(workspace); }
    void operator()(lamella_prepared* prepared) const { lamella_prepared_free(prepared); }
};
using ResultHandle = std::unique_ptr<lamella_result, Freed>;

/// As its lamella_..._init() leaves a struct.
template <class T>
T fresh(void (*init)(T*, std::size_t)) {
    T value;
    init(&value, sizeof value);
    return value;
}
inline lamella_error fresh_error() {
    return fresh(lamella_error_init_sized);
}

inline lamella_mesh soup_of(const std::vector<float>& soup) {
    lamella_mesh mesh = fresh(lamella_mesh_init_sized);
    mesh.vertices = soup.data();
    mesh.triangle_count = soup.size() / 9;
    return mesh;
}

inline lamella_options options_at(double layer_height_mm) {
    lamella_options options = fresh(lamella_options_init_sized);
    options.layer_height_mm = layer_height_mm;
    return options;
}

inline lamella_options options_at(const std::vector<double>& heights) {
    lamella_options options = fresh(lamella_options_init_sized);
    options.spacing = LAMELLA_LAYERS_AT_HEIGHTS;
    options.heights_mm = heights.data();
    options.height_count = heights.size();
    return options;
}

inline ResultHandle sliced(const lamella_mesh& mesh, const lamella_options& options) {
    lamella_result* result = nullptr;
    lamella_error error = fresh_error();
    INFO(error.message);
    REQUIRE(lamella_slice(&mesh, &options, nullptr, &result, &error) == LAMELLA_OK);
    return ResultHandle(result);
}

inline lamella_view view_of(const lamella_result* result) {
    lamella_view view = fresh(lamella_view_init_sized);
    lamella_result_view(result, &view);
    return view;
}
inline lamella_view view_of(const ResultHandle& result) {
    return view_of(result.get());
}

/// Arrays of a host that hold what `bounds` says, for points of two numbers each.
template <class Number>
struct HostArrays {
    HostArrays(const lamella_output_bounds& bounds, std::int32_t type)
        : points(2 * bounds.points), origins(bounds.points), contours(bounds.contours), layers(bounds.layers) {
        output.point_type = type;
        output.points = points.data();
        output.point_capacity = bounds.points;
        output.contours = contours.data();
        output.contour_capacity = contours.size();
        output.layers = layers.data();
        output.layer_capacity = layers.size();
    }
    std::vector<Number> points;
    std::vector<lamella_point_origin> origins;
    std::vector<lamella_contour> contours;
    std::vector<lamella_layer> layers;
    lamella_host_output output = fresh(lamella_host_output_init_sized);
};

/// A tetrahedron of 9 mm.
inline const std::vector<float> tetrahedron = {0, 0, 0, 0, 9, 0, 9, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 9,
                                               0, 0, 0, 0, 0, 9, 0, 9, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9};

}  // namespace c_calls
