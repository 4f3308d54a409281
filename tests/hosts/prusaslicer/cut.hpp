// The library's slices of the host's meshes: its lengths, heights, transforms and exceptions as the library takes them. Part
// of the adapter, under its licence: AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <tbb/concurrent_queue.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <lamella/grid.hpp>
#include <lamella/layers.hpp>
#include <lamella/slice.hpp>
#include <libslic3r/Exception.hpp>
#include <libslic3r/TriangleMesh.hpp>
#include <utility>

namespace Slic3r::lamella_adapter {

/// The library works in a frame of its own: 2^20 of the host's units of 1e-6 mm are what it calls a millimetre, so that its
/// default unit, 2^-20 mm, is the host's unit. A mesh too large for that gets a larger power of two by itself. In this frame
/// the library reads floats fastest.
inline constexpr float frame_per_mm = 15625.0F / 16384;
static_assert(frame_per_mm * 0x1p20 == 1e6 && lamella::default_grid_mm == 0x1p-20);

/// Rounds to float, as the host does where it scales a coordinate.
constexpr float in_frame(float mm) {
    return mm * frame_per_mm;
}

/// Called by several threads at once; may throw.
using TakeLayer = std::function<void(const lamella::LayerView& layer)>;

static_assert(sizeof(stl_vertex) == 3 * sizeof(float) && sizeof(stl_triangle_vertex_indices) == 3 * sizeof(std::uint32_t),
              "the library reads the host's arrays where they lie");

// Fresh pages cost a slice more than its arithmetic, so what one call has written the next one writes again.
inline tbb::concurrent_queue<lamella::Slicer> idle_slicers;

// What a call asks of the host: whether it is to end. No exception passes through the library: the first is kept until the
// call is over, and ends it.
class HostCalls {
public:
    explicit HostCalls(const std::function<void()>& throw_on_cancel) : throw_on_cancel_(throw_on_cancel) {}

    template <class Work>
    void within(const Work& work) noexcept {
        try {
            work();
        } catch (...) {
            if (!thrown_.exchange(true)) {
                first_ = std::current_exception();
            }
        }
    }
    // The library's stop check.
    bool operator()() noexcept {
        within(throw_on_cancel_);
        return thrown_.load(std::memory_order_relaxed);
    }
    // After a call: its value, or what ended it.
    template <class Value>
    Value finish(lamella::Result<Value> outcome) const {
        if (first_) {
            std::rethrow_exception(first_);
        }
        if (!outcome) {
            throw SlicingError(outcome.error().message);
        }
        return std::move(outcome).value();
    }

private:
    const std::function<void()>& throw_on_cancel_;
    std::atomic<bool> thrown_ = false;
    std::exception_ptr first_;
};

inline bool is_identity(const Transform3d& transform) {
    return transform.matrix() == Transform3d::Identity().matrix();
}

// The host's vertices in the library's frame, rounded as the host rounds them: it multiplies in float, with x and y scaled
// to its unit, so that a face which it sees on a plane must be on it here too. Powers of two round nothing.
class HostVertex {
public:
    explicit HostVertex(const Transform3d& transform) : moves_(!is_identity(transform)) {
        Transform3d scaled = transform;
        scaled.prescale(Vec3d(1 / SCALING_FACTOR, 1 / SCALING_FACTOR, 1.));
        by_ = scaled.cast<float>();
    }

    stl_vertex operator()(const stl_vertex& vertex) const {
        if (!moves_) {
            return vertex * frame_per_mm;
        }
        const stl_vertex moved = by_ * vertex;
        return {moved.x() * 0x1p-20F, moved.y() * 0x1p-20F, in_frame(moved.z())};
    }

private:
    Transform3f by_;
    bool moves_;
};

inline std::vector<stl_vertex> host_vertices(const std::vector<stl_vertex>& vertices, const HostVertex& host_vertex) {
    std::vector<stl_vertex> made(vertices.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), 1 << 13), [&](const auto& range) {
        for (std::size_t at = range.begin(); at < range.end(); ++at) {
            made[at] = host_vertex(vertices[at]);
        }
    });
    return made;
}

inline lamella::MeshView view_of(const std::vector<stl_vertex>& vertices,
                                 const std::vector<stl_triangle_vertex_indices>& indices) {
    return lamella::MeshView::indexed({reinterpret_cast<const float*>(vertices.data()), 3 * vertices.size()},
                                      {reinterpret_cast<const std::uint32_t*>(indices.data()), 3 * indices.size()});
}

// Bits by vertex: not below the lowest height that a plane may get, not above the highest.
//
// The library moves vertices and planes by no more than three units of its grid.
inline std::vector<std::uint8_t> sides_of(const std::vector<stl_vertex>& vertices, const HostVertex& host_vertex,
                                          float height) {
    const float reach = 1e-5F + 1e-6F * std::abs(height);
    const float low = height - reach;
    const float high = height + reach;
    std::vector<std::uint8_t> sides(vertices.size());
    for (std::size_t at = 0; at < vertices.size(); ++at) {
        const float z = host_vertex(vertices[at]).z();
        sides[at] = static_cast<std::uint8_t>((z >= low ? 1 : 0) | (z <= high ? 2 : 0));
    }
    return sides;
}

// The corners of the triangles that may cross a plane, nine numbers each.
inline std::vector<float> corners_near(const indexed_triangle_set& mesh, const HostVertex& host_vertex, float height) {
    const std::vector<std::uint8_t> sides = sides_of(mesh.vertices, host_vertex, height);
    std::vector<float> corners;
    for (const stl_triangle_vertex_indices& triangle : mesh.indices) {
        if ((sides[triangle[0]] | sides[triangle[1]] | sides[triangle[2]]) == 3) {
            for (int corner = 0; corner < 3; ++corner) {
                const stl_vertex vertex = host_vertex(mesh.vertices[triangle[corner]]);
                corners.insert(corners.end(), vertex.data(), vertex.data() + 3);
            }
        }
    }
    return corners;
}

// Options that host and library agree on, for planes at these heights.
inline lamella::SliceOptions options_at(const std::vector<float>& heights) {
    lamella::SliceOptions options;
    options.heights_mm.emplace(heights.size());
    std::transform(heights.begin(), heights.end(), options.heights_mm->begin(), in_frame);
    options.allow_empty = true;
    return options;
}

inline bool mirrors(const Transform3d& transform) {
    return transform.linear().determinant() < 0;
}

// What is outside stays outside where the transform of the vertices mirrors.
inline std::vector<stl_triangle_vertex_indices> turned(std::vector<stl_triangle_vertex_indices> triangles) {
    for (stl_triangle_vertex_indices& triangle : triangles) {
        std::swap(triangle[1], triangle[2]);
    }
    return triangles;
}

inline lamella::SliceOptions cutting_options(const std::vector<float>& heights) {
    constexpr double host_gap_mm = 2;
    lamella::SliceOptions options = options_at(heights);
    options.stitch_mm = host_gap_mm * frame_per_mm;
    return options;
}

/// For a mesh that no transform moves.
inline lamella::SliceOptions cutting_options(const std::vector<float>& heights, const lamella::RegionRules& rules) {
    lamella::SliceOptions options = cutting_options(heights);
    options.region = rules;
    options.frame.transform = lamella::Transform::scale(frame_per_mm);
    options.frame.as_mesh_numbers = true;
    return options;
}

// One slice by the library: the layer of each height.
inline std::vector<std::uint64_t> slice(const lamella::MeshView& mesh, const lamella::SliceOptions& options,
                                        const std::function<void()>& throw_on_cancel, const TakeLayer& take,
                                        int threads = 0) {
    HostCalls calls(throw_on_cancel);
    const auto take_layer = [&](const lamella::LayerView& layer) noexcept { calls.within([&] { take(layer); }); };
    lamella::Slicer slicer;
    idle_slicers.try_pop(slicer);
    auto info = slicer.slice_to(lamella::LayerSink{.take = take_layer, .order = lamella::SinkOrder::any}, mesh, options,
                                {.threads = threads, .stop = calls});
    idle_slicers.push(std::move(slicer));
    return calls.finish(std::move(info)).layer_of;
}

/// Cuts a mesh at the host's heights, in any order, and hands over the layers, each as soon as it is finished. Returns the
/// layer of each height. Throws what `take` and the host's cancelling throw, and SlicingError where the library refuses the
/// mesh.
inline std::vector<std::uint64_t> cut(const indexed_triangle_set& mesh, const std::vector<float>& heights,
                                      const Transform3d& transform, const lamella::RegionRules& rules,
                                      const std::function<void()>& throw_on_cancel, const TakeLayer& take) {
    throw_on_cancel();
    if (is_identity(transform)) {
        return slice(view_of(mesh.vertices, mesh.indices), cutting_options(heights, rules), throw_on_cancel, take);
    }
    lamella::SliceOptions options = cutting_options(heights);
    options.region = rules;
    const std::vector<stl_vertex> vertices = host_vertices(mesh.vertices, HostVertex(transform));
    return slice(view_of(vertices, mesh.indices), options, throw_on_cancel, take);
}

/// At one height, on the calling thread.
inline void cut(const indexed_triangle_set& mesh, float height, const Transform3d& transform, const TakeLayer& take) {
    const std::vector<float> corners = corners_near(mesh, HostVertex(transform), in_frame(height));
    slice(
        lamella::MeshView::soup(corners), cutting_options({height}), [] {}, take, 1);
}

/// Projects faces onto layers at the host's heights: a result for each of `faces`. Throws as cut().
inline std::vector<lamella::SliceResult> project(const indexed_triangle_set& mesh, const std::vector<float>& heights,
                                                 const Transform3d& transform,
                                                 const std::vector<lamella::LayerContent>& faces,
                                                 const std::function<void()>& throw_on_cancel) {
    throw_on_cancel();
    HostCalls calls(throw_on_cancel);
    lamella::SliceOptions options = options_at(heights);
    const std::vector<stl_vertex> vertices = host_vertices(mesh.vertices, HostVertex(transform));
    const std::vector<stl_triangle_vertex_indices> indices = mirrors(transform) ? turned(mesh.indices) : mesh.indices;
    lamella::Slicer slicer;
    idle_slicers.try_pop(slicer);
    std::vector<lamella::SliceResult> projected;
    projected.reserve(faces.size());
    for (const lamella::LayerContent content : faces) {
        options.content = content;
        projected.push_back(calls.finish(slicer.slice(view_of(vertices, indices), options, {.stop = calls})));
    }
    idle_slicers.push(std::move(slicer));
    return projected;
}

}  // namespace Slic3r::lamella_adapter
