#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

/// The corners of a triangle, where they are placed.
struct Corners {
    const PlacedVertex& a;
    const PlacedVertex& b;
    const PlacedVertex& c;

    Corners(const MeshView& mesh, const PlacedVertex* vertices, std::size_t t) noexcept
        : a(vertices[mesh.vertex_of(t, 0)]), b(vertices[mesh.vertex_of(t, 1)]), c(vertices[mesh.vertex_of(t, 2)]) {}

    PlaneIndex first_plane() const noexcept { return least(least(a.above, b.above), c.above); }
    PlaneIndex last_plane() const noexcept { return greatest(greatest(a.above, b.above), c.above); }
    bool degenerate() const noexcept { return a.at == b.at || b.at == c.at || c.at == a.at; }

private:
    // By the sign of a difference: compilers make branches of comparisons, and which corner is the lowest cannot be
    // predicted.
    static std::int32_t excess(PlaneIndex left, PlaneIndex right) noexcept {
        return static_cast<std::int32_t>(left - right);
    }
    static PlaneIndex least(PlaneIndex left, PlaneIndex right) noexcept {
        const std::int32_t over = excess(left, right);
        return right + static_cast<PlaneIndex>(over & (over >> 31));
    }
    static PlaneIndex greatest(PlaneIndex left, PlaneIndex right) noexcept {
        const std::int32_t over = excess(left, right);
        return left - static_cast<PlaneIndex>(over & (over >> 31));
    }
};

/// Counts triangles [begin, end), at most 64, and returns which of them planes cut. What is not cut adds zero: there is no
/// branch on it.
std::uint64_t count_block(const MeshView& mesh, const PlacedVertex* vertices, std::size_t begin, std::size_t end,
                          ShareCounts& counts) {
    std::uint64_t mask = 0;
    for (std::size_t t = begin; t < end; ++t) {
        const Corners v(mesh, vertices, t);
        const PlaneIndex first = v.first_plane();
        const PlaneIndex last = v.last_plane();
        std::uint32_t crossed = (first - last) >> 31;  // both are less than 2^31
        if (v.degenerate()) {
            ++counts.degenerate;
            crossed = 0;
        }
        counts.starting[first] += crossed;
        counts.ended[last] += crossed;
        mask |= std::uint64_t{crossed} << (t - begin);
    }
    return mask;
}

/// Field by field where it belongs: a record that is made elsewhere and copied by vectors waits until the fields that were
/// just stored can be loaded again, which takes longer than everything else here.
void write_record(const Corners& v, std::uint32_t triangle, CrossedTriangle& to) noexcept {
    const PlacedVertex* const corners[3] = {&v.a, &v.b, &v.c};
    const HeightOrder& order = height_order_of(v.a.at.z, v.b.at.z, v.c.at.z);
    const PlacedVertex& middle = *corners[order.middle];
    const PlacedVertex& upper = *corners[order.upper];
    to.lower = corners[order.lower]->at;
    to.middle = middle.at;
    to.upper = upper.at;
    to.triangle = triangle;
    to.middle_and_source = middle.above | source_bit(order);
    to.last = upper.above;
}

}  // namespace

void IndexedSource::place_vertices() {
    const PlacedReader read(vertices(), placing_);
    const Array<std::uint8_t>& used = buckets_.used;
    buckets_.vertices.resize_discarding(mesh_.vertex_count);
    const ThreadShares shares(mesh_.vertex_count, parallel_);
    parallel_.run(shares.count, [&](std::size_t share, int) {
        shares.for_each_block(share, parallel_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t vertex = begin; vertex < end; ++vertex) {
                if (used.empty() || used[vertex] != 0) {
                    const std::array<double, 3> mm = read.corner(vertex, 0);
                    const GridVertex at{to_even_grid(mm[0], unit_mm_), to_even_grid(mm[1], unit_mm_),
                                        to_even_grid(mm[2], unit_mm_)};
                    buckets_.vertices[vertex] = {at, planes_.first_above(at.z)};
                }
            }
        });
    });
}

void IndexedSource::count(double unit_mm) {
    unit_mm_ = unit_mm;
    place_vertices();
    const PlacedVertex* const vertices = buckets_.vertices.data();
    count_blocks({mesh_.triangle_count, parallel_}, parallel_, planes_.size(), buckets_,
                 [mesh = mesh_, vertices](std::size_t begin, std::size_t end, ShareCounts& counts) {
                     return count_block(mesh, vertices, begin, end, counts);
                 });
}

std::size_t IndexedSource::scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) {
    const PlacedVertex* const vertices = buckets_.vertices.data();
    const auto scatter_block = [&, mesh = mesh_](std::size_t begin, std::uint64_t mask, std::uint32_t* next_record,
                                                 ReachingWriter& writer) {
        // First where records go, then the records: a store that waits for memory would hold up the next ones.
        std::uint32_t places[block_triangles];
        std::size_t count = 0;
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const Corners v(mesh, vertices, begin + static_cast<std::size_t>(std::countr_zero(crossed)));
            const PlaneIndex first = v.first_plane();
            const std::uint32_t at = next_record[first]++;
            __builtin_prefetch(buckets_.records.data() + at, 1);
            places[count++] = at;
            if (v.last_plane() > reach_end[first]) {
                writer.add({at, first, v.last_plane()});
            }
        }
        count = 0;
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const std::size_t t = begin + static_cast<std::size_t>(std::countr_zero(crossed));
            write_record(Corners(mesh, vertices, t), static_cast<std::uint32_t>(t), buckets_.records[places[count++]]);
        }
    };
    const std::size_t reaching_count =
        scatter_blocks({mesh_.triangle_count, parallel_}, parallel_, planes_.size(), buckets_, reaching, scatter_block);
    if (origins) {
        find_lowest_corners();
    }
    return reaching_count;
}

}  // namespace lamella
