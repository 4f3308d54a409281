// A slice written straight into the host's own arrays, in the host's own number type and scale.
//
//     const lamella::SliceOptions options;
//     const lamella::Result<lamella::OutputBounds> bounds = lamella::bound_output(mesh, options);
//     if (bounds) {
//         std::vector<std::int64_t> xy(2 * bounds->points);  // here 256 of the host's units to a grid unit
//         std::vector<lamella::Contour> contours(bounds->contours);
//         std::vector<lamella::Layer> layers(bounds->layers);
//         const lamella::HostOutput output{.type = lamella::PointType::i64,
//                                          .points = xy.data(),
//                                          .point_capacity = bounds->points,
//                                          .scale = 256,
//                                          .contours = contours.data(),
//                                          .contour_capacity = contours.size(),
//                                          .layers = layers.data(),
//                                          .layer_capacity = layers.size()};
//         const lamella::Result<lamella::SliceTotals> totals = lamella::slice_into(output, mesh, options);
//         if (totals) {
//             xy.resize(2 * totals->points);
//             contours.resize(totals->contours);
//         }
//     }
//
// Layers, contours and points are those of slice() in its order, and index each other in the same way. Points of type i32,
// packed and at scale 1, are swept straight to their place; others are converted while they are still in the cache.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "lamella/sink.hpp"
#include "lamella/slice.hpp"

namespace lamella {

class PreparedMesh;

/// What x and y of a point are written as.
enum class PointType : std::uint8_t { i32, i64, f32, f64 };

/// Memory of the host that a slice is written to.
struct HostOutput {
    PointType type = PointType::i32;
    void* points = nullptr;  ///< x, then y, for each point; any alignment
    std::uint64_t point_capacity = 0;
    std::size_t stride = 0;  ///< bytes from a point to the next, of which only x and y are written; 0: packed
    /// The host's units in a grid unit. Integers: a whole number from 1 to 2^53, of which coordinates are exact multiples.
    /// Floats: any number above 0; the product in double is rounded to the type. With the unit of OutputBounds, points are
    /// in mm.
    double scale = 1;
    Contour* contours = nullptr;
    std::uint64_t contour_capacity = 0;
    Layer* layers = nullptr;
    std::uint64_t layer_capacity = 0;
    ClosedGap* closed_gaps = nullptr;  ///< null: they are only counted
    std::uint64_t closed_gap_capacity = 0;
    PointOrigin* origins = nullptr;  ///< room for `point_capacity`, packed, written where SliceOptions::origins; null: none
};

/// How much a slice may need.
struct OutputBounds {
    std::uint64_t layers = 0;    ///< exact
    std::uint64_t contours = 0;  ///< at most the number of segments
    std::uint64_t points = 0;    ///< at most twice the number of segments
    std::uint64_t segments = 0;  ///< a mesh without open polylines has no more points than that
    /// False where rules of regions make contours: crossings and corners that are cut off add points, of which the bounds
    /// know nothing. slice_into() says what was needed where it was more.
    bool are_certain = true;
    double unit_mm = default_unit_mm;  ///< of the slice
};

/// Counts what slicing `mesh` may give, without slicing it. O(n + k): two reads of the mesh, a tenth of the time of slicing
/// or less. Memory and errors as in slice(), but for result_too_large.
Result<OutputBounds> bound_output(const MeshView& mesh, const SliceOptions& options = {}) noexcept;
Result<OutputBounds> bound_output(const PreparedMesh& mesh, const SliceOptions& options = {}) noexcept;
Result<OutputBounds> bound_output(const MeshView& mesh, const SliceOptions& options, Workspace& workspace) noexcept;
Result<OutputBounds> bound_output(const PreparedMesh& mesh, const SliceOptions& options, Workspace& workspace) noexcept;

/// Slices `mesh` as slice() does, into `output`: one pass, whatever the type. Only scratch is allocated, from
/// `options.control.memory` as in slice(); points that are converted pass through buffers of at most two bands a thread.
///
/// Nothing is written beyond a capacity, nor between strided points. Within it, what lies beyond the totals is unspecified.
/// Errors: those of slice(), and
///
///     invalid_argument  an array that is null though it has a capacity, a stride shorter than a point, a scale out of
///     range,
///                       coordinates that times the scale may exceed the type; all before anything is cut
///     result_too_large  a capacity is too small. More layers than that are refused before anything is cut; of contours,
///                       points and gaps the message says how many are needed once they are known
///
/// After an error what the arrays hold is unspecified.
Result<SliceTotals> slice_into(const HostOutput& output, const MeshView& mesh, const SliceOptions& options = {}) noexcept;
Result<SliceTotals> slice_into(const HostOutput& output, const PreparedMesh& mesh,
                               const SliceOptions& options = {}) noexcept;
Result<SliceTotals> slice_into(const HostOutput& output, const MeshView& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept;
Result<SliceTotals> slice_into(const HostOutput& output, const PreparedMesh& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept;

}  // namespace lamella
