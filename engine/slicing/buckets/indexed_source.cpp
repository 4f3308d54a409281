#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <span>

#include "base/atomic_word.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = std::size_t{1} << 12;  // vertices or triangles of a task, at least

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
    buckets_.vertices.resize_discarding(mesh_.vertex_count);
    parallel_.run_ranges(mesh_.vertex_count, grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            if (buckets_.used[vertex] != 0) {
                const std::array<double, 3> mm = read.corner(vertex, 0);
                const GridVertex at{to_even_grid(mm[0], unit_mm_), to_even_grid(mm[1], unit_mm_),
                                    to_even_grid(mm[2], unit_mm_)};
                buckets_.vertices[vertex] = {at, planes_.first_above(at.z)};
            }
        }
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

namespace {

/// Marks the vertices of triangles [begin, end); false where an index names none.
template <class Index>
bool mark_corners(const MeshView& mesh, std::size_t begin, std::size_t end, std::uint8_t* used) noexcept {
    bool all_exist = true;
    const std::byte* at = mesh.indices_at(begin);
    for (std::size_t t = begin; t < end; ++t, at += mesh.index_step()) {
        std::array<Index, 3> corners;
        std::memcpy(corners.data(), at, sizeof corners);
        for (const Index vertex : corners) {
            if (vertex < mesh.vertex_count) {
                AtomicWord(used[vertex]).store(1);
            } else {
                all_exist = false;
            }
        }
    }
    return all_exist;
}

}  // namespace

/// False where an index names no vertex.
bool IndexedSource::mark_used() {
    Array<std::uint8_t>& used = buckets_.used;
    used.resize_discarding(mesh_.vertex_count);
    std::fill(used.begin(), used.end(), std::uint8_t{0});
    std::atomic<bool> all_exist = true;
    parallel_.run_ranges(mesh_.triangle_count, grain, [&](std::size_t begin, std::size_t end, int) {
        const auto mark = mesh_.index_type == Number::u32 ? mark_corners<std::uint32_t> : mark_corners<std::uint64_t>;
        if (!mark(mesh_, begin, end, used.data())) {
            all_exist = false;
        }
    });
    return all_exist;
}

/// The box of an indexed mesh is that of the vertices that triangles have: others may be no numbers.
Bounds IndexedSource::measure(double asked_mm) {
    struct VertexBox {
        Bounds box = Bounds::empty();
        double poison = 0;  ///< times zero: becomes NaN, and stays so, at the first value that is not finite
    };
    require(check_mesh(mesh_));
    require(check_transform(placing_.transform));
    if (mark_used()) {
        const PlacedReader read(vertices(), placing_);
        PerWorker<VertexBox> boxes(static_cast<std::size_t>(parallel_.threads()));
        parallel_.run_ranges(mesh_.vertex_count, grain, [&](std::size_t begin, std::size_t end, int worker) {
            VertexBox& all = boxes[static_cast<std::size_t>(worker)];
            VertexBox own = all;
            for (std::size_t vertex = begin; vertex < end; ++vertex) {
                if (buckets_.used[vertex] != 0) {
                    const std::array<double, 3> at = read.corner(vertex, 0);
                    for (int axis = 0; axis < 3; ++axis) {
                        const double mm = at[static_cast<std::size_t>(axis)];
                        own.box.add(axis, mm, mm);
                        own.poison += mm * 0.0;
                    }
                }
            }
            all = own;
        });
        VertexBox all;
        boxes.for_each([&all](const VertexBox& own) {
            all.box.add(own.box);
            all.poison += own.poison;
        });
        if (mesh_.triangle_count > 0 && all.poison == 0 && all.box.farthest() <= largest_coordinate_mm) {
            return all.box;
        }
    }
    return require(measure_bounds(mesh_, placing_, asked_mm, parallel_, buckets_.blocks));
}

std::unique_ptr<TriangleSource> source_of(const MeshView& mesh, const Placing& placing, const SharedFrame* frame,
                                          const SourceTools& tools) {
    if (IndexedSource::pays_for(mesh)) {
        return std::make_unique<IndexedSource>(mesh, placing, frame, tools);
    }
    return std::make_unique<SoupSource>(mesh, placing, frame, tools);
}

}  // namespace lamella
