// The sources from which a slice reads its triangles (Algorithm 2):
//
//     soup_source       any mesh, corner by corner; blocks between planes are skipped
//     indexed_source    indexed meshes, each vertex placed once
//     prepared_source   prepared meshes, triangles on the grid already
//     listed_triangles  records in their lists already: a file, cut in ranges of layers
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "lamella/mesh.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// All that a source works with, which is kept from call to call.
struct SourceTools {
    const Parallel& parallel;
    const PlaneSet& planes;
    Buckets& buckets;
};

/// All that is known of triangles before they are read.
struct SourceInfo {
    std::uint64_t triangles;
    const SharedFrame* frame = nullptr;  ///< null: their own box chooses grid and planes
    Number number = Number::f64;         ///< heights are rounded to it where there is no frame
};

/// Fills in the buckets by functions that are called in their order; planes are built after measure(), and bands cut after
/// count(). A virtual call a stage, none a triangle. Throws Refused, Stopped, std::bad_alloc.
class TriangleSource {
public:
    TriangleSource(const TriangleSource&) = delete;
    TriangleSource& operator=(const TriangleSource&) = delete;

    /// The box of the placed triangles, of which there is one at least. `asked_mm`: the unit asked for, or 0.
    virtual Bounds measure(double asked_mm) = 0;
    /// First read: degenerate triangles, the size of every list, and m, before anything of that size is allocated. May be
    /// called again after the planes were.
    virtual void count(double unit_mm) = 0;
    /// Second read: the records, and, in no order, those of them whose triangles are cut by planes from reach_end[first
    /// plane] on too: into `reaching`, which must have room for all; returns how many they are. `reach_end` has k + 1
    /// numbers. Where `origins` are asked for, Buckets::lowest_corners too.
    virtual std::size_t scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) = 0;
    /// All bands are swept: what was lent goes back.
    virtual void give_back() noexcept {}

    const SourceInfo info;

protected:
    TriangleSource(const SourceInfo& own, const SourceTools& tools) noexcept
        : info(own), parallel_(tools.parallel), planes_(tools.planes), buckets_(tools.buckets) {}
    ~TriangleSource() = default;

    const Parallel& parallel_;
    const PlaneSet& planes_;
    Buckets& buckets_;
};

}  // namespace lamella
