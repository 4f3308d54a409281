#include "slicing/sweep/wide_plane.hpp"

#include <algorithm>
#include <bit>

#include "base/system/atomic_word.hpp"
#include "lamella/context.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = 1 << 13;        // segments per task
constexpr std::size_t block = 16;             // segments whose table entries are prefetched together
constexpr std::uint32_t piece_stride = 64;    // one in so many segments begins a piece
constexpr std::size_t stop_stride = 1 << 14;  // segments that are looked up, a part of a range, between two stop requests
constexpr std::size_t segment_work = 16;      // as StopPace counts it: its successor waits for memory

}  // namespace

/// Where the ends of segments meet, by edge. An entry is 0, or from the highest bit down
///
///     [ 30 bits of the hash | both ends have come | 1 | segment of the first end, 31 bits | whether it is a source ]
class WidePlane::Table {
public:
    Table(std::size_t segments, const Memory* memory, const Parallel& parallel) : entries_(memory) {
        const std::size_t size = std::bit_ceil(segments + segments / 4 + 16);
        shift_ = 64 - std::countr_zero(size);
        entries_.resize_discarding(size);
        const std::size_t stretches = std::max<std::size_t>(size / stop_stride, 1);
        parallel.run_ranges(stretches, 4, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t stretch = begin; stretch < end; ++stretch) {
                parallel.stop_if_asked();
                std::fill(entries_.data() + size * stretch / stretches, entries_.data() + size * (stretch + 1) / stretches,
                          0);
            }
        });
    }

    void prefetch(std::uint64_t hash) const noexcept { prefetch_to_write(entries_.data() + (hash >> shift_)); }

    enum class Met {
        nobody,     ///< the first end of its edge
        partner,    ///< the second
        irregular,  ///< a third end, or a second of the same orientation
    };

    /// Enters an end, or finds the one that came first, whose segment is then in `partner`. `same_edge(segment, source)`
    /// compares edges.
    template <class SameEdge>
    Met meet(std::uint64_t hash, std::uint32_t segment, bool source, std::uint32_t& partner,
             const SameEdge& same_edge) noexcept {
        const std::uint64_t tag = (hash << 34) | present;
        const std::uint64_t mine = tag | (std::uint64_t{segment} << 1) | (source ? 1 : 0);
        const std::size_t mask = entries_.size() - 1;
        for (std::size_t i = hash >> shift_;; i = (i + 1) & mask) {
            const AtomicWord<std::uint64_t> place(entries_[i]);
            std::uint64_t entry = place.load();
            // A failed exchange means that another thread has just put an end here: look again.
            while (entry == 0 && !place.replace(entry, mine)) {
            }
            if (entry == 0) {
                return Met::nobody;
            }
            const bool other_source = (entry & 1) != 0;
            const auto other = static_cast<std::uint32_t>((entry & 0xFFFFFFFFU) >> 1);
            if (((entry ^ tag) & ~(complete | 0xFFFFFFFFU)) != 0 || !same_edge(other, other_source)) {
                continue;
            }
            // A failed exchange here means a third end: only the second one completes an entry.
            if ((entry & complete) != 0 || other_source == source || !place.replace(entry, entry | complete)) {
                return Met::irregular;
            }
            partner = other;
            return Met::partner;
        }
    }

private:
    static constexpr std::uint64_t present = std::uint64_t{1} << 32;
    static constexpr std::uint64_t complete = std::uint64_t{1} << 33;

    Array<std::uint64_t> entries_;
    int shift_ = 0;
};

bool WidePlane::build(PlaneIndex plane, std::span<const std::uint32_t> seeds, const Buckets& buckets, const PlaneSet& planes,
                      BandOutput& out) {
    plane_ = plane;
    seeds_ = seeds;
    buckets_ = &buckets;
    list_begin_ = buckets.list_of(plane);
    count_ = static_cast<std::uint32_t>(seeds.size()) + buckets.list_of(plane + 1) - list_begin_;
    if (!link()) {
        return false;
    }
    cut_into_pieces();
    string_together();
    trace(planes.z(plane), out.with_origins);
    layer_.read_traced(
        rings_.data(), out.with_origins ? origins_.data() : nullptr, contours_,
        [this](std::uint32_t at) { return to_key(edge_at(order_[at], true)); }, parallel_);
    layer_.build(out);
    return true;
}

/// The edge that a segment leaves or enters.
MeshEdge WidePlane::edge_at(std::uint32_t segment, bool source) const noexcept {
    const CrossedTriangle& t = triangle(segment);
    return source == t.long_edge_is_source() ? long_edge(t) : short_edge(t, t.middle_plane() <= plane_);
}

/// next_[i] = the segment that leaves the edge which segment i enters. False if an edge has not exactly one face either way.
bool WidePlane::link() {
    next_.resize_discarding(count_);
    Table table(count_, worker_.memory(), parallel_);
    std::atomic<bool> regular{true};
    std::atomic<std::uint64_t> linked{0};
    parallel_.run_ranges(count_, grain, [&](std::size_t begin, std::size_t end, int) {
        std::uint64_t own = 0;
        for (std::size_t at = begin; at < end && regular.load(std::memory_order_relaxed); at += block) {
            if ((at - begin) % stop_stride == 0) {
                parallel_.stop_if_asked();
            }
            const std::int64_t links =
                link_block(table, static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(std::min(at + block, end)));
            if (links < 0) {
                regular.store(false, std::memory_order_relaxed);
            } else {
                own += static_cast<std::uint64_t>(links);
            }
        }
        linked.fetch_add(own, std::memory_order_relaxed);
    });
    return regular.load() && linked.load() == count_;
}

/// Prefetches the entries of a block together, since each is likely to miss the cache. Returns the links made, or -1.
std::int64_t WidePlane::link_block(Table& table, std::uint32_t begin, std::uint32_t end) {
    MeshEdge edges[block][2];
    std::uint64_t hashes[block][2];
    for (std::uint32_t segment = begin; segment < end; ++segment) {
        for (const bool source : {false, true}) {
            MeshEdge& edge = edges[segment - begin][source ? 1 : 0];
            edge = edge_at(segment, source);
            table.prefetch(hashes[segment - begin][source ? 1 : 0] = edge.hash());
        }
    }
    std::int64_t links = 0;
    for (std::uint32_t segment = begin; segment < end; ++segment) {
        for (const bool source : {false, true}) {
            const MeshEdge& edge = edges[segment - begin][source ? 1 : 0];
            std::uint32_t partner = 0;
            const auto met =
                table.meet(hashes[segment - begin][source ? 1 : 0], segment, source, partner,
                           [&](std::uint32_t other, bool other_source) { return edge_at(other, other_source) == edge; });
            if (met == Table::Met::irregular) {
                return -1;
            }
            if (met == Table::Met::partner) {
                next_[source ? partner : segment] = source ? segment : partner;
                ++links;
            }
        }
    }
    return links;
}

// --- Walking

void WidePlane::cut_into_pieces() {
    pieces_.assign((count_ + piece_stride - 1) / piece_stride, Piece{});
    on_piece_.resize_discarding(count_);
    parallel_.run_ranges(count_, grain, [&](std::size_t begin, std::size_t end, int) {
        std::fill(on_piece_.data() + begin, on_piece_.data() + end, std::uint8_t{0});
    });
    walk_pieces();
    // Contours are left in which no number is divisible by 64.
    worker_.in_stretches(0, count_, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t segment = begin; segment < end; ++segment) {
            if (on_piece_[segment] == 0) {
                add_contour_as_piece(static_cast<std::uint32_t>(segment));
            }
        }
    });
}

void WidePlane::add_contour_as_piece(std::uint32_t first) {
    Piece piece{first, 0, first, 0};
    std::uint32_t segment = first;
    do {
        on_piece_[segment] = 1;
        segment = next_[segment];
        ++piece.count;
        worker_.spend(segment_work);
    } while (segment != first);
    pieces_.push_back(piece);
}

/// Each segment lies on one piece at most, so the pieces are walked independently.
void WidePlane::walk_pieces() {
    parallel_.run_ranges(pieces_.size(), grain / piece_stride, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t p = begin; p < end; ++p) {
            if (p % (stop_stride / piece_stride) == 0) {
                parallel_.stop_if_asked();
            }
            Piece piece{static_cast<std::uint32_t>(p) * piece_stride, 0, 0, 0};
            std::uint32_t segment = piece.first;
            do {
                on_piece_[segment] = 1;
                segment = next_[segment];
                ++piece.count;
            } while (segment % piece_stride != 0);
            piece.next = segment;
            pieces_[p] = piece;
        }
    });
}

/// Pieces become contours: a piece's successor begins where it ends. Offsets follow the walk.
void WidePlane::string_together() {
    const std::size_t numbered = (count_ + piece_stride - 1) / piece_stride;
    contours_.clear();
    std::uint64_t offset = 0;
    for (Piece& piece : pieces_) {
        piece.offset = ~std::uint64_t{0};
    }
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
        const std::uint64_t begin = offset;
        for (std::size_t at = p; pieces_[at].offset == ~std::uint64_t{0};) {
            worker_.spend(segment_work);
            pieces_[at].offset = offset;
            offset += pieces_[at].count;
            at = at < numbered ? pieces_[at].next / piece_stride : at;
        }
        if (offset > begin) {
            contours_.push_back(
                {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(offset - begin), true, false});
        }
    }
}

/// The second walk writes segments and points to their places. No two triangles have the same corners and orientation, as
/// each edge has one face on either side: an origin stands for itself.
void WidePlane::trace(std::int32_t z, bool with_origins) {
    order_.resize_discarding(count_);
    rings_.resize_discarding(count_);
    origins_.resize_discarding(with_origins ? count_ : 0);
    parallel_.run_ranges(pieces_.size(), grain / piece_stride, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t p = begin; p < end; ++p) {
            if (p % (stop_stride / piece_stride) == 0) {
                parallel_.stop_if_asked();
            }
            std::uint32_t segment = pieces_[p].first;
            for (std::uint64_t at = pieces_[p].offset; at < pieces_[p].offset + pieces_[p].count;
                 ++at, segment = next_[segment]) {
                order_[at] = segment;
                rings_[at] = pierced_point(edge_at(segment, true), z);
                if (with_origins) {
                    const std::uint32_t of = record(segment);
                    const CrossedTriangle& t = buckets_->records[of];
                    origins_[at] = origin_of(t, buckets_->lowest_corners[of], t.middle_plane() <= plane_);
                }
            }
        }
    });
}

}  // namespace lamella
