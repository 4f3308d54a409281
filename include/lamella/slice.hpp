// Slicing a mesh that is in memory.
//
//     const std::vector<double> soup = {0, 0, 0, 0, 9, 0, 9, 0, 0,   // nine numbers a triangle,
//                                       0, 0, 0, 9, 0, 0, 0, 0, 9,   // counter-clockwise as seen from outside
//                                       9, 0, 0, 0, 9, 0, 0, 0, 9,
//                                       0, 9, 0, 0, 0, 0, 0, 0, 9};
//     lamella::SliceOptions options;
//     options.plan.spacing = lamella::UniformLayers{.layer_height_mm = 0.5};
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(lamella::MeshView::soup(soup), options);
//     if (sliced) {
//         for (const lamella::Layer& layer : sliced->layers) {
//             std::printf("z %g mm: %g mm2\n", layer.plane_mm, sliced->area_mm2(layer));
//         }
//     }
//
// Source: the paper's Algorithms 1 to 3 (slicing) and 4 (contours), with orientation and nesting, in parallel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/experiments.hpp"
#include "lamella/mesh.hpp"
#include "lamella/planes.hpp"
#include "lamella/region.hpp"
#include "lamella/result.hpp"

namespace lamella {

namespace detail {
struct WorkspaceParts;
}  // namespace detail

/// What is done where the mesh does not fit a grid of the unit asked for.
enum class UnitFit : std::uint8_t {
    as_asked,           ///< bad_coordinate
    coarser_if_needed,  ///< the unit is doubled until it does; SliceSummary::unit_doublings says how often
};

/// Asked for as the length up to which gaps are closed: a hundredth of the diagonal of the mesh's box, after the transform;
/// of several parts each has its own. No joint longer than a tenth of that crosses a contour of its layer or a shorter
/// joint. For meshes that lack faces here and there, as most bones of an atlas do:
///
///       .-------------.     .-------------.      .----------.    Ends are joined nearest first, an end to a start: `ab`.
///       |             |     |             |      |    ||    |    Where a wall lies between them, they stay open: `cd`.
///       '----a   b----'     '----a---b----'      '---c||d---'    Each joint is listed in SliceResult::closed_gaps.
inline constexpr double gaps_by_mesh = -1;

struct SliceOptions {
    LayerPlan plan{};
    /// Cut these layers of the plan only: they have the bytes that they have in the whole, grid and planes being chosen for
    /// the whole mesh. SliceResult::first_layer says where they lie.
    LayerRange layers{};
    double unit_mm = 0;  ///< grid unit; 0 chooses the default, unit_by_box the finest (see grid.hpp)
    UnitFit unit_fit = UnitFit::as_asked;
    /// A mesh without triangles, or of which none is left on the grid, is no error: given heights give empty layers, other
    /// plans none. The box of a mesh without triangles is a point at zero.
    bool allow_empty = false;
    Transform transform{};  ///< from the mesh's coordinates to mm and to the slicing direction, which is z
    RegionRules region{};
    double close_gaps_mm = 0;  ///< join ends of open polylines at most so far apart; 0 joins none; or gaps_by_mesh
    GapSense gap_sense = GapSense::kept;   ///< which ends are joined
    bool origins = false;                  ///< say which triangle each contour edge comes from: SliceResult::origins
    std::uint64_t memory_limit_bytes = 0;  ///< larger results are refused before allocation; 0: half of physical memory
    Control control{};
    Tuning tuning{};  ///< for experiments
};

/// Scratch memory kept from call to call: the second slice of a similar mesh touches no fresh page. One per concurrent call.
class Workspace {
public:
    Workspace() noexcept;
    ~Workspace();
    Workspace(Workspace&&) noexcept;
    Workspace& operator=(Workspace&&) noexcept;
    /// The memory that it holds.
    std::size_t bytes() const noexcept;
    /// Gives back what the last call did not need, as after one of a much larger mesh: what stays is at most about twice
    /// what a new workspace would hold after that call.
    void trim() noexcept;
    /// Gives all memory back: before the host's Memory that it came from goes.
    void reset() noexcept;

private:
    friend struct detail::WorkspaceParts;
    std::unique_ptr<detail::WorkspaceParts> parts_;
};

/// Slices `mesh` at the planes of `options.plan`. A mesh that no plane meets is no error: uniform layers then give no layer,
/// given heights give empty ones.
///
/// n triangles, k planes, m crossings, q points in a layer: O(n + k + m) for uniform planes, O(n log k + k + m) otherwise,
/// and O(q log q) per layer for ordering and nesting. Memory: O(n + k + m). Regions take O((q + c) log (q + c)) per layer
/// for c contacts, and a thread O(q + c) memory; see region.hpp.
///
/// The result and all scratch that grows with the mesh, that of regions included, come from `options.control.memory`, with
/// these exceptions, which take operator new: the list of contours in a plane that all threads work on together; the heights
/// of planes that are not uniform; the fill rules by layer that the result repeats; and objects of a fixed size, some a
/// call, a thread and a band.
///
/// A result is refused as too large by what is known before anything is linked: 64 bytes a layer, a point of 8 bytes a
/// crossing and its origin of 8 where asked for, and a contour of 48 in each layer that has crossings. How many contours
/// more there are is known only once they are walked. A closed contour that has an area has three points or more, so that
/// such a result is at most three times as large as that; one of open polylines of a single segment each, eight times. What
/// the host's memory does not hold then is out_of_memory. Errors: invalid_argument, empty_mesh (unless
/// SliceOptions::allow_empty), bad_coordinate (with the triangle), bad_planes (with the plane, or for
/// SliceOptions::layers that the plan does not have), result_too_large,
/// out_of_memory, cancelled.
Result<SliceResult> slice(const MeshView& mesh, const SliceOptions& options = {}) noexcept;

/// The same into an existing result and with scratch that is kept: for programs that slice again and again. Where
/// `options.control.memory` differs from call to call, what is kept of the other memory is given back first. On error
/// `result` is left valid but unspecified.
Status slice(const MeshView& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept;

}  // namespace lamella
