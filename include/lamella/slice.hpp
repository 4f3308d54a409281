// Slicing: a Source is sliced by SliceOptions within a Context to a Destination.
//
//     const std::vector<double> soup = {0, 0, 0, 0, 9, 0, 9, 0, 0,   // nine numbers a triangle,
//                                       0, 0, 0, 9, 0, 0, 0, 0, 9,   // counter-clockwise as seen from outside
//                                       9, 0, 0, 0, 9, 0, 0, 0, 9,
//                                       0, 9, 0, 0, 0, 0, 0, 0, 9};
//     lamella::Slicer slicer;
//     const auto sliced = slicer.slice(lamella::MeshView::soup(soup), {.layer_height_mm = 0.5});
//     if (sliced) {
//         for (const lamella::LayerView layer : *sliced) {
//             std::printf("z %g mm: %g mm2\n", layer.plane_mm, layer.area_mm2());
//         }
//     }
//
// Any source goes to any destination, by the same options, with the same bytes. Only faces (LayerContent) want one
// mesh in memory, and a file has no origins.
//
//     Source        what is cut       MeshView, PreparedMesh, a list of Parts, a file          source.hpp
//     SliceOptions  what is asked     may change the bytes; the result repeats them            options.hpp
//     Context       what is lent      threads, memory, stop, progress; changes no byte         context.hpp
//     Destination   where layers go   SliceResult, LayerSink, HostArrays                       destination.hpp
//
// n triangles, k planes, m crossings, q points in a layer: O(n + k + m) for uniform planes, O(n log k + k + m) otherwise,
// and O(q log q) per layer for ordering and nesting. A prepared mesh of which t triangles lie near planes: O(n / 4096 + t +
// k + m). Memory: O(n + k + m). Regions take O((q + c) log (q + c)) per layer for c contacts, and a thread O(q + c) memory.
//
// Source: the paper's Algorithms 1 to 3 (slicing) and 4 (contours), with orientation and nesting, in parallel.
#pragma once

#include <cstddef>
#include <memory>

#include "lamella/context.hpp"
#include "lamella/destination.hpp"
#include "lamella/error.hpp"
#include "lamella/options.hpp"
#include "lamella/result.hpp"
#include "lamella/source.hpp"

namespace lamella {

namespace detail {
struct SlicerImpl;
}  // namespace detail

/// Slices again and again with the scratch of the call before: the second slice of a similar mesh touches no fresh page. One
/// for each call at the same time.
class Slicer {
public:
    Slicer() noexcept;
    Slicer(Slicer&&) noexcept;
    Slicer& operator=(Slicer&&) noexcept;
    ~Slicer();

    /// Cuts `from` at the planes of the options. A mesh that no plane meets is no error: uniform layers then give no layer,
    /// given heights give empty ones.
    ///
    /// A result is refused as too large by what is known before anything is linked: 64 bytes a layer, a point of 8 bytes a
    /// crossing and its origin of 8 where asked for, and a contour of 48 in each layer that has crossings. How many contours
    /// more there are is known only once they are walked: a result of closed contours is at most three times as large as
    /// that, one of open polylines of a single segment each eight times. What the host's memory does not hold then is
    /// out_of_memory. Errors: invalid_argument, empty_mesh (unless SliceOptions::allow_empty), bad_coordinate (with the
    /// triangle), bad_planes (with the plane, or for layers that the plan does not have), result_too_large, out_of_memory,
    /// cancelled; of several parts the message begins with "part N: " where one is to blame.
    Result<SliceResult> slice(const Source& from, const SliceOptions& options = {}, const Context& context = {}) noexcept;

    /// The same to any destination. A result is filled anew, and its memory used again; on error it is left valid but
    /// unspecified. To a sink, the context's limit counts 80 bytes a uniform layer. To arrays: invalid_argument where one is
    /// null though it has a capacity, a stride is shorter than a point, or coordinates times the scale may exceed the type;
    /// result_too_large where a capacity is too small. More layers than that are refused before anything is cut; of
    /// contours, points and stitches the message says how many are needed once they are known.
    Result<SliceInfo> slice_to(const Destination& to, const Source& from, const SliceOptions& options = {},
                               const Context& context = {}) noexcept;

    /// What is known before anything is cut, in a tenth of the time of slicing or less: O(n + k), two reads of the mesh.
    /// `layers` and `segments` are exact; contours are at most `segments`, points at most twice that (of faces five times),
    /// and of a mesh without open polylines at most `segments`. Rules of regions may make more: slice_to() then says what
    /// was needed.
    Result<SliceInfo> outline(const Source& from, const SliceOptions& options = {}, const Context& context = {}) noexcept;

    /// Starts threads, and takes and touches scratch for a mesh of which so many triangles are cut, so that the first slice
    /// need not: 48 bytes a triangle, beyond a million for a third of them, and up to 32 MB for small blocks, unless memory
    /// is the host's. Errors: invalid_argument (negative threads), out_of_memory, cancelled.
    Status make_ready(std::uint64_t triangles, const Context& context = {}) noexcept;

    /// The memory that it holds.
    std::size_t bytes() const noexcept;
    /// Gives all memory back if the last call needed much less of it, as after one of a much larger mesh: at most about
    /// twice what a new Slicer would hold after the last call stays.
    void trim() noexcept;
    /// Gives all memory back: before the host's Memory that it came from goes. Where the memory of a call is another than
    /// that of the call before, what is kept of the other is given back first.
    void reset() noexcept;

private:
    friend struct detail::SlicerImpl;
    std::unique_ptr<detail::SlicerImpl> impl_;
};

/// One call, without scratch that is kept.
Result<SliceResult> slice(const Source& from, const SliceOptions& options = {}, const Context& context = {}) noexcept;

}  // namespace lamella
