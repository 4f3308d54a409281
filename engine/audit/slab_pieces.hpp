// The pieces of the surface within a few slabs. A piece that does not join two planes has a vertex in its slab, and all its
// vertices there are joined by edges that stay in the slab: so it is a set of vertices, and the edges that leave the slab
// show which planes it meets.
#pragma once

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/number_table.hpp"
#include "base/numbers.hpp"
#include "lamella/audit.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/grid/vertex_hash.hpp"
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
    void begin(PlaneIndex first, PlaneIndex end, std::size_t triangles) {
        first_ = first;
        end_ = end;
        // A closed surface has half as many vertices as triangles.
        numbers_.clear(triangles / 2);
        nodes_.clear();
        pieces_.clear();
        sets_.assign(0);
        totals_.assign(end - first, {});
    }

    /// To be called once for every triangle with a vertex in the range, in any order.
    void add(const SlabTriangle& triangle) {
        std::array<std::uint32_t, 3> nodes{none, none, none};
        for (std::size_t i = 0; i < 3; ++i) {
            if (holds(triangle.slabs[i])) {
                nodes[i] = node_at(triangle.corners[i], triangle.slabs[i]);
            }
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t next = i == 2 ? 0 : i + 1;
            if (triangle.slabs[i] == triangle.slabs[next]) {
                if (nodes[i] != none) {
                    sets_.unite(nodes[i], nodes[next]);
                }
                continue;
            }
            const bool rises = triangle.slabs[i] < triangle.slabs[next];
            const std::uint32_t low = rises ? nodes[i] : nodes[next];
            const std::uint32_t high = rises ? nodes[next] : nodes[i];
            if (low != none) {
                nodes_[low].meets |= meets_above;
            }
            if (high != none) {
                nodes_[high].meets |= meets_below;
            }
        }
        if (triangle.within_one()) {
            ++nodes_[nodes[0]].triangles;
            Total& total = totals_[triangle.slabs[0] - first_];
            ++total.triangles;
            const GridTriangle& t = triangle.corners;
            const Int128 area =  // twice, positive if it faces up
                triangle.is_horizontal() ? side_of_line({t[0].x, t[0].y}, {t[1].x, t[1].y}, {t[2].x, t[2].y}) : 0;
            (area > 0 ? total.up : total.down) += area > 0 ? area : -area;
        }
    }

    /// Appends what the range holds; the slabs from below, their pieces by kind and place.
    void finish(std::vector<Slab>& slabs, std::vector<SurfacePiece>& pieces) {
        gather();
        const auto begun = static_cast<std::ptrdiff_t>(pieces.size());
        for (const Piece& piece : pieces_) {
            pieces.push_back(entry_of(piece));
        }
        std::sort(pieces.begin() + begun, pieces.end(), [](const SurfacePiece& a, const SurfacePiece& b) {
            return std::tie(a.layer, a.kind, a.at_mm) < std::tie(b.layer, b.kind, b.at_mm);
        });
        const double half_mm2 = grid_mm_ * grid_mm_ / 2;
        for (std::size_t i = 0; i < totals_.size(); ++i) {
            const Total& total = totals_[i];
            if (total.triangles + total.shells + total.peaks + total.pits > 0) {
                slabs.push_back({first_ + i, total.triangles, static_cast<double>(total.up) * half_mm2,
                                 static_cast<double>(total.down) * half_mm2, total.shells, total.peaks, total.pits});
            }
        }
    }

private:
    static constexpr std::uint32_t none = 0xffffffff;
    static constexpr std::uint8_t meets_below = 1;
    static constexpr std::uint8_t meets_above = 2;

    /// For a vertex: the edges that leave it.
    struct Node {
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

    static bool is_lower(const GridVertex& a, const GridVertex& b) noexcept {
        return std::tie(a.z, a.x, a.y) < std::tie(b.z, b.x, b.y);
    }
    /// The smaller (x, y) of two at one height stands for both.
    static bool is_higher(const GridVertex& a, const GridVertex& b) noexcept {
        return a.z != b.z ? a.z > b.z : std::tie(a.x, a.y) < std::tie(b.x, b.y);
    }
    bool holds(PlaneIndex slab) const noexcept { return first_ <= slab && slab < end_; }

    std::uint32_t node_at(const GridVertex& vertex, PlaneIndex slab) {
        const std::uint32_t node = numbers_.number(vertex);
        if (node == nodes_.size()) {
            nodes_.push_back({slab, 0, none, 0});
            sets_.add();
        }
        return node;
    }

    /// Gathers the sets that do not join two planes; a set's root is its first node.
    void gather() {
        for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
            nodes_[sets_.root(node)].meets |= nodes_[node].meets;
        }
        for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
            const Node& own = nodes_[node];
            const GridVertex& vertex = numbers_.items()[node];
            Node& root = nodes_[sets_.root(node)];
            if (root.meets == (meets_below | meets_above)) {
                continue;
            }
            if (root.piece == none) {
                root.piece = static_cast<std::uint32_t>(pieces_.size());
                pieces_.push_back({vertex, vertex, own.slab, root.meets, 0});
            }
            Piece& piece = pieces_[root.piece];
            piece.lowest = is_lower(vertex, piece.lowest) ? vertex : piece.lowest;
            piece.highest = is_higher(vertex, piece.highest) ? vertex : piece.highest;
            piece.triangles += own.triangles;
        }
    }

    /// Also counts it.
    SurfacePiece entry_of(const Piece& piece) {
        const SurfacePieceKind kind = piece.meets == 0
                                          ? SurfacePieceKind::shell
                                          : (piece.meets == meets_below ? SurfacePieceKind::peak : SurfacePieceKind::pit);
        Total& total = totals_[piece.slab - first_];
        ++(kind == SurfacePieceKind::shell ? total.shells : (kind == SurfacePieceKind::peak ? total.peaks : total.pits));
        const GridVertex& at = kind == SurfacePieceKind::peak ? piece.highest : piece.lowest;
        const std::int32_t low = kind == SurfacePieceKind::peak ? planes_.z(piece.slab - 1) : piece.lowest.z;
        const std::int32_t high = kind == SurfacePieceKind::pit ? planes_.z(piece.slab) : piece.highest.z;
        return {kind,
                piece.slab,
                {at.x * grid_mm_, at.y * grid_mm_, at.z * grid_mm_},
                (static_cast<double>(high) - low) * grid_mm_,
                piece.triangles};
    }

    const PlaneSet& planes_;
    double grid_mm_;
    PlaneIndex first_ = 0;
    PlaneIndex end_ = 0;
    NumberTable<GridVertex, quick_hash_of> numbers_;  // of nodes
    std::vector<Node> nodes_;
    std::vector<Piece> pieces_;
    DisjointSets sets_;  // nodes, united over the edges within a slab
    std::vector<Total> totals_;
};

}  // namespace lamella
