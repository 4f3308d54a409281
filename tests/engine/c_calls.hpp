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

inline lamella_error fresh_error() {
    lamella_error error;
    lamella_error_init(&error);
    return error;
}

inline lamella_mesh soup_of(const std::vector<float>& soup) {
    lamella_mesh mesh;
    lamella_mesh_init(&mesh);
    mesh.vertices = soup.data();
    mesh.triangle_count = soup.size() / 9;
    return mesh;
}

inline lamella_options options_at(double layer_height_mm) {
    lamella_options options;
    lamella_options_init(&options);
    options.layer_height_mm = layer_height_mm;
    return options;
}

inline ResultHandle sliced(const lamella_mesh& mesh, const lamella_options& options) {
    lamella_result* result = nullptr;
    lamella_error error = fresh_error();
    INFO(error.message);
    REQUIRE(lamella_slice(&mesh, &options, nullptr, &result, &error) == LAMELLA_OK);
    return ResultHandle(result);
}

/// A tetrahedron of 9 mm.
inline const std::vector<float> tetrahedron = {0, 0, 0, 0, 9, 0, 9, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 9,
                                               0, 0, 0, 0, 0, 9, 0, 9, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9};

}  // namespace c_calls
