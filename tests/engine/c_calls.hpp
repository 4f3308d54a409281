// Handles, structs and calls of lamella.h for its tests.
#pragma once

#include <cstring>
#include <memory>
#include <vector>

#include <catch2/catch.hpp>

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

inline lamella_destination into(lamella_result** result, const lamella_sink* sink, const lamella_arrays* arrays) {
    auto to = fresh<lamella_destination>(LAMELLA_DESTINATION);
    to.result = result;
    to.sink = sink;
    to.arrays = arrays;
    return to;
}

inline ResultHandle sliced(const lamella_source& from, const lamella_options& options,
                           const lamella_context* context = nullptr) {
    lamella_result* result = nullptr;
    const lamella_destination to = into(&result, nullptr, nullptr);
    REQUIRE(lamella_slice_to(nullptr, &to, &from, &options, context, nullptr, nullptr) == LAMELLA_OK);
    return ResultHandle(result);
}
inline ResultHandle sliced(const lamella_mesh& mesh, const lamella_options& options) {
    return sliced(source_of(mesh), options);
}

inline std::uint64_t hash_of(const lamella_mesh& mesh, const lamella_options& options) {
    return lamella_result_hash(sliced(mesh, options).get());
}

inline lamella_view view_of(const ResultHandle& result) {
    auto view = fresh<lamella_view>(LAMELLA_VIEW);
    lamella_result_view(result.get(), &view);
    return view;
}

/// A tetrahedron of 9 mm.
inline const std::vector<float> tetrahedron = {0, 0, 0, 0, 9, 0, 9, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 9,
                                               0, 0, 0, 0, 0, 9, 0, 9, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9};

/// A sink that puts the layers together that it is given.
struct Collected {
    std::vector<lamella_point> points;
    std::vector<lamella_point_origin> origins;
    std::vector<std::uint64_t> order;

    lamella_sink sink() {
        auto sink = fresh<lamella_sink>(LAMELLA_SINK);
        sink.object = this;
        sink.take = [](void* object, const lamella_layer_view* layer) {
            auto& self = *static_cast<Collected*>(object);
            self.order.push_back(layer->index);
            self.points.insert(self.points.end(), layer->points, layer->points + layer->point_count);
            if (layer->origins != nullptr) {
                self.origins.insert(self.origins.end(), layer->origins, layer->origins + layer->point_count);
            }
        };
        return sink;
    }
};

template <class T>
bool same_bytes(const std::vector<T>& got, const T* expected, std::uint64_t count) {
    return got.size() >= count && std::memcmp(got.data(), expected, count * sizeof(T)) == 0;
}

}  // namespace c_calls
