#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <span>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/system/atomic_word.hpp"
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

std::size_t IndexedSource::scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                                   bool origins) {
    return scatter_blocks(
        {mesh_.triangle_count, parallel_}, parallel_, buckets_, tier, reach_end, reaching, origins,
        [read = triangles_of(mesh_, buckets_.vertices.data())](std::size_t begin, std::uint64_t crossed, ShareRecords& to) {
            to.write_each(read, begin, crossed);
        });
}

// The box of an indexed mesh, which is that of the vertices that triangles have.
//
//          +-----------b        The box of all vertices is that box if some vertex on each of its faces is a corner of a
//          | x   x     |        triangle: the least and the greatest along each axis, at most six vertices, are looked for
//          a     x   x |        among the indices. That reads them and writes nothing. Only where one of the six is not
//          +---c-------d        found, or some vertex is no number, all vertices that triangles have are marked.

namespace {

constexpr std::size_t faces = 6;  // least x, y, z, greatest x, y, z

using VertexNumbers = std::array<std::uint64_t, faces>;

/// A box that grows, and a vertex on each of its faces.
struct VertexBox {
    Bounds box = Bounds::empty();
    double poison = 0;  ///< times zero: becomes NaN, and stays so, at the first value that is not finite
    VertexNumbers on_face{};

    void include(std::size_t axis, double at, std::uint64_t vertex) noexcept {
        if (at < box.min_mm[axis]) {
            box.min_mm[axis] = at;
            on_face[axis] = vertex;
        }
        if (at > box.max_mm[axis]) {
            box.max_mm[axis] = at;
            on_face[3 + axis] = vertex;
        }
    }
    void add(const VertexBox& other) noexcept {
        for (std::size_t axis = 0; axis < 3 && other.box.min_mm[axis] <= other.box.max_mm[axis]; ++axis) {
            include(axis, other.box.min_mm[axis], other.on_face[axis]);
            include(axis, other.box.max_mm[axis], other.on_face[3 + axis]);
        }
        poison += other.poison;
    }
    bool can_be_used() const noexcept { return poison == 0 && box.farthest() <= largest_coordinate_mm; }
};

/// A value of each share, by use(begin, end, value) for every block of `count` vertices or triangles; all are then added up.
template <class T, class Use>
T sum_of_blocks(std::size_t count, const Parallel& parallel, Use use) {
    const ThreadShares shares(count, parallel);
    PerWorker<T> values(shares.count);
    parallel.run(shares.count, [&](std::size_t share, int) {
        T own;
        shares.for_each_block(share, parallel, [&](std::size_t begin, std::size_t end) { use(begin, end, own); });
        values[share] = own;
    });
    T all;
    values.for_each([&all](const T& value) { all.add(value); });
    return all;
}

/// The box of those of `vertices`, see IndexedSource::vertices(), for which has(vertex) is true.
template <class Has>
VertexBox box_of(const MeshView& vertices, const Placing& placing, const Parallel& parallel, Has has) {
    const PlacedReader read(vertices, placing);
    return sum_of_blocks<VertexBox>(vertices.triangle_count, parallel,
                                    [&](std::size_t begin, std::size_t end, VertexBox& box) {
                                        for (std::size_t vertex = begin; vertex < end; ++vertex) {
                                            if (has(vertex)) {
                                                const std::array<double, 3> at = read.corner(vertex, 0);
                                                for (std::size_t axis = 0; axis < 3; ++axis) {
                                                    box.include(axis, at[axis], vertex);
                                                    box.poison += at[axis] * 0.0;
                                                }
                                            }
                                        }
                                    });
}

/// The largest index of a run, and which wanted ones it has. Without branches, so that the compiler makes vectors of it.
template <class Index>
struct Seen {
    Index largest = 0;
    std::array<Index, faces> on_face{};  ///< not 0: the vertex on that face was seen

    void look(const std::byte* indices, std::size_t count, const std::array<Index, faces>& on_faces) noexcept {
        for (std::size_t i = 0; i < count; ++i) {
            Index index;
            std::memcpy(&index, indices + i * sizeof index, sizeof index);
            largest = std::max(largest, index);
            for (std::size_t face = 0; face < faces; ++face) {
                on_face[face] |= Index{index == on_faces[face]};
            }
        }
    }
    void add(const Seen& other) noexcept {
        largest = std::max(largest, other.largest);
        for (std::size_t face = 0; face < faces; ++face) {
            on_face[face] |= other.on_face[face];
        }
    }
};

/// True if triangles have all of these vertices, and no index names none. May be false, too, where indices are not packed.
template <class Index>
bool have_all(const MeshView& mesh, const VertexNumbers& wanted, const Parallel& parallel) {
    if (mesh.index_step() != 3 * sizeof(Index)) {
        return false;
    }
    std::array<Index, faces> on_faces;
    std::transform(wanted.begin(), wanted.end(), on_faces.begin(), [](std::uint64_t v) { return static_cast<Index>(v); });
    const auto all = sum_of_blocks<Seen<Index>>(mesh.triangle_count, parallel,
                                                [&](std::size_t begin, std::size_t end, Seen<Index>& seen) {
                                                    Seen<Index> here;  // stays in registers
                                                    here.look(mesh.indices_at(begin), 3 * (end - begin), on_faces);
                                                    seen.add(here);
                                                });
    return all.largest < mesh.vertex_count &&
           std::none_of(all.on_face.begin(), all.on_face.end(), [](Index found) { return found == 0; });
}

}  // namespace

/// False where an index names no vertex.
bool IndexedSource::mark_used() {
    Array<std::uint8_t>& used = buckets_.used;
    used.resize_discarding(mesh_.vertex_count);
    std::fill(used.begin(), used.end(), std::uint8_t{0});
    std::atomic<bool> is_beyond = false;
    const ThreadShares shares(mesh_.triangle_count, parallel_);
    parallel_.run(shares.count, [&](std::size_t share, int) {
        shares.for_each_block(share, parallel_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t corner = 3 * begin; corner < 3 * end; ++corner) {
                const std::uint64_t vertex = mesh_.vertex_of(corner / 3, corner % 3);
                if (vertex < mesh_.vertex_count) {
                    AtomicWord(used[vertex]).store(1);
                } else {
                    is_beyond = true;
                }
            }
        });
    });
    return !is_beyond;
}

Bounds IndexedSource::measure(double asked_mm) {
    require(check_mesh(mesh_));
    require(check_transform(placing_.transform));
    buckets_.used.set_size(0);
    const VertexBox all = box_of(vertices(), placing_, parallel_, [](std::size_t) { return true; });
    if (all.can_be_used() && (mesh_.index_type == Number::u32 ? have_all<std::uint32_t>(mesh_, all.on_face, parallel_)
                                                              : have_all<std::uint64_t>(mesh_, all.on_face, parallel_))) {
        return all.box;
    }
    if (mark_used()) {
        const VertexBox used =
            box_of(vertices(), placing_, parallel_, [this](std::size_t vertex) { return buckets_.used[vertex] != 0; });
        if (used.can_be_used()) {
            return used.box;
        }
    }
    return require(measure_bounds(mesh_, placing_, asked_mm, parallel_, buckets_.blocks));
}

TriangleSource& source_of(const MeshView& mesh, const Placing& placing, const SharedFrame* frame, const SourceTools& tools,
                          AnySource& source) {
    if (IndexedSource::pays_for(mesh)) {
        return source.emplace<IndexedSource>(mesh, placing, frame, tools);
    }
    return source.emplace<SoupSource>(mesh, placing, frame, tools);
}

}  // namespace lamella
