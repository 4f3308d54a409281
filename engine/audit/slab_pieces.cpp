#include "audit/slab_pieces.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include "slicing/grid/exact.hpp"
#include "slicing/grid/vertex_hash.hpp"

namespace lamella {

namespace {

bool is_lower(const GridVertex& a, const GridVertex& b) noexcept {
    return std::tie(a.z, a.x, a.y) < std::tie(b.z, b.x, b.y);
}

/// Of two at one height the smaller (x, y) stands for both.
bool is_higher(const GridVertex& a, const GridVertex& b) noexcept {
    return a.z != b.z ? a.z > b.z : std::tie(a.x, a.y) < std::tie(b.x, b.y);
}

/// Twice the area of a horizontal triangle, positive if it faces up.
Int128 twice_area(const GridTriangle& t) noexcept {
    return side_of_line({t[0].x, t[0].y}, {t[1].x, t[1].y}, {t[2].x, t[2].y});
}

bool comes_before(const SurfacePiece& a, const SurfacePiece& b) noexcept {
    return std::tie(a.layer, a.kind, a.at_mm) < std::tie(b.layer, b.kind, b.at_mm);
}

}  // namespace

void SlabPieces::begin(PlaneIndex first, PlaneIndex last, std::size_t triangles) {
    first_ = first;
    last_ = last;
    // A closed surface has half as many vertices as triangles.
    table_.assign(std::bit_ceil(triangles + 2), none);
    nodes_.clear();
    sets_.assign(0);
    totals_.assign(std::size_t{last} - first + 1, {});
}

void SlabPieces::add(const SlabTriangle& triangle) {
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
        const Int128 area = triangle.is_horizontal() ? twice_area(triangle.corners) : 0;
        (area > 0 ? total.up : total.down) += area > 0 ? area : -area;
    }
}

std::uint32_t SlabPieces::node_at(const GridVertex& vertex, PlaneIndex slab) {
    if (2 * nodes_.size() >= table_.size()) {
        grow();
    }
    const std::size_t mask = table_.size() - 1;
    std::size_t place = hash_of(vertex) & mask;
    while (table_[place] != none) {
        if (nodes_[table_[place]].lowest == vertex) {
            return table_[place];
        }
        place = (place + 1) & mask;
    }
    const auto node = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({vertex, vertex, slab, 0, 0});
    sets_.add();
    table_[place] = node;
    return node;
}

void SlabPieces::grow() {
    table_.assign(2 * table_.size(), none);
    const std::size_t mask = table_.size() - 1;
    for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
        std::size_t place = hash_of(nodes_[node].lowest) & mask;
        while (table_[place] != none) {
            place = (place + 1) & mask;
        }
        table_[place] = node;
    }
}

/// Adds each node to the root of its set.
void SlabPieces::gather() {
    for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
        const Node& own = nodes_[node];
        const std::uint32_t root = sets_.root(node);
        if (root == node) {
            continue;
        }
        Node& set = nodes_[root];
        set.lowest = is_lower(own.lowest, set.lowest) ? own.lowest : set.lowest;
        set.highest = is_higher(own.highest, set.highest) ? own.highest : set.highest;
        set.triangles += own.triangles;
        set.meets |= own.meets;
    }
}

void SlabPieces::close(const Node& set, std::vector<SurfacePiece>& pieces) {
    if (set.meets == (meets_below | meets_above)) {
        return;
    }
    const SurfacePieceKind kind = set.meets == 0
                                      ? SurfacePieceKind::shell
                                      : (set.meets == meets_below ? SurfacePieceKind::peak : SurfacePieceKind::pit);
    Total& total = totals_[set.slab - first_];
    ++(kind == SurfacePieceKind::shell ? total.shells : (kind == SurfacePieceKind::peak ? total.peaks : total.pits));
    const GridVertex& at = kind == SurfacePieceKind::peak ? set.highest : set.lowest;
    const std::int32_t low = kind == SurfacePieceKind::peak ? planes_.z(set.slab - 1) : set.lowest.z;
    const std::int32_t high = kind == SurfacePieceKind::pit ? planes_.z(set.slab) : set.highest.z;
    pieces.push_back({kind,
                      set.slab,
                      {at.x * unit_mm_, at.y * unit_mm_, at.z * unit_mm_},
                      (static_cast<double>(high) - low) * unit_mm_,
                      set.triangles});
}

void SlabPieces::finish(std::vector<Slab>& slabs, std::vector<SurfacePiece>& pieces) {
    gather();
    const auto begun = static_cast<std::ptrdiff_t>(pieces.size());
    for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
        if (sets_.root(node) == node) {
            close(nodes_[node], pieces);
        }
    }
    std::sort(pieces.begin() + begun, pieces.end(), comes_before);
    const double half_mm2 = unit_mm_ * unit_mm_ / 2;
    for (std::size_t i = 0; i < totals_.size(); ++i) {
        const Total& total = totals_[i];
        if (total.triangles + total.shells + total.peaks + total.pits > 0) {
            slabs.push_back({first_ + i, total.triangles, static_cast<double>(total.up) * half_mm2,
                             static_cast<double>(total.down) * half_mm2, total.shells, total.peaks, total.pits});
        }
    }
}

}  // namespace lamella
