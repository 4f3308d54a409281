// Faces by the way they look, the slabs that each reaches into, and the piece that planes cut out of it there.
//
//             2               A face from above, and its piece a, b, c, d between the planes p and p + 1.
//           .' `.
//     - - -d- - -c- - - p + 1
//       .'         `.         Each of these points is computed from the mesh edge that it lies on, and from nothing else:
//     -a- - - - - - -b- p     the face on the other side of the edge has the same.
//     0---------------1
#pragma once

#include <cstdint>
#include <span>

#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// Which way a face looks; the value is also the index of its result.
enum class FaceSense : std::uint8_t { up, down, none };

/// True if the transform's linear part mirrors.
bool mirrors(const Transform& transform) noexcept;

/// By the exact area of its projection.
FaceSense sense_of(const GridTriangle& face, bool mirrored) noexcept;

/// The layers to which a face's pieces project: [first, last).
struct SlabRange {
    PlaneIndex first;
    PlaneIndex last;
};

/// Those of an upward face from the plane below its lowest vertex on, of a downward one to the plane above its highest; only
/// those that there are.
SlabRange slabs_of(const GridTriangle& face, FaceSense sense, const PlaneSet& planes) noexcept;

/// A piece, by what it is cut from.
struct FacePiece {
    std::uint32_t triangle;
    PlaneIndex layer;
};

/// The ring of one piece, counter-clockwise.
class PieceRing {
public:
    /// The part of `face` between the heights of two planes that project to one layer.
    PieceRing(const GridTriangle& face, FaceSense sense, bool mirrored, std::int32_t below, std::int32_t above) noexcept;

    std::span<const Point> points() const noexcept { return {points_, count_}; }

private:
    void follow(const GridVertex& from, const GridVertex& to, std::int32_t below, std::int32_t above) noexcept;
    void add_crossing(const GridVertex& from, const GridVertex& to, std::int32_t z) noexcept;

    static constexpr std::size_t most_points = 5;  // a plane crosses two of three edges, and cuts off a vertex
    Point points_[most_points];
    std::size_t count_ = 0;
};

}  // namespace lamella
