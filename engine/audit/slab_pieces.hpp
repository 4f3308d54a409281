// The pieces of the surface within a few slabs. A piece that does not join two planes has a vertex in its slab, and all its
// vertices there are joined by edges that stay in the slab: so it is a set of vertices, and the edges that leave the slab
// show which planes it meets.
#pragma once

#include <cstdint>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/number_table.hpp"
#include "base/numbers.hpp"
#include "lamella/audit.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// A triangle, and the slab of each vertex: the first plane above it.
struct SlabTriangle {
    GridTriangle corners;
    std::array<PlaneIndex, 3> slabs;

    SlabTriangle(const GridTriangle& t, const PlaneSet& planes) noexcept
        : corners(t), slabs{planes.first_above(t[0].z), planes.first_above(t[1].z), planes.first_above(t[2].z)} {}

    bool within_one() const noexcept { return slabs[0] == slabs[1] && slabs[1] == slabs[2]; }
    bool is_horizontal() const noexcept { return corners[0].z == corners[1].z && corners[1].z == corners[2].z; }
};

/// Goes through one range of slabs after another; its memory is kept.
class SlabPieces {
public:
    SlabPieces(const PlaneSet& planes, double grid_mm) noexcept : planes_(planes), grid_mm_(grid_mm) {}

    /// Begins anew, for slabs [first, end) and about so many triangles.
    void begin(PlaneIndex first, PlaneIndex end, std::size_t triangles);
    /// To be called once for every triangle with a vertex in the range, in any order.
    void add(const SlabTriangle& triangle);
    /// Appends what the range holds; the slabs from below, their pieces by kind and place.
    void finish(std::vector<Slab>& slabs, std::vector<SurfacePiece>& pieces);

private:
    static constexpr std::uint32_t none = 0xffffffff;
    static constexpr std::uint8_t meets_below = 1;
    static constexpr std::uint8_t meets_above = 2;

    /// A vertex, and the edges that leave it.
    struct Node {
        GridVertex vertex;
        PlaneIndex slab;
        std::uint32_t triangles;  ///< within the slab, whose first vertex it is
        std::uint32_t piece;      ///< in the root of a set, once all edges are in
        std::uint8_t meets;       ///< in a root then: what the whole set meets
    };
    /// A set that does not join two planes.
    struct Piece {
        GridVertex lowest;
        GridVertex highest;
        PlaneIndex slab;
        std::uint8_t meets;
        std::uint64_t triangles;
    };
    struct Total {
        std::uint64_t triangles = 0;
        Int128 up = 0;  ///< twice the areas of horizontal faces, square units
        Int128 down = 0;
        std::uint64_t shells = 0;
        std::uint64_t peaks = 0;
        std::uint64_t pits = 0;
    };

    bool holds(PlaneIndex slab) const noexcept { return first_ <= slab && slab < end_; }
    std::uint32_t node_at(const GridVertex& vertex, PlaneIndex slab);
    void gather();
    SurfacePiece entry_of(const Piece& piece);

    const PlaneSet& planes_;
    double grid_mm_;
    PlaneIndex first_ = 0;
    PlaneIndex end_ = 0;
    NumberTable numbers_;  // nodes, by their vertices
    std::vector<Node> nodes_;
    std::vector<Piece> pieces_;
    DisjointSets sets_;  // nodes, united over the edges within a slab
    std::vector<Total> totals_;
};

}  // namespace lamella
