#include "lamella/audit.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "audit/questions.hpp"
#include "base/distribute.hpp"
#include "base/numbers.hpp"
#include "base/sort.hpp"
#include "mesh/vertex_numbers.hpp"
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

/// What one worker counts of triangles, and those that it found for each part.
struct alignas(worker_alignment) Share {
    std::uint64_t cut = 0;
    std::uint64_t degenerate = 0;
    std::uint64_t horizontal = 0;
    std::vector<std::vector<std::uint32_t>> parts;
};

/// Twice the areas of horizontal faces within a slab, in square units.
struct FlatAreas {
    Int128 up = 0;
    Int128 down = 0;
};

/// A vertex, with the edges that leave it; in the root of a set also what the set adds up to.
struct Node {
    std::uint32_t parent;  ///< towards the root, which is its own
    PlaneIndex slab;
    std::uint32_t lowest;  ///< vertices
    std::uint32_t highest;
    std::uint32_t triangles = 0;  ///< within the slab, whose first vertex it is
    bool meets_below = false;
    bool meets_above = false;
};

/// What a worker needs for one part after another; its memory is kept.
struct Scratch {
    NumberTable<GridVertex, quick_hash_of> numbers;
    std::vector<Node> nodes;

    std::uint32_t root(std::uint32_t node) noexcept {
        while (nodes[node].parent != node) {
            nodes[node].parent = nodes[nodes[node].parent].parent;  // halves the path
            node = nodes[node].parent;
        }
        return node;
    }
};

/// By SurfacePieceKind.
constexpr std::array counts_in_slab = {&LedgerSlab::shells, &LedgerSlab::peaks, &LedgerSlab::pits};
constexpr std::array counts_in_ledger = {&Ledger::shells, &Ledger::peaks, &Ledger::pits};

constexpr std::size_t grain = 4096;

/// Slabs are shared among parts, in ranges that hold about as many triangles each, so that threads can take one after the
/// other and its vertices stay in the cache.
template <class Reader>
class Bookkeeping {
public:
    Bookkeeping(const SlicedMesh& sliced, const Reader& read, const Parallel& parallel)
        : read_(read),
          result_(sliced.result),
          planes_(sliced.planes),
          parallel_(parallel),
          triangles_(sliced.mesh.triangle_count),
          part_of_(std::size_t{planes_.size()} + 1),
          flat_areas_(part_of_.size()),
          shares_(static_cast<std::size_t>(parallel.threads())) {}

    Ledger run() {
        choose_parts();
        share_out();
        Ledger ledger;
        ledger.slabs.resize(part_of_.size());
        std::vector<std::vector<SurfacePiece>> pieces(part_of_.back() + 1);
        std::vector<Scratch> workers(shares_.size());
        parallel_.run(pieces.size(), [&](std::size_t part, int worker) {
            Scratch& scratch = workers[static_cast<std::size_t>(worker)];
            enter_part(part, scratch, ledger.slabs);
            pieces[part] = find_pieces(scratch);
        });
        for (const std::vector<SurfacePiece>& own : pieces) {
            for (const SurfacePiece& piece : own) {
                const auto kind = static_cast<std::size_t>(piece.kind);
                ++(ledger.slabs[piece.layer].*counts_in_slab[kind]);
                ++(ledger.*counts_in_ledger[kind]).count;
                (ledger.*counts_in_ledger[kind]).triangles += piece.triangles;
            }
            ledger.pieces.insert(ledger.pieces.end(), own.begin(), own.end());
        }
        sum_up(ledger);
        std::erase_if(ledger.slabs,
                      [](const LedgerSlab& slab) { return slab.triangles + slab.shells + slab.peaks + slab.pits == 0; });
        ledger.gaps = find_gaps();
        return ledger;
    }

private:
    static constexpr std::uint32_t none = 0xffffffff;

    /// By samples of the triangles.
    void choose_parts() {
        constexpr std::size_t part_triangles = 1 << 14;
        constexpr std::size_t least_part_triangles = 1 << 11;
        constexpr std::size_t parts_for_balance = 16;  // so that a few threads end together
        constexpr std::size_t samples_a_part = 32;
        const std::size_t parts = std::max(
            {parts_for(triangles_, part_triangles), std::min(triangles_ / least_part_triangles, parts_for_balance)});
        std::vector<PlaneIndex> samples(std::min(triangles_, parts * samples_a_part));
        for (std::size_t i = 0; i < samples.size(); ++i) {
            samples[i] = planes_.first_above(read_(triangles_ * i / samples.size())[0].z);
        }
        sort_briefly(samples.begin(), samples.end());
        std::size_t part = 0;
        for (std::size_t slab = 0; slab < part_of_.size(); ++slab) {
            while (part + 1 < parts && samples[samples.size() * (part + 1) / parts] <= slab) {
                ++part;
            }
            part_of_[slab] = static_cast<std::uint32_t>(part);
        }
    }

    /// Each triangle to the parts of its vertices.
    void share_out() {
        for (Share& share : shares_) {
            share.parts.resize(part_of_.back() + 1);
        }
        parallel_.run_ranges(triangles_, grain, [&](std::size_t begin, std::size_t end, int worker) {
            for (std::size_t t = begin; t < end; ++t) {
                enter(static_cast<std::uint32_t>(t), shares_[static_cast<std::size_t>(worker)]);
            }
        });
    }

    void sum_up(Ledger& ledger) const {
        ledger.triangles = triangles_;
        for (const Share& own : shares_) {
            ledger.cut += own.cut;
            ledger.degenerate += own.degenerate;
            ledger.horizontal += own.horizontal;
        }
        ledger.between = ledger.triangles - ledger.cut - ledger.degenerate;
        const double half_mm2 = result_.info.grid_mm * result_.info.grid_mm / 2;
        for (std::size_t i = 0; i < ledger.slabs.size(); ++i) {
            LedgerSlab& slab = ledger.slabs[i];
            slab.layer = i;
            slab.flat_up_mm2 = static_cast<double>(flat_areas_[i].up) * half_mm2;
            slab.flat_down_mm2 = static_cast<double>(flat_areas_[i].down) * half_mm2;
            ledger.flat_up_mm2 += slab.flat_up_mm2;
            ledger.flat_down_mm2 += slab.flat_down_mm2;
        }
    }

    void enter(std::uint32_t t, Share& share) const {
        const SlabTriangle triangle(read_(t), planes_);
        if (is_degenerate(triangle.corners)) {
            ++share.degenerate;
            return;
        }
        const auto& [a, b, c] = triangle.slabs;
        share.parts[part_of_[a]].push_back(t);
        if (part_of_[b] != part_of_[a]) {
            share.parts[part_of_[b]].push_back(t);
        }
        if (part_of_[c] != part_of_[a] && part_of_[c] != part_of_[b]) {
            share.parts[part_of_[c]].push_back(t);
        }
        share.cut += triangle.within_one() ? 0U : 1U;
        share.horizontal += triangle.is_horizontal() ? 1U : 0U;
    }

    /// The pieces that do not join two planes, by layer, kind and place. Such a piece has a vertex in its slab, and all its
    /// vertices there are joined by edges that stay in the slab: so it is a set of vertices, and the edges that leave the
    /// slab show which planes it meets.
    std::vector<SurfacePiece> find_pieces(Scratch& scratch) const {
        std::vector<Node>& nodes = scratch.nodes;
        for (std::uint32_t node = 0; node < nodes.size(); ++node) {
            Node& root = nodes[scratch.root(node)];
            root.meets_below = root.meets_below || nodes[node].meets_below;
            root.meets_above = root.meets_above || nodes[node].meets_above;
        }
        const std::vector<GridVertex>& vertices = scratch.numbers.items();
        const auto comes_before = [](const GridVertex& a, const GridVertex& b, bool higher) {
            return a.z != b.z ? (a.z > b.z) == higher : std::tie(a.x, a.y) < std::tie(b.x, b.y);
        };
        std::vector<std::uint32_t> roots;
        for (std::uint32_t node = 0; node < nodes.size(); ++node) {
            const std::uint32_t root_number = scratch.root(node);
            Node& root = nodes[root_number];
            if (root.meets_below && root.meets_above) {
                continue;
            }
            if (root_number == node) {
                roots.push_back(node);
            } else {
                root.triangles += nodes[node].triangles;
            }
            root.lowest = comes_before(vertices[node], vertices[root.lowest], false) ? node : root.lowest;
            root.highest = comes_before(vertices[node], vertices[root.highest], true) ? node : root.highest;
        }
        std::vector<SurfacePiece> pieces;
        pieces.reserve(roots.size());
        for (const std::uint32_t root : roots) {
            pieces.push_back(piece_of(nodes[root], vertices));
        }
        sort_briefly(pieces.begin(), pieces.end(), [](const SurfacePiece& a, const SurfacePiece& b) {
            return std::tie(a.layer, a.kind, a.at_mm) < std::tie(b.layer, b.kind, b.at_mm);
        });
        return pieces;
    }

    /// The vertices of the part, united over the edges within a slab; and what its slabs hold.
    void enter_part(std::size_t part, Scratch& scratch, std::vector<LedgerSlab>& in_slabs) {
        std::vector<Node>& nodes = scratch.nodes;
        std::size_t triangles = 0;
        for (const Share& share : shares_) {
            triangles += share.parts[part].size();
        }
        scratch.numbers.clear(triangles / 2);  // a closed surface has half as many vertices as triangles
        nodes.clear();
        const auto node_at = [&](const GridVertex& vertex, PlaneIndex slab) {
            if (part_of_[slab] != part) {
                return none;
            }
            const std::uint32_t node = scratch.numbers.number(vertex);
            if (node == nodes.size()) {
                nodes.push_back({node, slab, node, node});
            }
            return node;
        };
        for (const Share& share : shares_) {
            for (const std::uint32_t t : share.parts[part]) {
                const SlabTriangle triangle(read_(t), planes_);
                const auto& [corners, slabs] = triangle;
                const std::array<std::uint32_t, 3> own = {node_at(corners[0], slabs[0]), node_at(corners[1], slabs[1]),
                                                          node_at(corners[2], slabs[2])};
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::size_t next = i == 2 ? 0 : i + 1;
                    if (slabs[i] != slabs[next]) {
                        const bool rises = slabs[i] < slabs[next];
                        if (const std::uint32_t low = rises ? own[i] : own[next]; low != none) {
                            nodes[low].meets_above = true;
                        }
                        if (const std::uint32_t high = rises ? own[next] : own[i]; high != none) {
                            nodes[high].meets_below = true;
                        }
                    } else if (own[i] != none) {
                        nodes[scratch.root(own[i])].parent = scratch.root(own[next]);
                    }
                }
                if (triangle.within_one()) {
                    ++nodes[own[0]].triangles;
                    ++in_slabs[slabs[0]].triangles;
                }
                if (triangle.is_horizontal()) {
                    const auto& [u, v, w] = corners;
                    const Int128 area = side_of_line({u.x, u.y}, {v.x, v.y}, {w.x, w.y});  // positive if it faces up
                    FlatAreas& areas = flat_areas_[slabs[0]];
                    (area > 0 ? areas.up : areas.down) += area > 0 ? area : -area;
                }
            }
        }
    }

    SurfacePiece piece_of(const Node& root, const std::vector<GridVertex>& vertices) const {
        const SurfacePieceKind kind = root.meets_below   ? SurfacePieceKind::peak
                                      : root.meets_above ? SurfacePieceKind::pit
                                                         : SurfacePieceKind::shell;
        const double grid_mm = result_.info.grid_mm;
        const GridVertex& lowest = vertices[root.lowest];
        const GridVertex& highest = vertices[root.highest];
        const GridVertex& at = kind == SurfacePieceKind::peak ? highest : lowest;
        const double low = kind == SurfacePieceKind::peak ? planes_.z(root.slab - 1) : lowest.z;
        const double high = kind == SurfacePieceKind::pit ? planes_.z(root.slab) : highest.z;
        return {kind, root.slab, {at.x * grid_mm, at.y * grid_mm, at.z * grid_mm}, (high - low) * grid_mm, root.triangles};
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
    std::vector<std::uint32_t> part_of_;  ///< by slab, ascending
    std::vector<FlatAreas> flat_areas_;   ///< by slab
    std::vector<Share> shares_;           ///< by worker
};

}  // namespace

std::string_view name_of(SurfacePieceKind kind) noexcept {
    constexpr std::array<std::string_view, 3> names = {"shell", "peak", "pit"};
    return names[static_cast<std::size_t>(kind)];
}

Ledger make_ledger(const SlicedMesh& sliced, const Parallel& parallel, double progress) {
    parallel.begin_stage(progress, 2);
    return with_reader(sliced.mesh, sliced.placing, sliced.result.info.grid_mm,
                       [&](const auto& read) { return Bookkeeping(sliced, read, parallel).run(); });
}

}  // namespace lamella
