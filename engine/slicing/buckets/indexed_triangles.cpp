#include "slicing/buckets/indexed_triangles.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "base/parallel.hpp"
#include "slicing/buckets/bucket_parts.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

void place_vertices(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                    const Parallel& parallel, VertexTable& table) {
    const PlacedReader read(vertices_of(mesh), transform);
    table.placed.resize_discarding(mesh.vertex_count);
    for_each_block({mesh.vertex_count, parallel}, parallel, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            if (table.has(vertex)) {
                const std::array<double, 3> mm = read.corner(vertex, 0);
                const GridVertex at{to_even_grid(mm[0], unit_mm), to_even_grid(mm[1], unit_mm),
                                    to_even_grid(mm[2], unit_mm)};
                table.placed[vertex] = {at, planes.first_above(at.z)};
            }
        }
    });
}

/// The corners of a triangle, where they are placed.
struct Corners {
    const PlacedVertex& a;
    const PlacedVertex& b;
    const PlacedVertex& c;

    Corners(const MeshView& mesh, const VertexTable& table, std::size_t t) noexcept
        : a(table.placed[mesh.vertex_of(t, 0)]),
          b(table.placed[mesh.vertex_of(t, 1)]),
          c(table.placed[mesh.vertex_of(t, 2)]) {}

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
std::uint64_t count_block(const MeshView& mesh, const VertexTable& table, std::size_t begin, std::size_t end,
                          PartCounts counts, std::uint64_t& degenerate) {
    std::uint64_t mask = 0;
    for (std::size_t t = begin; t < end; ++t) {
        const Corners v(mesh, table, t);
        const PlaneIndex first = v.first_plane();
        const PlaneIndex last = v.last_plane();
        std::uint32_t crossed = (first - last) >> 31;  // both are less than 2^31
        if (v.degenerate()) {
            ++degenerate;
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

void count_crossings(const MeshView& mesh, const Transform& transform, double unit_mm, VertexTable& table,
                     const PlaneSet& planes, const Parallel& parallel, Buckets& buckets) {
    place_vertices(mesh, transform, unit_mm, planes, parallel, table);
    const BucketParts parts(mesh.triangle_count, parallel);
    buckets.crossed_mask.resize_discarding(parts.blocks());
    buckets.touched.set_size(0);
    make_counters(planes, parts.count, buckets);
    std::fill(buckets.counters.begin(), buckets.counters.end(), 0U);
    PerWorker<std::uint64_t> degenerate(parts.count);
    for_each_block(parts, parallel, [&](std::size_t part, std::size_t begin, std::size_t end) {
        const PartCounts counts(buckets, part, planes.size());
        buckets.crossed_mask[begin / block_triangles] = count_block(mesh, table, begin, end, counts, degenerate[part]);
    });
    buckets.degenerate = 0;
    degenerate.for_each([&buckets](std::uint64_t of_part) { buckets.degenerate += of_part; });
    sum_up(planes, parts.count, buckets);
}

std::size_t scatter_triangles(const MeshView& mesh, const VertexTable& table, const PlaneSet& planes,
                              std::span<const PlaneIndex> reach_end, const Parallel& parallel, Buckets& buckets,
                              std::span<Reaching> reaching) {
    const BucketParts parts(mesh.triangle_count, parallel);
    buckets.records.resize_discarding(buckets.list_begin[planes.size()]);
    ReachingOutput output(reaching, parts.count);
    for_each_block(parts, parallel, [&, mesh](std::size_t part, std::size_t begin, std::size_t) {
        const PartCursors cursors(buckets, part, planes.size());
        // First where records go, then the records: a store that waits for memory would hold up the next ones.
        std::uint32_t places[block_triangles];
        std::size_t count = 0;
        const std::uint64_t mask = buckets.crossed_mask[begin / block_triangles];
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const Corners v(mesh, table, begin + static_cast<std::size_t>(std::countr_zero(crossed)));
            const PlaneIndex first = v.first_plane();
            const std::uint32_t at = cursors.next_record[first]++;
            __builtin_prefetch(buckets.records.data() + at, 1);
            places[count++] = at;
            if (v.last_plane() > reach_end[first]) {
                output.add(part, {at, first, v.last_plane()});
            }
        }
        count = 0;
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const std::size_t t = begin + static_cast<std::size_t>(std::countr_zero(crossed));
            write_record(Corners(mesh, table, t), static_cast<std::uint32_t>(t), buckets.records[places[count++]]);
        }
    });
    return output.finish();
}

}  // namespace lamella
