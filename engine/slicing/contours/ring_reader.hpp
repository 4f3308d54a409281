// The points of a plane in walking order, and for each contour the facts that order and nesting need: its start, box and
// area.
//
//     graph.order()     s7 s2 s9 s4 | s1 s5 s3 | ...          slots, contour by contour
//     rings             p7 p2 p9 p4 | p1 p5 p3 | ...          points; a contour's start is its smallest
#pragma once

#include <cstdint>
#include <span>

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/contours/layer_contour.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/contours/slot_origins.hpp"

namespace lamella {

/// The edge that the i-th point of a contour lies on.
using KeyAt = FunctionRef<EndKey(std::uint32_t)>;

/// A closed contour of `count` points. Its start is the smallest (x, y, edge key); where the contour passes through one edge
/// twice, the smaller of the two rotations, by points and then by origins. If consecutive points are equal, the ring is
/// rewritten without repeats. `origins`: of each point, or null.
LayerContour closed_contour(Point* ring, std::uint32_t count, const RingFacts& facts, KeyAt key_at, PointOrigin* origins);

/// A closed contour whose points lie on no mesh edge.
LayerContour closed_contour(std::span<Point> ring, PointOrigin* origins);

/// An open contour. One of equal consecutive points is kept.
LayerContour open_contour(std::span<Point> points, PointOrigin* origins);

/// One per thread; scratch is kept. Contours point into it until the next call.
class RingReader {
public:
    explicit RingReader(const Memory* memory) : kernels_(best_of(kernel_forms())), rings_(memory), origins_(memory) {}

    /// From here on read() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept { pace_.follow(host); }

    /// The contours of `graph`, in walking order; points[slot] is where the slot's edge pierces the plane, origins[slot]
    /// where its segments come from, unless `origins` is null. O(q) for q points. Throws std::bad_alloc.
    void read(const LinkGraph& graph, const Point* points, const SlotOrigins* origins, Vector<LayerContour>& contours);

private:
    LayerContour read_closed(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                             PointOrigin* origins);
    RingFacts trace(const Point* points, std::span<const Slot> slots, Point* ring);
    static LayerContour read_open(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                                  PointOrigin* origins);
    static void read_origins(const LinkGraph& graph, const WalkedContour& walked, const SlotOrigins* by_slot,
                             PointOrigin* origins);

    const Kernels& kernels_;
    Vector<Point> rings_;          // the plane's points in walking order
    Vector<PointOrigin> origins_;  // of rings_
    StopPace pace_;
};

/// The same for closed contours whose points lie in walking order in `rings` already. key_at(i) is the edge that rings[i]
/// lies on; `origins` are those of `rings`, or null.
void read_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                 const Parallel& parallel, Vector<LayerContour>& contours);

}  // namespace lamella
