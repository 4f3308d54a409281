// The sources from which a slice reads its triangles (Algorithm 2):
//
//     soup_source       any mesh, corner by corner; blocks between planes are skipped
//     indexed_source    indexed meshes, each vertex placed once
//     prepared_source   prepared meshes, in the order of their heights
//     listed_triangles  records in their lists already: a file, cut in ranges of layers
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

// A crossed triangle, as the sweep needs it.

/// A triangle that at least one plane cuts. Vertices by height; the long edge runs from `lower` to `upper`, the short edges
/// from `lower` to `middle` and from `middle` to `upper`. A segment starts on the edge that its face runs down
/// and ends on the edge that it runs up, so the solid is on its left.
struct CrossedTriangle {
    GridVertex lower;
    GridVertex middle;
    GridVertex upper;
    union {
        std::uint32_t triangle;  ///< index in the input
        PlaneIndex first;        ///< of ListedTriangles, which have no input: the first plane that cuts it
    };
    std::uint32_t middle_and_source;  ///< first plane above `middle`, and in the top bit whether the long edge is the source
    PlaneIndex last;                  ///< one past the last plane that cuts it

    PlaneIndex middle_plane() const noexcept { return middle_and_source & 0x7FFFFFFFU; }
    bool long_edge_is_source() const noexcept { return (middle_and_source >> 31) != 0; }
};
static_assert(sizeof(CrossedTriangle) == 48, "the memory bound counts 48 bytes a crossed triangle");

/// The edge from a triangle's lowest vertex to its highest.
inline MeshEdge long_edge(const CrossedTriangle& t) noexcept {
    return MeshEdge::between(t.lower, t.upper);
}

/// The edge above the middle vertex, or the one below it. A branch would be mispredicted half of the time; the two lie side
/// by side in memory, so the address is computed instead.
inline MeshEdge short_edge(const CrossedTriangle& t, bool above_middle) noexcept {
    static_assert(offsetof(CrossedTriangle, lower) == 0 && offsetof(CrossedTriangle, middle) == sizeof(GridVertex) &&
                  offsetof(CrossedTriangle, upper) == 2 * sizeof(GridVertex));
    const char* at = reinterpret_cast<const char*>(&t) + sizeof(GridVertex) * static_cast<std::size_t>(above_middle);
    MeshEdge edge;
    for (std::uint64_t& word : edge.words) {
        std::memcpy(&word, at, sizeof word);
        at += sizeof word;
    }
    return edge;
}

/// The order of three vertices by height, and whether it is an odd permutation of them: then the facet walks the long edge
/// upwards. Indexed by (z1 < z0) + 2 (z2 < z1) + 4 (z2 < z0): a table instead of branches, which would be mispredicted.
struct HeightOrder {
    std::uint8_t lower, middle, upper, odd;
};
inline constexpr HeightOrder height_orders[8] = {
    {0, 1, 2, 0}, {1, 0, 2, 1}, {0, 2, 1, 1}, {0, 1, 2, 0}, {0, 1, 2, 0}, {1, 2, 0, 0}, {2, 0, 1, 0}, {2, 1, 0, 1},
};

inline const HeightOrder& height_order_of(std::int32_t z0, std::int32_t z1, std::int32_t z2) noexcept {
    return height_orders[(z1 < z0 ? 1U : 0U) + (z2 < z1 ? 2U : 0U) + (z2 < z0 ? 4U : 0U)];
}
inline const HeightOrder& height_order_of(const GridTriangle& v) noexcept {
    return height_order_of(v[0].z, v[1].z, v[2].z);
}

/// The top bit of CrossedTriangle::middle_and_source.
inline std::uint32_t source_bit(const HeightOrder& order) noexcept {
    return order.odd != 0 ? 0U : 1U << 31;
}

/// A record without its planes.
inline CrossedTriangle order_by_height(const GridTriangle& v, std::uint32_t triangle) noexcept {
    const HeightOrder& order = height_order_of(v);
    return {v[order.lower], v[order.middle], v[order.upper], {triangle}, source_bit(order), 0};
}

/// The numbers that the input gives to the edges of a crossed triangle: edge e leads from corner e to the next.
///
///     long edge      lower   middle   upper     lower short edge   upper short edge   long edge
///     walked down    c       c + 1    c + 2     c                  c + 1              c + 2
///     walked up      c       c + 2    c + 1     c + 2              c + 1              c            all modulo 3
struct EdgeNumbers {
    std::uint8_t lower_short;
    std::uint8_t upper_short;
    std::uint8_t long_edge;

    EdgeNumbers(const CrossedTriangle& t, std::uint8_t lowest_corner) noexcept {
        const std::uint8_t second = next(lowest_corner);
        const std::uint8_t third = next(second);
        lower_short = t.long_edge_is_source() ? lowest_corner : third;
        upper_short = second;
        long_edge = t.long_edge_is_source() ? third : lowest_corner;
    }

private:
    static std::uint8_t next(std::uint8_t corner) noexcept {
        return corner == 2 ? std::uint8_t{0} : static_cast<std::uint8_t>(corner + 1);
    }
};

/// The origin of the segment in which a plane cuts the triangle, as its facet runs.
inline PointOrigin origin_of(const CrossedTriangle& t, std::uint8_t lowest_corner, bool above_middle) noexcept {
    const EdgeNumbers edges(t, lowest_corner);
    const std::uint8_t short_edge = above_middle ? edges.upper_short : edges.lower_short;
    return t.long_edge_is_source() ? PointOrigin{t.triangle, 0, edges.long_edge, short_edge}
                                   : PointOrigin{t.triangle, 0, short_edge, edges.long_edge};
}

// Each triangle is put in the list of the first plane that cuts it (Algorithm 2), concurrently, by count, prefix sum and
// scatter. There are no locks. Only the order within one plane's list depends on threads, and nothing depends on that order.
//
// The input is read twice after its bounds are measured. The first read counts; the second writes the triangles that are
// cut as 48-byte records in plane order. Records of a large mesh are written and swept tier by tier, so that a third of them
// are in memory at once; those that reach into a tier from below come last:
//
//     planes         0        1      2  ...
//     records     [ t7 t2 | t9 t4 | t1 | ...     list_begin = 0, 2, 4, 5, ...
//
//     tier        [ 0 ... 9 ]  [ 10 ... 19 ]  [ 20 ... 31 ]
//     records     [ 4 MB    ]  [ 4 MB    | reaching in ]      list_of(10) = 0

/// A vertex on the grid, and the first plane above it.
struct PlacedVertex {
    GridVertex at;
    PlaneIndex above;
};
static_assert(sizeof(PlacedVertex) == 16, "compared as one vector");

/// What the first read keeps of 64 triangles.
struct CrossedBlock {
    std::uint64_t mask = 0;                                        ///< bit t: planes cut triangle t
    PlaneRange planes{std::numeric_limits<PlaneIndex>::max(), 0};  ///< that cut any

    void add(PlaneIndex first, PlaneIndex end) noexcept {
        planes = {std::min(planes.first, first), std::max(planes.end, end)};
    }
};

struct Buckets {
    explicit Buckets(const Memory* memory) : memory(memory) {}

    const Memory* memory;
    Array<CrossedTriangle> records{memory};      ///< of a tier, by first plane
    Array<std::uint8_t> lowest_corners{memory};  ///< corner of each record that is its lowest, where origins are asked for
    Array<std::uint32_t> list_begin{memory};     ///< k + 1: where each plane's list begins, were all records in memory
    std::uint32_t tier_begin = 0;                ///< the same of the tier
    Array<std::uint32_t> segments{memory};       ///< k: triangles that each plane cuts
    std::uint64_t segment_count = 0;             ///< m
    std::uint64_t degenerate = 0;

    /// Where the list of a plane of the tier, or of the one after it, begins in `records`.
    std::uint32_t list_of(PlaneIndex plane) const noexcept { return list_begin[plane] - tier_begin; }
    /// The triangles that the plane cuts and that entered below it.
    std::uint32_t reaching_into(PlaneIndex plane) const noexcept {
        return segments[plane] - (list_begin[plane + 1] - list_begin[plane]);
    }

    // Scratch of sources:
    Array<CrossedBlock> crossed{memory};    // so that the second read skips what is not cut; empty: is not read again
    Array<std::uint32_t> counters{memory};  // per thread and plane
    BlockTable blocks{memory};              // of soups
    Array<std::uint8_t> used{memory};       // of indexed meshes: 1 where a triangle has the vertex; empty: all can be placed
    Array<PlacedVertex> vertices{memory};   // of indexed meshes: those that can be placed
    Array<std::uint32_t> touched{memory};   // of prepared meshes: blocks that planes pass through
};

/// A record whose triangle reaches beyond the planes that its first plane is swept with.
struct Reaching {
    std::uint32_t record;
    PlaneIndex first;
    PlaneIndex last;  ///< one past
};

/// True where no plane comes between the lowest and the highest vertex of the block.
inline bool lies_between_planes(const TriangleBlock& block, double unit_mm, const PlaneSet& planes) noexcept {
    return !planes.any_between(to_even_grid(block.low_mm, unit_mm), to_even_grid(block.high_mm, unit_mm));
}

/// All that a source works with, which is kept from call to call.
struct SourceTools {
    const Parallel& parallel;
    const PlaneSet& planes;
    Buckets& buckets;
    InstructionSet instructions;
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
    virtual ~TriangleSource() = default;
    TriangleSource(const TriangleSource&) = delete;
    TriangleSource& operator=(const TriangleSource&) = delete;

    /// The box of the placed triangles, of which there is one at least. `asked_mm`: the unit asked for, or 0.
    virtual Bounds measure(double asked_mm) = 0;
    /// First read: degenerate triangles, the size of every list, and m, before anything of that size is allocated. May be
    /// called again after the planes were.
    virtual void count(double unit_mm) = 0;
    /// Second read: the records of triangles that planes of the tier cut, and, in no order, those of them that are cut by
    /// planes from reach_end[first plane] on too, or reach into the tier from below: into `reaching`, which must have room
    /// for all; returns how many they are. `reach_end` has k + 1 numbers. Where `origins` are asked for,
    /// Buckets::lowest_corners too.
    virtual std::size_t scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                                bool origins) = 0;
    /// All bands are swept: what was lent goes back.
    virtual void give_back() noexcept {}

    const SourceInfo info;

protected:
    TriangleSource(const SourceInfo& own, const SourceTools& tools) noexcept
        : info(own),
          parallel_(tools.parallel),
          planes_(tools.planes),
          buckets_(tools.buckets),
          instructions_(tools.instructions) {}

    const Parallel& parallel_;
    const PlaneSet& planes_;
    Buckets& buckets_;
    InstructionSet instructions_;
};

}  // namespace lamella
