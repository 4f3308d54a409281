// Layers handed to the host while the mesh is being sliced, instead of a result that holds them all.
//
//     struct Areas {
//         double mm3 = 0;
//         void operator()(const lamella::LayerView& view) noexcept {
//             mm3 += view.area_mm2() * (view.layer.top_mm - view.layer.bottom_mm);
//         }
//     } areas;
//     const lamella::LayerSink sink = lamella::LayerSink::to(areas, lamella::SinkOrder::ascending);
//     const lamella::Result<lamella::SliceTotals> totals = lamella::slice_to(sink, mesh);
//     if (totals) {
//         std::printf("%llu layers, %g mm3\n", static_cast<unsigned long long>(totals->layers), areas.mm3);
//     }
//
// The sink gets every layer once, empty ones too, with the bytes that slice() gives. By SinkOrder:
//
//     any        by several threads at once, each layer as soon as it is finished. A thread holds one layer
//     ascending  by one thread at a time, in plane order. The thread that sweeps the lowest unfinished planes hands its
//                layers over one by one; the others put theirs aside, and wait while those take 64 MB:
//
//                planes    0 ... 99   | 100 ... 149 | 150 ...
//                          handed out | put aside   | not begun
//
// Either way memory does not grow with the number of layers: what is held is the crossed triangles (48 bytes each, and at
// most 16 more while they are put in order) and what is put aside.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>

#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"

namespace lamella {

class PreparedMesh;

/// One layer. Valid until the sink returns.
struct LayerView {
    std::uint64_t index = 0;                 ///< of the layer: as in SliceResult::layers
    Layer layer;                             ///< its first_contour is 0
    std::span<const Contour> contours;       ///< their first_point and parent are indices into this view
    std::span<const Point> points;           ///< grid units
    std::span<const PointOrigin> origins;    ///< of each of `points`; empty unless SliceOptions::origins
    std::span<const ClosedGap> closed_gaps;  ///< by `from` and `to`
    double unit_mm = default_unit_mm;

    std::span<const Point> points_of(const Contour& contour) const noexcept {
        return points.subspan(contour.first_point, contour.point_count);
    }
    PointMm to_mm(Point point) const noexcept { return {point.x * unit_mm, point.y * unit_mm}; }
    /// As SliceResult::area_mm2(): NaN where a contour is open.
    double area_mm2() const noexcept;
};

enum class SinkOrder : std::uint8_t {
    any,        ///< by several threads at once, in no order
    ascending,  ///< by one thread at a time, in plane order
};

/// The host's function that takes layers. It may ask StopCheck to end the call, and may itself call the library. A slow sink
/// in ascending order slows the call; it makes it hold no more memory.
struct LayerSink {
    void (*take)(void* context, const LayerView& layer) noexcept = nullptr;
    void* context = nullptr;
    SinkOrder order = SinkOrder::any;

    /// `sink(layer)`, which must be noexcept and must outlive the LayerSink.
    template <class Sink>
    static LayerSink to(Sink& sink, SinkOrder order) noexcept {
        static_assert(std::is_nothrow_invocable_v<Sink&, const LayerView&>,
                      "an exception could not pass through the library");
        return {[](void* context, const LayerView& layer) noexcept { (*static_cast<Sink*>(context))(layer); },
                const_cast<std::remove_const_t<Sink>*>(&sink), order};
    }
};

/// What a slice has handed over.
struct SliceTotals {
    std::uint64_t layers = 0;
    std::uint64_t contours = 0;
    std::uint64_t points = 0;
    std::uint64_t closed_gaps = 0;
    double unit_mm = default_unit_mm;
    double close_gaps_mm = 0;       ///< as SliceResult::close_gaps_mm
    std::uint64_t first_layer = 0;  ///< as SliceResult::first_layer
    std::uint64_t all_layers = 0;   ///< as SliceResult::all_layers
    Array<std::uint64_t> layer_of;  ///< as SliceResult::layer_of
    SliceSummary summary;           ///< its times include those of the sink
};

/// Slices `mesh` as slice() does and hands each layer to `sink`. The bytes of a layer, regions included, are those of
/// slice(); they do not depend on threads, bands or order.
///
/// Time as slice(). Memory: scratch only, from `options.control.memory` as in slice(); see above. A layer alone may be
/// larger than what is put aside: then the thread that has built it holds it. `options.memory_limit_bytes` limits the number
/// of layers only, at 64 bytes each. The sink is called on the library's working threads, while no lock is held that other
/// threads need. Errors: those of slice(), and invalid_argument (no function). After an error the sink has got some layers,
/// in ascending order those below some plane, and gets no more.
Result<SliceTotals> slice_to(const LayerSink& sink, const MeshView& mesh, const SliceOptions& options = {}) noexcept;

Result<SliceTotals> slice_to(const LayerSink& sink, const PreparedMesh& mesh, const SliceOptions& options = {}) noexcept;

/// The same with scratch that is kept.
Result<SliceTotals> slice_to(const LayerSink& sink, const MeshView& mesh, const SliceOptions& options,
                             Workspace& workspace) noexcept;
Result<SliceTotals> slice_to(const LayerSink& sink, const PreparedMesh& mesh, const SliceOptions& options,
                             Workspace& workspace) noexcept;

}  // namespace lamella
