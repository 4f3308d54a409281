#include "lamella/audit.hpp"

#include <algorithm>
#include <functional>

#include "audit/questions.hpp"
#include "audit/slab_pieces.hpp"
#include "base/parallel_sort.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

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
        : mesh_(sliced.mesh),
          read_(read),
          result_(sliced.result),
          planes_(sliced.planes),
          parallel_(parallel),
          triangles_(mesh_.triangle_count),
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
                add_all(share.parts[part], pieces);
            }
            pieces.finish(entries[part].slabs, entries[part].pieces);
        });
        return entries;
    }

    void add_all(const std::vector<std::uint32_t>& triangles, SlabPieces& pieces) const {
        constexpr std::size_t ahead = 16;
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            prefetch(triangles[std::min(i + ahead, triangles.size() - 1)]);
            pieces.add(SlabTriangle(read_(triangles[i]), planes_));
        }
    }

    /// Reads ahead the memory of one triangle.
    void prefetch(std::uint32_t t) const noexcept {
#ifdef __GNUC__
        const auto* const at = mesh_.indices != nullptr ? mesh_.indices_at(t) : mesh_.vertex_at(t);
        __builtin_prefetch(at);
        __builtin_prefetch(at + (mesh_.indices != nullptr ? 12 : mesh_.vertex_step()) - 1);
#endif
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

    const MeshView& mesh_;
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
