// Faces by the way they look, the slabs that each reaches into, and the piece that planes cut out of it there.
//
//             2               A face from above, and its piece a, b, c, d between the planes p and p + 1.
//           .' `.
//     - - -d- - -c- - - p + 1
//       .'         `.         Each of these points is computed from the mesh edge that it lies on, and from nothing else:
//     -a- - - - - - -b- p     the face on the other side of the edge has the same.
//     0---------------1
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>

#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "slicing/grid/grid_vector.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// Which way a face looks; the value is also the index of its result.
enum class FaceSense : std::uint8_t { up, down, none };

/// True if the transform's linear part mirrors.
inline bool mirrors(const Transform& transform) noexcept {
    const auto& m = transform.m;
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]) <
           0;
}

/// By the exact area of its projection.
inline FaceSense sense_of(const GridTriangle& face, bool mirrored) noexcept {
    const GridVector first = half(face[1]) - half(face[0]);
    const GridVector second = half(face[2]) - half(face[0]);
    const std::int64_t area = first.x * second.y - first.y * second.x;
    if (area == 0) {
        return FaceSense::none;
    }
    return (area > 0) != mirrored ? FaceSense::up : FaceSense::down;
}

/// The layers to which a face's pieces project: [first, last).
struct SlabRange {
    PlaneIndex first;
    PlaneIndex last;
};

/// Those of an upward face from the plane below its lowest vertex on, of a downward one to the plane above its highest; only
/// those that there are.
inline SlabRange slabs_of(const GridTriangle& face, FaceSense sense, const PlaneSet& planes) noexcept {
    const auto [low, high] = std::minmax({face[0].z, face[1].z, face[2].z});
    const PlaneIndex above_low = planes.first_above(low);
    const PlaneIndex above_high = planes.first_above(high);
    if (sense == FaceSense::up) {
        return {above_low - (above_low > 0 ? 1 : 0), above_high};
    }
    return {above_low, std::min(above_high + 1, planes.size())};
}

/// A piece, by what it is cut from.
struct FacePiece {
    std::uint32_t triangle;
    PlaneIndex layer;
};

/// The ring of one piece, counter-clockwise.
class PieceRing {
public:
    /// The part of `face` between the heights of two planes that project to one layer.
    PieceRing(const GridTriangle& face, FaceSense sense, bool mirrored, std::int32_t below, std::int32_t above) noexcept {
        const bool clockwise = (sense == FaceSense::down) != mirrored;
        const std::size_t second = clockwise ? 2 : 1;
        follow(face[0], face[second], below, above);
        follow(face[second], face[3 - second], below, above);
        follow(face[3 - second], face[0], below, above);
    }

    std::span<const Point> points() const noexcept { return {points_, count_}; }

private:
    /// The part of an edge that lies in the slab, without its end.
    void follow(const GridVertex& from, const GridVertex& to, std::int32_t below, std::int32_t above) noexcept {
        const std::int32_t first = from.z < to.z ? below : above;
        const std::int32_t second = from.z < to.z ? above : below;
        if (below < from.z && from.z < above) {
            assert(count_ < most_points);
            points_[count_++] = {from.x, from.y};
        }
        add_crossing(from, to, first);
        add_crossing(from, to, second);
    }

    void add_crossing(const GridVertex& from, const GridVertex& to, std::int32_t z) noexcept {
        if ((from.z < z) == (to.z < z)) {
            return;
        }
        assert(count_ < most_points);
        const bool rises = from.z < to.z;
        points_[count_++] = pierced_point(MeshEdge::between(rises ? from : to, rises ? to : from), z);
    }

    static constexpr std::size_t most_points = 5;  // a plane crosses two of three edges, and cuts off a vertex
    Point points_[most_points];
    std::size_t count_ = 0;
};

}  // namespace lamella
