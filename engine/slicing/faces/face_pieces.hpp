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
#include <bit>
#include <cassert>
#include <cstdint>
#include <limits>
#include <new>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/nesting/order.hpp"
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

// The border of many rings that share edges: the sum of their directed edges, where an edge and its opposite cancel.
//
//     .--->---.  .--->---.       .--->-------->---.
//     |   a   |  |   b   |       |                |
//     ^       v  ^       v   =   ^                v      One edge of a ran down where one of b ran up.
//     |       |  |       |       |                |
//     '---<---'  '---<---'       '---<--------<---'
//
// Every ring leaves a point as often as it enters it, and so does the sum. Sorted by the point that they leave and by the
// one that they enter, the edges therefore have the same points at the same places: the edge at a place of the second order
// is followed by the one at that place of the first. Which of several edges follows at a point makes no difference to
// winding numbers, nor to the bytes of a region, as contours that meet are cut there.

/// Layer after layer; scratch is kept. One per thread.
class EdgeSum {
public:
    explicit EdgeSum(Worker& worker) noexcept : worker_(worker) {}

    /// Begins anew, for about so many edges that differ.
    void begin(std::size_t edges) {
        used_ = 0;
        table_.clear();
        resize(std::bit_ceil(std::max(least_places, edges + edges / 2)));
    }

    /// Adds the edges of a closed ring; those without length count for nothing.
    void add(std::span<const Point> ring) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            add(ring[i], ring[i + 1 < ring.size() ? i + 1 : 0]);
        }
    }

    /// Strings together what is left: O(e) for e edges. Throws std::bad_alloc, and Stopped where the host wants the call to
    /// end; so do the others.
    void link() {
        collect();
        sort_ends();
        points_.clear();
        ring_ends_.clear();
        for (const nesting::SortKey& first : leaving_) {
            if (next_[first.index] == taken) {
                continue;
            }
            for (std::uint32_t edge = first.index; next_[edge] != taken;) {
                points_.push_back(edges_[edge].from);
                const std::uint32_t next = next_[edge];
                next_[edge] = taken;
                edge = next;
                worker_.spend(look_up_work);
            }
            ring_ends_.push_back(points_.size());
        }
    }

    /// After link(): the rings' points, one ring after the other, and where each ends.
    std::span<const Point> points() const noexcept { return points_; }
    std::span<const std::size_t> ring_ends() const noexcept { return ring_ends_; }

private:
    static constexpr std::size_t look_up_work = 8;  // as StopPace counts it: an entry waits for memory
    static constexpr std::size_t least_places = 64;
    static constexpr std::uint32_t taken = std::numeric_limits<std::uint32_t>::max();

    /// An edge and how often it runs from `low` to `high`, less how often the other way. Equal points: an unused place.
    struct Entry {
        Point low;
        Point high;
        std::int64_t times;
    };
    struct DirectedEdge {
        Point from;
        Point to;
    };

    /// The same on every platform; the high bits are well mixed.
    static std::uint64_t hash_of(Point low, Point high) noexcept {
        std::uint64_t h = nesting::key_of(low) * 0x9E3779B97F4A7C15U + nesting::key_of(high) * 0xC2B2AE3D27D4EB4FU;
        h ^= h >> 32;
        return h * 0xD6E8FEB86659FD93U;
    }

    Entry& place_of(Point low, Point high) noexcept {
        const std::size_t mask = table_.size() - 1;
        std::size_t i = hash_of(low, high) >> shift_;
        while (table_[i].low != table_[i].high && !(table_[i].low == low && table_[i].high == high)) {
            i = (i + 1) & mask;
        }
        return table_[i];
    }

    void add(Point from, Point to) {
        if (from == to) {
            return;
        }
        const bool ascends = from < to;
        Entry& entry = place_of(ascends ? from : to, ascends ? to : from);
        if (entry.low == entry.high) {
            entry = {ascends ? from : to, ascends ? to : from, 0};
            ++used_;
        }
        entry.times += ascends ? 1 : -1;
        worker_.spend(look_up_work);
        if (used_ > table_.size() / 4 * 3) {
            grow();
        }
    }

    void resize(std::size_t size) {
        table_.reserve(size);
        worker_.in_stretches(table_.size(), size, 1, [&](std::size_t, std::size_t end) { table_.resize(end); });
        shift_ = 64 - std::countr_zero(size);
    }

    void grow() {
        Vector<Entry> before(table_.get_allocator());
        before.swap(table_);
        resize(2 * before.size());
        worker_.in_stretches(0, before.size(), look_up_work, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (before[i].low != before[i].high) {
                    place_of(before[i].low, before[i].high) = before[i];
                }
            }
        });
    }

    void collect() {
        edges_.clear();
        worker_.in_stretches(0, table_.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Entry& entry = table_[i];
                const DirectedEdge edge =
                    entry.times > 0 ? DirectedEdge{entry.low, entry.high} : DirectedEdge{entry.high, entry.low};
                edges_.insert(edges_.end(), static_cast<std::size_t>(entry.times > 0 ? entry.times : -entry.times), edge);
            }
        });
        if (edges_.size() >= taken) {
            throw std::bad_alloc();
        }
    }

    void sort_ends() {
        leaving_.clear();
        entering_.clear();
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            const auto number = static_cast<std::uint32_t>(i);
            leaving_.push_back({nesting::key_of(edges_[i].from), number});
            entering_.push_back({nesting::key_of(edges_[i].to), number});
            worker_.spend(2);
        }
        nesting::sort_keys(leaving_, spare_, worker_);
        nesting::sort_keys(entering_, spare_, worker_);
        next_.resize(edges_.size());
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            assert(leaving_[i].key == entering_[i].key);
            next_[entering_[i].index] = leaving_[i].index;
            worker_.spend(look_up_work);
        }
    }

    Worker& worker_;
    Vector<Entry> table_{worker_.memory()};  // open addressing, at most three quarters full
    std::size_t used_ = 0;
    int shift_ = 0;  // from a hash to a place
    Vector<DirectedEdge> edges_{worker_.memory()};
    Vector<nesting::SortKey> leaving_{worker_.memory()};   // edges by the point that they leave
    Vector<nesting::SortKey> entering_{worker_.memory()};  // by the one that they enter
    Vector<nesting::SortKey> spare_{worker_.memory()};
    Vector<std::uint32_t> next_{worker_.memory()};  // of each edge, until it is in a ring
    Vector<Point> points_{worker_.memory()};
    Vector<std::size_t> ring_ends_{worker_.memory()};
};

}  // namespace lamella
