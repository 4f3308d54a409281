#include "mesh/check/grid_mesh.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <tuple>

#include "base/parallel_sort.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

constexpr std::size_t triangle_grain = 8192;

struct Corner {
    GridVertex vertex;
    std::uint32_t number;  ///< 3 * triangle + corner
};

bool face_less(const Face& a, const Face& b) {
    return std::make_tuple(vertex_set(a), a.corners, a.source) < std::make_tuple(vertex_set(b), b.corners, b.source);
}

Array<Corner> sorted_corners(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel) {
    Array<Corner> corners;
    corners.resize_discarding(3 * mesh.triangle_count);
    with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        parallel.run_ranges(mesh.triangle_count, triangle_grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t t = begin; t != end; ++t) {
                const GridTriangle triangle = read(t);
                for (std::size_t i = 0; i < 3; ++i) {
                    corners[3 * t + i] = {triangle[i], static_cast<std::uint32_t>(3 * t + i)};
                }
            }
        });
    });
    sort_in_parallel(
        corners.span(), [](const Corner& a, const Corner& b) { return a.vertex < b.vertex; }, parallel);
    return corners;
}

/// Numbers the distinct vertices; the number of each corner of the input.
Array<std::uint32_t> number_vertices(const Array<Corner>& corners, Array<GridVertex>& vertices) {
    Array<std::uint32_t> numbers;
    numbers.resize_discarding(corners.size());
    vertices.resize_discarding(corners.size());
    std::uint32_t count = 0;
    for (const Corner& corner : corners) {
        if (count == 0 || vertices[count - 1] != corner.vertex) {
            vertices[count++] = corner.vertex;
        }
        numbers[corner.number] = count - 1;
    }
    vertices.set_size(count);
    return numbers;
}

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

}  // namespace

GridMesh make_grid_mesh(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel) {
    assert(mesh.triangle_count < std::numeric_limits<std::uint32_t>::max() / 3);
    GridMesh grid;
    grid.unit_mm = unit_mm;
    const Array<std::uint32_t> numbers = number_vertices(sorted_corners(mesh, transform, unit_mm, parallel), grid.vertices);
    grid.faces.resize_discarding(mesh.triangle_count);
    std::size_t count = 0;
    for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
        Face face = face_of(numbers, t);
        if (is_collapsed(face)) {
            std::sort(face.corners.begin(), face.corners.end());  // it has no orientation, and may have two smallest corners
            grid.collapsed.push_back(face);
        } else {
            grid.faces[count++] = face;
        }
    }
    grid.faces.set_size(count);
    sort_in_parallel(grid.faces.span(), face_less, parallel);
    std::sort(grid.collapsed.begin(), grid.collapsed.end(), face_less);
    return grid;
}

}  // namespace lamella
