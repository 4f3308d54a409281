// The points of a plane in walking order, and for each contour the facts that order and nesting need: its start, box and
// area.
//
//     graph.order()     s7 s2 s9 s4 | s1 s5 s3 | ...          slots, contour by contour
//     rings             p7 p2 p9 p4 | p1 p5 p3 | ...          points; a contour's start is its smallest
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/contours/slot_table.hpp"
#include "slicing/nesting/path.hpp"

namespace lamella {

/// One per thread; scratch is kept. Contours point into it until the next call.
class RingReader {
public:
    explicit RingReader(Worker& worker) noexcept : worker_(worker) {}

    /// The contours of `graph`, in walking order; points[slot] is where the slot's edge pierces the plane, origins[slot]
    /// where its segments come from, unless `origins` is null. O(q) for q points. Throws std::bad_alloc.
    void read(const LinkGraph& graph, const Point* points, const SlotOrigins* origins, Vector<Path>& contours);

private:
    Path read_closed(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                     PointOrigin* origins);
    RingFacts trace(const Point* points, std::span<const Slot> slots, Point* ring);
    static Path read_open(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                          PointOrigin* origins);
    static void read_origins(const LinkGraph& graph, const WalkedContour& walked, const SlotOrigins* by_slot,
                             PointOrigin* origins);

    Worker& worker_;
    const Kernels& kernels_ = best_of(kernel_forms());
    Vector<Point> rings_{worker_.memory()};          // the plane's points in walking order
    Vector<PointOrigin> origins_{worker_.memory()};  // of rings_
};

/// The same for closed contours whose points lie in walking order in `rings` already. key_at(i) is the edge that rings[i]
/// lies on; `origins` are those of `rings`, or null.
void read_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                 const Parallel& parallel, Vector<Path>& contours);

}  // namespace lamella
