#include "lamella/audit.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include "audit/questions.hpp"
#include "base/disjoint_sets.hpp"
#include "base/number_table.hpp"
#include "base/numbers.hpp"
#include "base/parallel_sort.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

/// A triangle, and the slab of each vertex: the first plane above it.
struct SlabTriangle {
    GridTriangle corners;
    std::array<PlaneIndex, 3> slabs;

    SlabTriangle(const GridTriangle& t, const PlaneSet& planes) noexcept
        : corners(t), slabs{planes.first_above(t[0].z), planes.first_above(t[1].z), planes.first_above(t[2].z)} {}

    bool within_one() const noexcept { return slabs[0] == slabs[1] && slabs[1] == slabs[2]; }
    bool is_horizontal() const noexcept { return corners[0].z == corners[1].z && corners[1].z == corners[2].z; }
};

/// The pieces of the surface within a few slabs. A piece that does not join two planes has a vertex in its slab, and all its
/// vertices there are joined by edges that stay in the slab: so it is a set of vertices, and the edges that leave the slab
/// show which planes it meets. Goes through one range of slabs after another; its memory is kept.
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

constexpr std::size_t grain = 4096;
constexpr std::size_t part_triangles = 1 << 14;  ///< whose vertices stay in the cache
constexpr std::size_t least_part_triangles = 1 << 11;
constexpr std::size_t parts_for_balance = 16;  ///< so that a few threads end together

/// Slabs in ranges that hold about as many triangles each, so that threads can take one after the other.
class Parts {
public:
    /// `slab_of`: of a vertex of each triangle.
    template <class SlabOf>
    Parts(std::size_t triangles, PlaneIndex planes, SlabOf slab_of) : part_of_(std::size_t{planes} + 1) {
        const std::size_t for_balance = std::min(triangles / least_part_triangles, parts_for_balance);
        const std::size_t wanted = std::max(parts_for(triangles, part_triangles), for_balance);
        const Splitters<PlaneIndex, std::less<>> splitters(triangles, wanted, std::less<>{}, slab_of);
        for (PlaneIndex slab = 0; slab <= planes; ++slab) {
            part_of_[slab] = static_cast<std::uint32_t>(splitters.part_of(slab));
        }
    }

    std::size_t size() const noexcept { return std::size_t{part_of_.back()} + 1; }
    std::uint32_t of(PlaneIndex slab) const noexcept { return part_of_[slab]; }
    /// Slabs [begin, end): none where many triangles lie in one.
    std::pair<PlaneIndex, PlaneIndex> slabs(std::size_t part) const noexcept {
        const auto [begin, end] = std::equal_range(part_of_.begin(), part_of_.end(), static_cast<std::uint32_t>(part));
        return {static_cast<PlaneIndex>(begin - part_of_.begin()), static_cast<PlaneIndex>(end - part_of_.begin())};
    }

private:
    std::vector<std::uint32_t> part_of_;  // ascending
};

/// The counts of one worker, and the triangles that it found for each part.
struct Share {
    std::uint64_t cut = 0;
    std::uint64_t degenerate = 0;
    std::uint64_t horizontal = 0;
    std::vector<std::vector<std::uint32_t>> parts;
};

struct PartEntries {
    std::vector<Slab> slabs;
    std::vector<SurfacePiece> pieces;
};

template <class Reader>
class Bookkeeping {
public:
    Bookkeeping(const SlicedMesh& sliced, const Reader& read, const Parallel& parallel)
        : read_(read),
          result_(sliced.result),
          planes_(sliced.planes),
          parallel_(parallel),
          triangles_(sliced.mesh.triangle_count),
          parts_(triangles_, planes_.size(), [&](std::size_t t) { return planes_.first_above(read_(t)[0].z); }),
          shares_(static_cast<std::size_t>(parallel.threads())) {}

    Ledger run() {
        share_out();
        std::vector<PartEntries> entries = go_through_parts();
        return close(entries);
    }

private:
    /// Each triangle to the parts of its vertices.
    void share_out() {
        for (Share& share : shares_) {
            share.parts.resize(parts_.size());
        }
        parallel_.run_ranges(triangles_, grain, [&](std::size_t begin, std::size_t end, int worker) {
            Share& share = shares_[static_cast<std::size_t>(worker)];
            for (std::size_t t = begin; t < end; ++t) {
                enter(share, static_cast<std::uint32_t>(t));
            }
        });
    }

    void enter(Share& share, std::uint32_t t) const {
        const GridTriangle corners = read_(t);
        if (is_degenerate(corners)) {
            ++share.degenerate;
            return;
        }
        const SlabTriangle triangle(corners, planes_);
        share.cut += triangle.within_one() ? 0U : 1U;
        share.horizontal += triangle.is_horizontal() ? 1U : 0U;
        const std::array<std::uint32_t, 3> own = {parts_.of(triangle.slabs[0]), parts_.of(triangle.slabs[1]),
                                                  parts_.of(triangle.slabs[2])};
        share.parts[own[0]].push_back(t);
        if (own[1] != own[0]) {
            share.parts[own[1]].push_back(t);
        }
        if (own[2] != own[0] && own[2] != own[1]) {
            share.parts[own[2]].push_back(t);
        }
    }

    std::size_t triangles_of(std::size_t part) const {
        std::size_t triangles = 0;
        for (const Share& share : shares_) {
            triangles += share.parts[part].size();
        }
        return triangles;
    }

    std::vector<PartEntries> go_through_parts() {
        std::vector<PartEntries> entries(parts_.size());
        std::vector<SlabPieces> workers(shares_.size(), SlabPieces(planes_, result_.info.grid_mm));
        parallel_.run(parts_.size(), [&](std::size_t part, int worker) {
            SlabPieces& pieces = workers[static_cast<std::size_t>(worker)];
            const auto [begin, end] = parts_.slabs(part);
            if (begin == end) {
                return;
            }
            pieces.begin(begin, end, triangles_of(part));
            for (const Share& share : shares_) {
                for (const std::uint32_t t : share.parts[part]) {
                    pieces.add(SlabTriangle(read_(t), planes_));
                }
            }
            pieces.finish(entries[part].slabs, entries[part].pieces);
        });
        return entries;
    }

    Ledger close(const std::vector<PartEntries>& entries) const {
        Ledger ledger;
        ledger.triangles = triangles_;
        for (const Share& share : shares_) {
            ledger.cut += share.cut;
            ledger.degenerate += share.degenerate;
            ledger.horizontal += share.horizontal;
        }
        ledger.between = ledger.triangles - ledger.cut - ledger.degenerate;
        for (const PartEntries& part : entries) {
            ledger.slabs.insert(ledger.slabs.end(), part.slabs.begin(), part.slabs.end());
            ledger.pieces.insert(ledger.pieces.end(), part.pieces.begin(), part.pieces.end());
        }
        for (const Slab& slab : ledger.slabs) {
            ledger.flat_up_mm2 += slab.flat_up_mm2;
            ledger.flat_down_mm2 += slab.flat_down_mm2;
        }
        for (const SurfacePiece& piece : ledger.pieces) {
            SurfacePieceCount& kind = piece.kind == SurfacePieceKind::shell  ? ledger.shells
                                      : piece.kind == SurfacePieceKind::peak ? ledger.peaks
                                                                             : ledger.pits;
            ++kind.count;
            kind.triangles += piece.triangles;
        }
        ledger.gaps = find_gaps();
        return ledger;
    }

    std::vector<std::uint64_t> find_gaps() const {
        std::vector<std::uint64_t> gaps;
        bool begun = false;
        std::size_t between = 0;  // gaps below the last layer with contours
        for (std::size_t l = 0; l < result_.layers.size(); ++l) {
            if (result_.layers[l].contour_count > 0) {
                begun = true;
                between = gaps.size();
            } else if (begun) {
                gaps.push_back(l);
            }
        }
        gaps.resize(between);
        return gaps;
    }

    const Reader& read_;
    const SliceResult& result_;
    const PlaneSet& planes_;
    const Parallel& parallel_;
    std::size_t triangles_;
    Parts parts_;
    std::vector<Share> shares_;  // by worker
};

}  // namespace

std::string_view name_of(SurfacePieceKind kind) noexcept {
    constexpr std::array<std::string_view, 3> names = {"shell", "peak", "pit"};
    return names[static_cast<std::size_t>(kind)];
}

Ledger make_ledger(const SlicedMesh& sliced, const ProgressShare& progress) {
    progress.begin(1, 3);
    return with_reader(sliced.mesh, sliced.placing, sliced.result.info.grid_mm,
                       [&](const auto& read) { return Bookkeeping(sliced, read, progress.parallel).run(); });
}

}  // namespace lamella
