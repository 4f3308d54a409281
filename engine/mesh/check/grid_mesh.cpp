#include "mesh/check/grid_mesh.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <tuple>
#include <utility>

#include "base/parallel_sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t faces_a_part = std::size_t{1} << 13;

struct FaceLess {
    bool operator()(const Face& a, const Face& b) const noexcept {
        return std::make_tuple(vertex_set(a), a.corners, a.source) < std::make_tuple(vertex_set(b), b.corners, b.source);
    }
};

Face face_of(const Array<std::uint32_t>& numbers, std::size_t triangle) {
    Face face{{numbers[3 * triangle], numbers[3 * triangle + 1], numbers[3 * triangle + 2]},
              static_cast<std::uint32_t>(triangle)};
    std::rotate(face.corners.begin(), std::min_element(face.corners.begin(), face.corners.end()), face.corners.end());
    return face;
}

bool is_collapsed(const Face& face) {
    const auto [a, b, c] = face.corners;
    return a == b || b == c || c == a;
}

/// Faces in parts by their smallest corner, and in one more those that have collapsed.
Distributed<Face> distribute_faces(const Array<std::uint32_t>& numbers, std::size_t vertices, const Parallel& parallel,
                                   const Memory* memory) {
    const std::size_t triangles = numbers.size() / 3;
    const std::size_t parts = parts_for(triangles, faces_a_part);
    return distribute<Face>(
        triangles, parts + 1, parallel,
        [&](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t t = begin; t != end; ++t) {
                Face face = face_of(numbers, t);
                if (is_collapsed(face)) {
                    std::sort(face.corners.begin(), face.corners.end());  // without orientation; two corners may be smallest
                    emit(parts, face);
                } else {
                    emit(part_of_number(face.corners[0], vertices, parts), face);
                }
            }
        },
        memory);
}

}  // namespace

GridMesh make_grid_mesh(const MeshView& mesh, const Transform& transform, const MeshInfo& info, const Parallel& parallel,
                        const Memory* memory) {
    assert(mesh.triangle_count < std::numeric_limits<std::uint32_t>::max() / 3);
    GridMesh grid(memory);
    grid.unit_mm = info.unit_mm;
    const Array<std::uint32_t> numbers = number_vertices(mesh, transform, info, parallel, grid);
    Distributed<Face> parts = distribute_faces(numbers, grid.vertices.size(), parallel, memory);
    const std::size_t whole = parts.size() - 1;
    std::vector<PartSort<Face>> workers(static_cast<std::size_t>(parallel.threads()));
    parallel.run(whole, [&](std::size_t part, int worker) {
        workers[static_cast<std::size_t>(worker)].run(
            parts.of(part), [](const Face& face) { return face.corners[0]; }, FaceLess{});
    });
    const std::span<Face> collapsed = parts.of(whole);
    sort_in_parallel(collapsed, FaceLess{}, parallel);
    grid.collapsed.assign(collapsed.begin(), collapsed.end());
    grid.faces = std::move(parts.items);
    grid.faces.set_size(parts.firsts[whole]);
    return grid;
}

}  // namespace lamella
