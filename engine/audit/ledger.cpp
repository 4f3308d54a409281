// Where each triangle went. A piece of the surface that does not join two planes has a vertex in its slab, and all its
// vertices there are joined by edges that stay in the slab: so it is a set of vertices, and the edges that leave the slab
// show which planes it meets.
#include "lamella/audit.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "audit/questions.hpp"
#include "base/atomic_word.hpp"
#include "base/disjoint_sets.hpp"
#include "base/numbers.hpp"
#include "mesh/vertex_numbers.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/grid/vertex_hash.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = 4096;
constexpr std::size_t vertices_between_stops = std::size_t{1} << 16;

/// Vertices by height, then by x and y: the first of a set is its lowest.
template <class Reader>
struct CornersByHeight {
    using Vertex = GridVertex;
    const Reader& read;

    GridTriangle operator()(std::size_t t) const noexcept { return read(t); }
    static std::uint64_t hash(const Vertex& vertex) noexcept { return quick_hash_of(vertex); }
    static std::int32_t key(const Vertex& vertex) noexcept { return vertex.z; }
    static bool differ(const Vertex& /*a*/, const Vertex& /*b*/) noexcept { return false; }
};

/// What is known of a vertex, and in the end of a whole set in its first one.
using Marks = std::uint8_t;
constexpr Marks meets_below = 1;
constexpr Marks meets_above = 2;
constexpr Marks has_triangle = 4;

/// The smaller (x, y) of two at one height stands for both.
bool is_higher(const GridVertex& a, const GridVertex& b) noexcept {
    return a.z != b.z ? a.z > b.z : std::tie(a.x, a.y) < std::tie(b.x, b.y);
}

/// Triangles within a slab.
struct SlabTotal {
    std::uint64_t triangles = 0;
    Int128 up = 0;  ///< twice the areas of horizontal faces, square units
    Int128 down = 0;
};

/// The counts of one worker.
struct Share {
    std::uint64_t cut = 0;
    std::uint64_t degenerate = 0;
    std::uint64_t horizontal = 0;
    std::vector<SlabTotal> slabs;
};

/// A set that does not join two planes.
struct Piece {
    std::uint32_t lowest;  ///< vertices
    std::uint32_t highest;
    std::uint64_t triangles = 0;
};

template <class Reader>
class Bookkeeping {
public:
    Bookkeeping(const SlicedMesh& sliced, const Reader& read, const Parallel& parallel)
        : planes_(sliced.planes),
          grid_mm_(sliced.result.info.grid_mm),
          triangle_count_(sliced.mesh.triangle_count),
          parallel_(parallel),
          numbers_(CornersByHeight<Reader>{read}, triangle_count_, parallel),
          sets_(numbers_.vertices.size(), parallel, parallel.memory()),
          slab_of_(parallel.memory()),
          marks_(parallel.memory()),
          triangles_(parallel.memory()),
          shares_(static_cast<std::size_t>(parallel.threads())) {}

    Ledger run() {
        place_vertices();
        for (Share& share : shares_) {
            share.slabs.resize(std::size_t{planes_.size()} + 1);
        }
        parallel_.run_ranges(triangle_count_, grain, [&](std::size_t begin, std::size_t end, int worker) {
            for (std::size_t t = begin; t < end; ++t) {
                enter(shares_[static_cast<std::size_t>(worker)], numbers_.of_corners.data() + 3 * t);
            }
        });
        return close(gather());
    }

private:
    void place_vertices() {
        const std::size_t count = numbers_.vertices.size();
        slab_of_.resize_discarding(count);
        marks_.resize_discarding(count);
        triangles_.resize_discarding(count);
        parallel_.run_ranges(count, grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t v = begin; v < end; ++v) {
                slab_of_[v] = planes_.first_above(numbers_.vertices[v].z);
                marks_[v] = 0;
                triangles_[v] = 0;
            }
        });
    }

    void enter(Share& share, const std::uint32_t* v) {
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
            ++share.degenerate;
            return;
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t from = v[i];
            const std::uint32_t to = v[i == 2 ? 0 : i + 1];
            const bool rises = slab_of_[from] < slab_of_[to];
            AtomicWord(marks_[from]).set(has_triangle);
            if (slab_of_[from] == slab_of_[to]) {
                sets_.unite(from, to);
            } else {
                AtomicWord(marks_[rises ? from : to]).set(meets_above);
                AtomicWord(marks_[rises ? to : from]).set(meets_below);
            }
        }
        const PlaneIndex slab = slab_of_[v[0]];
        if (slab != slab_of_[v[1]] || slab != slab_of_[v[2]]) {
            ++share.cut;
            return;
        }
        AtomicWord(triangles_[v[0]]).add(1);
        ++share.slabs[slab].triangles;
        const GridVertex& a = numbers_.vertices[v[0]];
        const GridVertex& b = numbers_.vertices[v[1]];
        const GridVertex& c = numbers_.vertices[v[2]];
        if (a.z == b.z && b.z == c.z) {
            ++share.horizontal;
            const Int128 area = side_of_line({a.x, a.y}, {b.x, b.y}, {c.x, c.y});  // twice, positive if it faces up
            (area > 0 ? share.slabs[slab].up : share.slabs[slab].down) += area > 0 ? area : -area;
        }
    }

    /// Calls visit(vertex, the first of its set) for all, from the lowest.
    template <class Visit>
    void for_each_vertex(Visit visit) {
        for (std::size_t v = 0; v < marks_.size(); ++v) {
            if (v % vertices_between_stops == 0) {
                parallel_.stop_if_asked();
            }
            visit(static_cast<std::uint32_t>(v), sets_.root(static_cast<std::uint32_t>(v)));
        }
    }

    std::vector<Piece> gather() {
        for_each_vertex([&](std::uint32_t v, std::uint32_t first) { marks_[first] |= marks_[v]; });
        std::vector<Piece> pieces;
        Array<std::uint32_t> piece_of(parallel_.memory());  // by the first vertex
        piece_of.resize_discarding(marks_.size());
        for_each_vertex([&](std::uint32_t v, std::uint32_t first) {
            const Marks meets = marks_[first] & (meets_below | meets_above);
            if (marks_[first] == 0 || meets == (meets_below | meets_above)) {
                return;
            }
            if (v == first) {
                piece_of[v] = static_cast<std::uint32_t>(pieces.size());
                pieces.push_back({v, v});
            }
            Piece& piece = pieces[piece_of[first]];
            piece.highest = is_higher(numbers_.vertices[v], numbers_.vertices[piece.highest]) ? v : piece.highest;
            piece.triangles += triangles_[v];
        });
        return pieces;
    }

    SurfacePiece entry_of(const Piece& piece) const {
        const Marks marks = marks_[piece.lowest];
        const SurfacePieceKind kind = (marks & meets_below) != 0   ? SurfacePieceKind::peak
                                      : (marks & meets_above) != 0 ? SurfacePieceKind::pit
                                                                   : SurfacePieceKind::shell;
        const PlaneIndex slab = slab_of_[piece.lowest];
        const GridVertex& lowest = numbers_.vertices[piece.lowest];
        const GridVertex& highest = numbers_.vertices[piece.highest];
        const GridVertex& at = kind == SurfacePieceKind::peak ? highest : lowest;
        const std::int32_t low = kind == SurfacePieceKind::peak ? planes_.z(slab - 1) : lowest.z;
        const std::int32_t high = kind == SurfacePieceKind::pit ? planes_.z(slab) : highest.z;
        return {kind,
                slab,
                {at.x * grid_mm_, at.y * grid_mm_, at.z * grid_mm_},
                (static_cast<double>(high) - low) * grid_mm_,
                piece.triangles};
    }

    Ledger close(const std::vector<Piece>& pieces) const {
        Ledger ledger;
        ledger.triangles = triangle_count_;
        std::vector<Slab> slabs(std::size_t{planes_.size()} + 1);
        for (const Piece& piece : pieces) {
            const SurfacePiece& entry = ledger.pieces.emplace_back(entry_of(piece));
            const bool is_shell = entry.kind == SurfacePieceKind::shell;
            const bool is_peak = entry.kind == SurfacePieceKind::peak;
            Slab& slab = slabs[entry.layer];
            ++(is_shell ? slab.shells : is_peak ? slab.peaks : slab.pits);
            SurfacePieceCount& count = is_shell ? ledger.shells : is_peak ? ledger.peaks : ledger.pits;
            ++count.count;
            count.triangles += entry.triangles;
        }
        std::sort(ledger.pieces.begin(), ledger.pieces.end(), [](const SurfacePiece& a, const SurfacePiece& b) {
            return std::tie(a.layer, a.kind, a.at_mm) < std::tie(b.layer, b.kind, b.at_mm);
        });
        for (const Share& share : shares_) {
            ledger.cut += share.cut;
            ledger.degenerate += share.degenerate;
            ledger.horizontal += share.horizontal;
        }
        ledger.between = ledger.triangles - ledger.cut - ledger.degenerate;
        for (std::size_t layer = 0; layer < slabs.size(); ++layer) {
            add_slab(layer, slabs[layer], ledger);
        }
        return ledger;
    }

    void add_slab(std::size_t layer, Slab slab, Ledger& ledger) const {
        SlabTotal total;
        for (const Share& share : shares_) {
            total.triangles += share.slabs[layer].triangles;
            total.up += share.slabs[layer].up;
            total.down += share.slabs[layer].down;
        }
        const double half_mm2 = grid_mm_ * grid_mm_ / 2;
        slab.layer = layer;
        slab.triangles = total.triangles;
        slab.flat_up_mm2 = static_cast<double>(total.up) * half_mm2;
        slab.flat_down_mm2 = static_cast<double>(total.down) * half_mm2;
        if (slab.triangles + slab.shells + slab.peaks + slab.pits > 0) {
            ledger.flat_up_mm2 += slab.flat_up_mm2;
            ledger.flat_down_mm2 += slab.flat_down_mm2;
            ledger.slabs.push_back(slab);
        }
    }

    const PlaneSet& planes_;
    double grid_mm_;
    std::size_t triangle_count_;
    const Parallel& parallel_;
    VertexNumbers<CornersByHeight<Reader>> numbers_;
    SharedSets<std::uint32_t> sets_;  ///< vertices, united over the edges within a slab
    Array<PlaneIndex> slab_of_;       ///< by vertex: the first plane above it
    Array<Marks> marks_;              ///< by vertex
    Array<std::uint32_t> triangles_;  ///< by vertex: those within a slab of which it is the first corner
    std::vector<Share> shares_;       ///< by worker
};

/// Layers without a contour that have some below and above.
std::vector<std::uint64_t> find_gaps(const SliceResult& result) {
    std::vector<std::uint64_t> gaps;
    bool begun = false;
    std::size_t between = 0;  // gaps below the last layer with contours
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        if (result.layers[l].contour_count > 0) {
            begun = true;
            between = gaps.size();
        } else if (begun) {
            gaps.push_back(l);
        }
    }
    gaps.resize(between);
    return gaps;
}

}  // namespace

std::string_view name_of(SurfacePieceKind kind) noexcept {
    constexpr std::array<std::string_view, 3> names = {"shell", "peak", "pit"};
    return names[static_cast<std::size_t>(kind)];
}

Ledger make_ledger(const SlicedMesh& sliced, const ProgressShare& progress) {
    progress.begin(1, 12);
    Ledger ledger = with_reader(sliced.mesh, sliced.placing, sliced.result.info.grid_mm,
                                [&](const auto& read) { return Bookkeeping(sliced, read, progress.parallel).run(); });
    ledger.gaps = find_gaps(sliced.result);
    return ledger;
}

}  // namespace lamella
