#include <array>
#include <span>

#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

/// A triangle by its placed corners, as count_each() and write_each() read it.
struct IndexedTriangle {
    const PlacedVertex* a;
    const PlacedVertex* b;
    const PlacedVertex* c;
    std::size_t number;

    bool is_degenerate() const noexcept { return a->at == b->at || b->at == c->at || c->at == a->at; }
    PlaneRange planes() const noexcept {
        return {least(least(a->above, b->above), c->above), greatest(greatest(a->above, b->above), c->above)};
    }

    /// Field by field where it belongs: a record that is made elsewhere and copied by vectors waits until the fields that
    /// were just stored can be loaded again, which takes longer than everything else here.
    std::uint8_t write(CrossedTriangle& to, PlaneIndex last) const noexcept {
        const PlacedVertex* const corners[3] = {a, b, c};
        const HeightOrder& order = height_order_of(a->at.z, b->at.z, c->at.z);
        const PlacedVertex& middle = *corners[order.middle];
        to.lower = corners[order.lower]->at;
        to.middle = middle.at;
        to.upper = corners[order.upper]->at;
        to.triangle = static_cast<std::uint32_t>(number);
        to.middle_and_source = middle.above | source_bit(order);
        to.last = last;
        return order.lower;
    }

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

/// Gives triangle t.
auto triangles_of(const MeshView& mesh, const PlacedVertex* vertices) noexcept {
    return [mesh, vertices](std::size_t t) {
        return IndexedTriangle{vertices + mesh.vertex_of(t, 0), vertices + mesh.vertex_of(t, 1),
                               vertices + mesh.vertex_of(t, 2), t};
    };
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
    count_blocks(
        {mesh_.triangle_count, parallel_}, parallel_, planes_.size(), buckets_,
        [read = triangles_of(mesh_, buckets_.vertices.data())](std::size_t begin, std::size_t end, ShareCounts& counts) {
            return count_each(read, begin, end, true, counts);
        });
}

std::size_t IndexedSource::scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) {
    return scatter_blocks(
        {mesh_.triangle_count, parallel_}, parallel_, buckets_, reach_end, reaching, origins,
        [read = triangles_of(mesh_, buckets_.vertices.data())](std::size_t begin, std::uint64_t crossed, ShareRecords& to) {
            to.write_each(read, begin, crossed);
        });
}

}  // namespace lamella
