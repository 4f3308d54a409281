// The box of an indexed mesh, which is that of the vertices that triangles have.
//
//          +-----------b        The box of all vertices is that box if some vertex on each of its faces is a corner of a
//          | x   x     |        triangle: the least and the greatest along each axis, at most six vertices, are looked for
//          a     x   x |        among the indices. That reads them and writes nothing. Only where one of the six is not
//          +---c-------d        found, or some vertex is no number, all vertices that triangles have are marked.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/atomic_word.hpp"
#include "base/parallel.hpp"
#include "slicing/buckets/bucket_parts.hpp"
#include "slicing/buckets/indexed_triangles.hpp"
#include "slicing/grid/placed_reader.hpp"

namespace lamella {

namespace {

constexpr std::size_t faces = 6;  // least x, y, z, greatest x, y, z

using VertexNumbers = std::array<std::uint64_t, faces>;

/// A box, and by face the first vertex of a block with a vertex on it.
struct VertexBox {
    static constexpr double infinity = std::numeric_limits<double>::infinity();
    double min[3] = {infinity, infinity, infinity};
    double max[3] = {-infinity, -infinity, -infinity};
    double poison = 0;  ///< times zero: becomes NaN, and stays so, at the first value that is not finite
    VertexNumbers block{};

    void add(const std::array<double, 3>& vertex) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            min[axis] = std::min(min[axis], vertex[axis]);
            max[axis] = std::max(max[axis], vertex[axis]);
            poison += vertex[axis] * 0.0;
        }
    }
    void add(const VertexBox& other) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (other.min[axis] < min[axis]) {
                min[axis] = other.min[axis];
                block[axis] = other.block[axis];
            }
            if (other.max[axis] > max[axis]) {
                max[axis] = other.max[axis];
                block[3 + axis] = other.block[3 + axis];
            }
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
    Bounds bounds() const noexcept {
        Bounds made{};
        std::copy_n(min, 3, made.min_mm);
        std::copy_n(max, 3, made.max_mm);
        return made;
    }
};

/// The vertices of an indexed mesh, where its transform places them.
class Vertices {
public:
    Vertices(const MeshView& mesh, const Transform& transform, const Parallel& parallel) noexcept
        : read_(vertices_of(mesh), transform), parts_(mesh.vertex_count, parallel), parallel_(parallel) {}

    /// The box of those for which has(vertex) is true.
    template <class Has>
    VertexBox box(Has has) const {
        PerWorker<VertexBox> boxes(parts_.count);
        for_each_block(parts_, parallel_, [&](std::size_t part, std::size_t begin, std::size_t end) {
            VertexBox box;
            box.block.fill(begin);
            for (std::size_t vertex = begin; vertex < end; ++vertex) {
                if (has(vertex)) {
                    box.add(read_.corner(vertex, 0));
                }
            }
            boxes[part].add(box);
        });
        VertexBox all;
        boxes.for_each([&all](const VertexBox& box) { all.add(box); });
        return all;
    }

    /// By face, the first vertex of a box of all that lies on it.
    VertexNumbers on_faces_of(const VertexBox& box) const noexcept {
        VertexNumbers found;
        for (std::size_t face = 0; face < faces; ++face) {
            const double at = face < 3 ? box.min[face] : box.max[face - 3];
            found[face] = box.block[face];
            while (read_.corner(found[face], 0)[face % 3] != at) {
                ++found[face];
            }
        }
        return found;
    }

private:
    PlacedReader read_;
    BucketParts parts_;
    const Parallel& parallel_;
};

/// What a run of indices has. Without branches, so that the compiler makes vectors of it.
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

/// Whether triangles have all of these vertices, and no index names none. May be false, too, where indices are not packed.
template <class Index>
bool have_all(const MeshView& mesh, const VertexNumbers& wanted, const Parallel& parallel) {
    if (mesh.index_stride != 3 * sizeof(Index)) {
        return false;
    }
    std::array<Index, faces> on_faces;
    std::transform(wanted.begin(), wanted.end(), on_faces.begin(), [](std::uint64_t v) { return static_cast<Index>(v); });
    const BucketParts parts(mesh.triangle_count, parallel);
    PerWorker<Seen<Index>> seen(parts.count);
    for_each_block(parts, parallel, [&](std::size_t part, std::size_t begin, std::size_t end) {
        Seen<Index> here;
        here.look(mesh.indices + begin * mesh.index_stride, 3 * (end - begin), on_faces);
        seen[part].add(here);
    });
    Seen<Index> all;
    seen.for_each([&all](const Seen<Index>& of_part) { all.add(of_part); });
    return all.largest < mesh.vertex_count &&
           std::none_of(all.on_face.begin(), all.on_face.end(), [](Index found) { return found == 0; });
}

bool have_all(const MeshView& mesh, const VertexNumbers& wanted, const Parallel& parallel) {
    return mesh.index_type == IndexType::u32 ? have_all<std::uint32_t>(mesh, wanted, parallel)
                                             : have_all<std::uint64_t>(mesh, wanted, parallel);
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

}  // namespace

Result<Bounds> measure_bounds(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel,
                              VertexTable& table, BlockTable& blocks) {
    if (const Status status = check_transform(transform); !status) {
        return status.error();
    }
    const Vertices vertices(mesh, transform, parallel);
    table.used.set_size(0);
    const VertexBox all = vertices.box([](std::size_t) { return true; });
    if (all.can_be_used() && have_all(mesh, vertices.on_faces_of(all), parallel)) {
        return all.bounds();
    }
    if (mark_used(mesh, parallel, table.used)) {
        const VertexBox used = vertices.box([&table](std::size_t vertex) { return table.used[vertex] != 0; });
        if (used.can_be_used()) {
            return used.bounds();
        }
    }
    return measure_bounds(mesh, transform, unit_mm, parallel, blocks);
}

}  // namespace lamella
