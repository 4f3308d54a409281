// The host's meshes, heights and cancelling as the library takes them. Part of the adapter, under its licence:
// AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <lamella/slice.hpp>
#include <libslic3r/TriangleMesh.hpp>
#include <libslic3r/TriangleMeshSlicer.hpp>
#include <memory>
#include <vector>

#include "contours.hpp"

namespace Slic3r::lamella_adapter {

/// The host cancels by a function that throws. The library asks, so what was thrown is kept until the call is over.
class Cancel {
public:
    explicit Cancel(const std::function<void()>& throw_on_cancel) : throw_on_cancel_(throw_on_cancel) {}

    lamella::StopCheck stop_check() noexcept;
    /// Throws what the host's function threw while the library asked, if it did.
    void rethrow() const;

private:
    bool requested() noexcept;

    const std::function<void()>& throw_on_cancel_;
    std::atomic<bool> thrown_ = false;
    std::exception_ptr exception_;
};

/// What the library keeps from call to call.
struct Scratch {
    lamella::Workspace workspace;
    lamella::SliceResult result;
};

/// A mesh cut at the host's heights.
class Cut {
public:
    /// Throws what the host's cancelling throws, and Slic3r::SlicingError where the library refuses the mesh.
    Cut(const indexed_triangle_set& mesh, const std::vector<float>& heights, const Transform3d& transform,
        const lamella::RegionRules& rules, const std::function<void()>& throw_on_cancel);
    /// At one height, on the calling thread.
    Cut(const indexed_triangle_set& mesh, float height, const Transform3d& transform);
    ~Cut();
    Cut(const Cut&) = delete;
    Cut& operator=(const Cut&) = delete;

    /// What the plane at `heights[height]` cuts.
    LayerView layer(std::size_t height) const;

private:
    std::unique_ptr<Scratch> scratch_;
    std::vector<std::size_t> layer_of_;  ///< by height
};

}  // namespace Slic3r::lamella_adapter
