// Handles, structs and calls of lamella.h for its tests.
#pragma once

#include <catch2/catch.hpp>

#include <memory>
#include <vector>

#include "lamella/lamella.h"

namespace c_calls {

struct Freed {
    void operator()(lamella_result* result) const { lamella_result_free(result); }
    void operator()(lamella_slicer* slicer) const { lamella_slicer_free(slicer); }
    void operator()(lamella_prepared* prepared) const { lamella_prepared_free(prepared); }
    void operator()(lamella_welded* welded) const { lamella_welded_free(welded); }
};
using ResultHandle = std::unique_ptr<lamella_result, Freed>;

/// A struct of C with its defaults, as fresh<lamella_view>(LAMELLA_VIEW).
template <class T>
T fresh(std::int32_t kind) {
    T it;
    LAMELLA_INIT(&it, kind);
    return it;
}

inline lamella_mesh soup_of(const std::vector<float>& soup) {
    auto mesh = fresh<lamella_mesh>(LAMELLA_MESH);
    mesh.vertices = soup.data();
    mesh.triangle_count = soup.size() / 9;
    return mesh;
}

inline lamella_options options_at(double layer_height_mm) {
    auto options = fresh<lamella_options>(LAMELLA_OPTIONS);
    options.layer_height_mm = layer_height_mm;
    return options;
}

inline lamella_options at_heights(const std::vector<double>& heights) {
    auto options = fresh<lamella_options>(LAMELLA_OPTIONS);
    options.at_heights = 1;
    options.heights_mm = heights.data();
    options.height_count = heights.size();
    return options;
}

inline lamella_source source_of(const lamella_mesh& mesh) {
    auto source = fresh<lamella_source>(LAMELLA_SOURCE);
    source.mesh = &mesh;
    return source;
}

/// A sink that calls `take(layer)`.
template <class Take>
lamella_sink sink_to(Take& take) {
    auto sink = fresh<lamella_sink>(LAMELLA_SINK);
    sink.take = [](void* self, const lamella_layer_view* layer) { (*static_cast<Take*>(self))(*layer); };
    sink.object = &take;
    return sink;
}

inline lamella_destination into(lamella_result** result, const lamella_sink* sink, const lamella_arrays* arrays) {
    auto to = fresh<lamella_destination>(LAMELLA_DESTINATION);
    to.result = result;
    to.sink = sink;
    to.arrays = arrays;
    return to;
}

inline ResultHandle sliced(const lamella_mesh& mesh, const lamella_options& options) {
    lamella_result* result = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    INFO(error.message);
    REQUIRE(lamella_slice(nullptr, &mesh, &options, &result, &error) == LAMELLA_OK);
    return ResultHandle(result);
}

inline ResultHandle sliced_from(const lamella_source& from, const lamella_options& options,
                                const lamella_context* context = nullptr) {
    lamella_result* result = nullptr;
    const lamella_destination to = into(&result, nullptr, nullptr);
    REQUIRE(lamella_slice_to(nullptr, &to, &from, &options, context, nullptr, nullptr) == LAMELLA_OK);
    return ResultHandle(result);
}

inline lamella_view view_of(const ResultHandle& result) {
    auto view = fresh<lamella_view>(LAMELLA_VIEW);
    lamella_result_view(result.get(), &view);
    return view;
}

/// A tetrahedron of 9 mm.
inline const std::vector<float> tetrahedron = {0, 0, 0, 0, 9, 0, 9, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 9,
                                               0, 0, 0, 0, 0, 9, 0, 9, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9};

}  // namespace c_calls
