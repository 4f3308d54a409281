// Part of the adapter, under its licence: AGPL-3.0-or-later (see adapter.cpp).
#include "adapter.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <exception>
#include <libslic3r/Exception.hpp>
#include <libslic3r/TriangleMesh.hpp>
#include <mutex>
#include <utility>

namespace Slic3r::lamella_adapter {
namespace {

static_assert(sizeof(stl_vertex) == 3 * sizeof(float) && sizeof(stl_triangle_vertex_indices) == 3 * sizeof(std::uint32_t),
              "the library reads the host's arrays where they lie");

// Fresh pages cost a slice more than its arithmetic, so what one call has written the next one writes again.
class Slicers {
public:
    lamella::Slicer take() {
        const std::lock_guard lock(mutex_);
        if (idle_.empty()) {
            return {};
        }
        lamella::Slicer kept = std::move(idle_.back());
        idle_.pop_back();
        return kept;
    }
    void give_back(lamella::Slicer slicer) {
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(slicer));
    }

private:
    std::mutex mutex_;
    std::vector<lamella::Slicer> idle_;
};

Slicers& slicers() {
    static Slicers kept;
    return kept;
}

// No exception passes through the library: the first is kept until the call is over, and ends it.
class Exceptions {
public:
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
    bool thrown() const noexcept { return thrown_.load(std::memory_order_relaxed); }
    void rethrow() const {
        if (first_) {
            std::rethrow_exception(first_);
        }
    }

private:
    std::atomic<bool> thrown_ = false;
    std::exception_ptr first_;
};

bool is_identity(const Transform3d& transform) {
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

std::vector<stl_vertex> host_vertices(const std::vector<stl_vertex>& vertices, const HostVertex& host_vertex) {
    std::vector<stl_vertex> made(vertices.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), 1 << 13), [&](const auto& range) {
        for (std::size_t at = range.begin(); at < range.end(); ++at) {
            made[at] = host_vertex(vertices[at]);
        }
    });
    return made;
}

lamella::MeshView view_of(const std::vector<stl_vertex>& vertices, const std::vector<stl_triangle_vertex_indices>& indices) {
    return lamella::MeshView::indexed({reinterpret_cast<const float*>(vertices.data()), 3 * vertices.size()},
                                      {reinterpret_cast<const std::uint32_t*>(indices.data()), 3 * indices.size()});
}

// Bits by vertex: not below the lowest height that a plane may get, not above the highest.
//
// The library moves vertices and planes by no more than three units of its grid.
std::vector<std::uint8_t> sides_of(const std::vector<stl_vertex>& vertices, const HostVertex& host_vertex, float height) {
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
std::vector<float> corners_near(const indexed_triangle_set& mesh, const HostVertex& host_vertex, float height) {
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
lamella::SliceOptions options_at(const std::vector<float>& heights) {
    lamella::SliceOptions options;
    options.heights_mm.emplace(heights.size());
    std::transform(heights.begin(), heights.end(), options.heights_mm->begin(), in_frame);
    options.allow_empty = true;
    return options;
}

bool mirrors(const Transform3d& transform) {
    return transform.linear().determinant() < 0;
}

// What is outside stays outside where the transform of the vertices mirrors.
std::vector<stl_triangle_vertex_indices> turned(std::vector<stl_triangle_vertex_indices> triangles) {
    for (stl_triangle_vertex_indices& triangle : triangles) {
        std::swap(triangle[1], triangle[2]);
    }
    return triangles;
}

// Asks the host whether the call is to end, and keeps the exception by which it says so.
class Cancelling {
public:
    explicit Cancelling(const std::function<void()>& throw_on_cancel) : throw_on_cancel_(throw_on_cancel) {}

    // The library's stop check.
    bool operator()() noexcept {
        exceptions_.within(throw_on_cancel_);
        return exceptions_.thrown();
    }
    Exceptions& exceptions() { return exceptions_; }

private:
    const std::function<void()>& throw_on_cancel_;
    Exceptions exceptions_;
};

// One slice by the library.
class Call {
public:
    Call(const std::vector<float>& heights, const std::function<void()>& throw_on_cancel, const TakeLayer& take)
        : options(options_at(heights)), cancelling_(throw_on_cancel), take_(take) {
        constexpr double host_gap_mm = 2;
        options.stitch_mm = host_gap_mm * frame_per_mm;
    }

    std::vector<std::uint64_t> slice(const lamella::MeshView& mesh, int threads = 0) {
        lamella::Slicer slicer = slicers().take();
        auto info = slicer.slice_to(lamella::LayerSink{.take = *this, .order = lamella::SinkOrder::any}, mesh, options,
                                    {.threads = threads, .stop = cancelling_});
        slicers().give_back(std::move(slicer));
        cancelling_.exceptions().rethrow();
        if (!info) {
            throw SlicingError(info.error().message);
        }
        return std::move(info->layer_of);
    }

    // The library's sink.
    void operator()(const lamella::LayerView& layer) noexcept {
        cancelling_.exceptions().within([&] { take_(layer); });
    }

    lamella::SliceOptions options;

private:
    Cancelling cancelling_;
    const TakeLayer& take_;
};

}  // namespace

std::vector<std::uint64_t> cut(const indexed_triangle_set& mesh, const std::vector<float>& heights,
                               const Transform3d& transform, const lamella::RegionRules& rules,
                               const std::function<void()>& throw_on_cancel, const TakeLayer& take) {
    throw_on_cancel();
    Call call(heights, throw_on_cancel, take);
    call.options.region = rules;
    if (is_identity(transform)) {
        call.options.frame.transform = lamella::Transform::scale(frame_per_mm);
        call.options.frame.as_mesh_numbers = true;
        return call.slice(view_of(mesh.vertices, mesh.indices));
    }
    return call.slice(view_of(host_vertices(mesh.vertices, HostVertex(transform)), mesh.indices));
}

void cut(const indexed_triangle_set& mesh, float height, const Transform3d& transform, const TakeLayer& take) {
    const std::function<void()> never = [] {};
    Call call({height}, never, take);
    const std::vector<float> corners = corners_near(mesh, HostVertex(transform), in_frame(height));
    call.slice(lamella::MeshView::soup(corners), 1);
}

std::vector<lamella::SliceResult> project(const indexed_triangle_set& mesh, const std::vector<float>& heights,
                                          const Transform3d& transform, const std::vector<lamella::LayerContent>& faces,
                                          const std::function<void()>& throw_on_cancel) {
    throw_on_cancel();
    Cancelling cancelling(throw_on_cancel);
    lamella::SliceOptions options = options_at(heights);
    const std::vector<stl_vertex> vertices = host_vertices(mesh.vertices, HostVertex(transform));
    const std::vector<stl_triangle_vertex_indices> indices = mirrors(transform) ? turned(mesh.indices) : mesh.indices;
    lamella::Slicer slicer = slicers().take();
    std::vector<lamella::SliceResult> projected;
    for (const lamella::LayerContent content : faces) {
        options.content = content;
        auto slabs = slicer.slice(view_of(vertices, indices), options, {.stop = cancelling});
        cancelling.exceptions().rethrow();
        if (!slabs) {
            throw SlicingError(slabs.error().message);
        }
        projected.push_back(std::move(slabs).value());
    }
    slicers().give_back(std::move(slicer));
    return projected;
}

}  // namespace Slic3r::lamella_adapter
