// Part of the adapter, under its licence: AGPL-3.0-or-later (see adapter.cpp).
#include "cut.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <libslic3r/Exception.hpp>
#include <libslic3r/TriangleMesh.hpp>
#include <mutex>
#include <numeric>
#include <utility>

namespace Slic3r::lamella_adapter {
namespace {

static_assert(sizeof(stl_vertex) == 3 * sizeof(float) && sizeof(stl_triangle_vertex_indices) == 3 * sizeof(std::uint32_t),
              "the library reads the host's arrays where they lie");

// Fresh pages cost a slice more than its arithmetic, so what one call has written the next one writes again.
class ScratchPool {
public:
    std::unique_ptr<Scratch> take() {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                std::unique_ptr<Scratch> kept = std::move(idle_.back());
                idle_.pop_back();
                return kept;
            }
        }
        return std::make_unique<Scratch>();
    }
    void give_back(std::unique_ptr<Scratch> scratch) {
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(scratch));
    }

private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<Scratch>> idle_;
};

ScratchPool& scratch_pool() {
    static ScratchPool pool;
    return pool;
}

bool is_identity(const Transform3d& transform) {
    return transform.matrix() == Transform3d::Identity().matrix();
}

// The host multiplies in float, with x and y scaled to its unit: a face that it sees on a plane must be on it here too.
Transform3f float_transform(const Transform3d& transform) {
    Transform3d scaled = transform;
    scaled.prescale(Vec3d(1 / SCALING_FACTOR, 1 / SCALING_FACTOR, 1.));
    return scaled.cast<float>();
}

// And from there to mm.
lamella::Transform from_host_units() {
    return {{SCALING_FACTOR, 0, 0, 0, 0, SCALING_FACTOR, 0, 0, 0, 0, 1, 0}};
}

std::vector<stl_vertex> transformed(const std::vector<stl_vertex>& vertices, const Transform3f& by) {
    std::vector<stl_vertex> moved(vertices.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), 1 << 14), [&](const auto& range) {
        for (std::size_t at = range.begin(); at < range.end(); ++at) {
            moved[at] = by * vertices[at];
        }
    });
    return moved;
}

lamella::MeshView view(const std::vector<stl_vertex>& vertices, const std::vector<stl_triangle_vertex_indices>& indices) {
    return lamella::MeshView::indexed({reinterpret_cast<const float*>(vertices.data()), 3 * vertices.size()},
                                      {reinterpret_cast<const std::uint32_t*>(indices.data()), 3 * indices.size()});
}

// Bits by vertex: not below the lowest height that a plane may get, not above the highest.
//
// The library moves vertices and planes by no more than three units and a float's rounding.
std::vector<std::uint8_t> sides_of(const std::vector<stl_vertex>& vertices, float height) {
    const float reach = 1e-5F + 1e-6F * std::abs(height);
    const float low = height - reach;
    const float high = height + reach;
    std::vector<std::uint8_t> sides(vertices.size());
    for (std::size_t at = 0; at < vertices.size(); ++at) {
        const float z = vertices[at].z();
        sides[at] = static_cast<std::uint8_t>((z >= low ? 1 : 0) | (z <= high ? 2 : 0));
    }
    return sides;
}

// The corners of the triangles that may cross a plane, nine numbers each.
std::vector<float> corners_near(const std::vector<stl_vertex>& vertices,
                                const std::vector<stl_triangle_vertex_indices>& indices, float height) {
    const std::vector<std::uint8_t> sides = sides_of(vertices, height);
    std::vector<float> corners;
    for (const stl_triangle_vertex_indices& triangle : indices) {
        if ((sides[triangle[0]] | sides[triangle[1]] | sides[triangle[2]]) == 3) {
            for (int corner = 0; corner < 3; ++corner) {
                const float* numbers = vertices[triangle[corner]].data();
                corners.insert(corners.end(), numbers, numbers + 3);
            }
        }
    }
    return corners;
}

struct Heights {
    std::vector<double> ascending;      ///< without those that fall on the same plane
    std::vector<std::size_t> layer_of;  ///< by height as the host gave them
};

// The library wants heights ascending and distinct on its even grid.
Heights sorted(const std::vector<float>& heights) {
    std::vector<std::size_t> order(heights.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t left, std::size_t right) { return heights[left] < heights[right]; });
    Heights made;
    made.layer_of.resize(heights.size());
    for (const std::size_t at : order) {
        const double height = heights[at];
        if (made.ascending.empty() || height - made.ascending.back() > 4 * SCALING_FACTOR) {
            made.ascending.push_back(height);
        }
        made.layer_of[at] = made.ascending.size() - 1;
    }
    return made;
}

lamella::SliceOptions options_for(std::vector<double> heights) {
    constexpr double host_gap_mm = 2;
    lamella::SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{std::move(heights)};
    options.unit_mm = SCALING_FACTOR;
    options.close_gaps_mm = host_gap_mm;
    return options;
}

// A mesh without triangles has empty layers. One that is too large for the host's unit gets the default grid.
void slice_into(Scratch& scratch, const lamella::MeshView& mesh, lamella::SliceOptions& options, Cancel& cancel) {
    const lamella::Status status = lamella::slice(mesh, options, scratch.workspace, scratch.result);
    cancel.rethrow();
    if (status) {
        return;
    }
    if (status.error().code == lamella::ErrorCode::bad_coordinate && options.unit_mm != 0) {
        options.unit_mm = 0;
        slice_into(scratch, mesh, options, cancel);
        return;
    }
    if (status.error().code != lamella::ErrorCode::empty_mesh) {
        throw SlicingError(status.error().message);
    }
    scratch.result.layers.set_size(0);
}

}  // namespace

lamella::StopCheck Cancel::stop_check() noexcept {
    return {[](void* context) noexcept { return static_cast<Cancel*>(context)->requested(); }, this};
}

bool Cancel::requested() noexcept {
    try {
        throw_on_cancel_();
    } catch (...) {
        if (!thrown_.exchange(true)) {
            exception_ = std::current_exception();
        }
    }
    return thrown_.load(std::memory_order_relaxed);
}

void Cancel::rethrow() const {
    if (exception_) {
        std::rethrow_exception(exception_);
    }
}

Cut::Cut(const indexed_triangle_set& mesh, const std::vector<float>& heights, const Transform3d& transform,
         const lamella::RegionRules& rules, const std::function<void()>& throw_on_cancel)
    : scratch_(scratch_pool().take()) {
    throw_on_cancel();
    Heights ascending = sorted(heights);
    layer_of_ = std::move(ascending.layer_of);
    lamella::SliceOptions options = options_for(std::move(ascending.ascending));
    options.region = rules;
    Cancel cancel(throw_on_cancel);
    options.control.stop = cancel.stop_check();
    std::vector<stl_vertex> moved;
    if (!is_identity(transform)) {
        moved = transformed(mesh.vertices, float_transform(transform));
        options.transform = from_host_units();
    }
    slice_into(*scratch_, view(moved.empty() ? mesh.vertices : moved, mesh.indices), options, cancel);
}

Cut::Cut(const indexed_triangle_set& mesh, float height, const Transform3d& transform)
    : scratch_(scratch_pool().take()), layer_of_{0} {
    lamella::SliceOptions options = options_for({height});
    options.control.threads = 1;
    const std::function<void()> never = [] {};
    Cancel cancel(never);
    std::vector<stl_vertex> moved;
    if (!is_identity(transform)) {
        moved = transformed(mesh.vertices, float_transform(transform));
        options.transform = from_host_units();
    }
    const std::vector<float> corners = corners_near(moved.empty() ? mesh.vertices : moved, mesh.indices, height);
    slice_into(*scratch_, lamella::MeshView::soup(corners), options, cancel);
}

Cut::~Cut() {
    scratch_pool().give_back(std::move(scratch_));
}

LayerView Cut::layer(std::size_t height) const {
    const lamella::SliceResult& result = scratch_->result;
    return result.layers.empty() ? LayerView{} : view_of(result, result.layers[layer_of_[height]]);
}

}  // namespace Slic3r::lamella_adapter
