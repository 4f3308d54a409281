// Where layers go: a result that holds them all, a sink that takes them while the mesh is being cut, the host's own arrays.
//
//     lamella::Slicer slicer;
//     double mm3 = 0;
//     auto add = [&](const lamella::LayerView& layer) noexcept {
//         mm3 += layer.area_mm2() * (layer.top_mm - layer.bottom_mm);
//     };
//     const lamella::Result<lamella::SliceInfo> info = slicer.slice_to(lamella::LayerSink{.take = add}, mesh);
//
// A sink gets every layer once, empty ones too, with the bytes that a result has. By SinkOrder:
//
//     ascending  by one thread at a time, in plane order. The thread that sweeps the lowest unfinished planes hands its
//                layers over one by one; the others put theirs aside, and wait once they hold their share of 64 MB:
//
//                planes    0 ... 99   | 100 ... 149 | 150 ...
//                          handed out | put aside   | not begun
//     any        by several threads at once, each layer as soon as it is finished. A thread holds one layer
//
// Either way memory does not grow with the number of layers: what is held is the crossed triangles (48 bytes each, and at
// most 16 more while they are put in order) and what is put aside. Of parts, the slice of each is held before the first
// layer is handed over; of faces, 8 bytes for each piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "lamella/context.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"

namespace lamella {

enum class SinkOrder : std::uint8_t {
    ascending,  ///< by one thread at a time, in plane order
    any,        ///< by several threads at once, in no order
};

/// The host's functions that take layers. They may ask the context's stop to end the call, and may themselves call the
/// library; they are called while no lock is held that other threads need. After an error the sink has got some layers, in
/// ascending order those below some plane, and gets no more.
struct LayerSink {
    Callback<void(const LayerView&)> take{};
    SinkOrder order = SinkOrder::ascending;
    Callback<void(const SliceInfo&)> begin{};  ///< before the first layer: frame, grid, box, number of layers
};

/// Memory of the host that a slice is written to. Layers, contours and points are those of a result in its order, and index
/// each other in the same way. Points of type i32, packed and at scale 1, are swept straight to their place; others are
/// converted while they are still in the cache. Nothing is written beyond a capacity, nor between strided points. After an
/// error what the arrays hold is unspecified.
struct HostArrays {
    void* points = nullptr;  ///< x, then y, for each point; any alignment
    std::uint64_t point_capacity = 0;
    Number point_type = Number::i32;  ///< i32, i64, f32 or f64
    std::size_t point_stride = 0;     ///< bytes from a point to the next, of which only x and y are written; 0: packed
    /// The host's units in a grid unit. Integers: a whole number from 1 to 2^53, of which coordinates are exact multiples.
    /// Floats: any number above 0; the product in double is rounded to the type. With SliceInfo::grid_mm, points are in mm.
    double scale = 1;
    std::span<Contour> contours{};
    std::span<Layer> layers{};
    std::span<Stitch> stitches{};      ///< empty: they are only counted
    std::span<PointOrigin> origins{};  ///< room for `point_capacity`, written where SliceOptions::origins; empty: none
};

/// Where layers go, as a parameter only.
class Destination {
public:
    Destination(SliceResult& result) noexcept : result_(&result) {}       // NOLINT(google-explicit-constructor)
    Destination(const LayerSink& sink) noexcept : sink_(&sink) {}         // NOLINT(google-explicit-constructor)
    Destination(const HostArrays& arrays) noexcept : arrays_(&arrays) {}  // NOLINT(google-explicit-constructor)

    // What it was made of, for the library: the one that is not null.
    SliceResult* result() const noexcept { return result_; }
    const LayerSink* sink() const noexcept { return sink_; }
    const HostArrays* arrays() const noexcept { return arrays_; }

private:
    SliceResult* result_ = nullptr;
    const LayerSink* sink_ = nullptr;
    const HostArrays* arrays_ = nullptr;
};

}  // namespace lamella
