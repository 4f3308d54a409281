#include "slicing/buckets/indexed_triangles.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "base/atomic_word.hpp"
#include "base/per_worker.hpp"
#include "slicing/buckets/bucket_parts.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

/// The vertices alone, as "triangles" whose first corner they are.
MeshView vertices_of(const MeshView& mesh) noexcept {
    return MeshView::strided_soup(mesh.vertices, mesh.vertex_count, mesh.stride, mesh.coordinate_type);
}

struct VertexBox {
    static constexpr double infinity = std::numeric_limits<double>::infinity();
    double min[3] = {infinity, infinity, infinity};
    double max[3] = {-infinity, -infinity, -infinity};
    double poison = 0;  ///< times zero: becomes NaN, and stays so, at the first value that is not finite

    void add(const std::array<double, 3>& vertex) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            min[axis] = std::min(min[axis], vertex[axis]);
            max[axis] = std::max(max[axis], vertex[axis]);
            poison += vertex[axis] * 0.0;
        }
    }
    void add(const VertexBox& other) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            min[axis] = std::min(min[axis], other.min[axis]);
            max[axis] = std::max(max[axis], other.max[axis]);
        }
        poison += other.poison;
    }
    bool can_be_used() const noexcept {
        double largest = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            largest = std::max({largest, std::abs(min[axis]), std::abs(max[axis])});
        }
        return poison == 0 && largest <= largest_coordinate_mm;
    }
};

/// Calls use(part, begin, end) for every block of `parts`: parts by different threads. A part of the triangles mostly has
/// the vertices of the same part of the vertices, so that what a core has written, it reads again.
template <class Use>
void for_each_block(const BucketParts& parts, const Parallel& parallel, Use use) {
    parallel.run(parts.count, [&](std::size_t part, int) {
        for (std::size_t block = parts.begin_block(part); block < parts.begin_block(part + 1); ++block) {
            if (block % blocks_between_stops == 0) {
                parallel.stop_if_asked();
            }
            const std::size_t begin = block * block_triangles;
            use(part, begin, std::min(begin + block_triangles, parts.triangles));
        }
    });
}

/// False where an index names no vertex.
bool mark_used(const MeshView& mesh, const Parallel& parallel, Array<std::uint8_t>& used) {
    used.resize_discarding(mesh.vertex_count);
    std::fill(used.begin(), used.end(), std::uint8_t{0});
    const BucketParts parts(mesh.triangle_count, parallel);
    PerWorker<std::uint8_t> beyond(parts.count);
    for_each_block(parts, parallel, [&, mesh](std::size_t part, std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::uint64_t vertex = mesh.vertex_of(t, corner);
                if (vertex < mesh.vertex_count) {
                    AtomicWord(used[vertex]).store(1);
                } else {
                    beyond[part] = 1;
                }
            }
        }
    });
    bool all_within = true;
    beyond.for_each([&all_within](std::uint8_t of_part) { all_within = all_within && of_part == 0; });
    return all_within;
}

void place_vertices(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                    const Parallel& parallel, VertexTable& table) {
    const PlacedReader read(vertices_of(mesh), transform);
    table.placed.resize_discarding(mesh.vertex_count);
    for_each_block({mesh.vertex_count, parallel}, parallel, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            if (table.used[vertex] != 0) {
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

CrossedTriangle record_of(const Corners& v, std::uint32_t triangle) noexcept {
    const PlacedVertex* const corners[3] = {&v.a, &v.b, &v.c};
    const HeightOrder& order = height_order_of(v.a.at.z, v.b.at.z, v.c.at.z);
    const PlacedVertex& middle = *corners[order.middle];
    const PlacedVertex& upper = *corners[order.upper];
    return {corners[order.lower]->at, middle.at, upper.at, {triangle}, middle.above | source_bit(order), upper.above};
}

}  // namespace

Result<Bounds> measure_bounds(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel,
                              VertexTable& table, BlockTable& blocks) {
    VertexBox all;
    if (mark_used(mesh, parallel, table.used)) {
        const PlacedReader read(vertices_of(mesh), transform);
        const BucketParts parts(mesh.vertex_count, parallel);
        PerWorker<VertexBox> boxes(parts.count);
        for_each_block(parts, parallel, [&](std::size_t part, std::size_t begin, std::size_t end) {
            VertexBox box;
            for (std::size_t vertex = begin; vertex < end; ++vertex) {
                if (table.used[vertex] != 0) {
                    box.add(read.corner(vertex, 0));
                }
            }
            boxes[part].add(box);
        });
        boxes.for_each([&all](const VertexBox& box) { all.add(box); });
    }
    if (!all.can_be_used()) {
        return measure_bounds(mesh, transform, unit_mm, parallel, blocks);
    }
    Bounds bounds{};
    std::copy_n(all.min, 3, bounds.min_mm);
    std::copy_n(all.max, 3, bounds.max_mm);
    return bounds;
}

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
            buckets.records[places[count++]] = record_of(Corners(mesh, table, t), static_cast<std::uint32_t>(t));
        }
    });
    return output.finish();
}

}  // namespace lamella
