// What of a binary PLY file needs no look at each number: rows of one size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "1_input/ply_body.hpp"

namespace lamella {

/// Where the vertices begin in the file, if their coordinates can be used where they lie.
std::optional<std::size_t> vertices_in_place(const PlyHeader& header, const PlyElement& vertices, std::size_t offset);

/// Copies the coordinates of vertices without lists, which begin at `rows`, into those of `mesh`.
void copy_vertices(const PlyInput& input, const PlyElement& vertices, const char* rows, const PlyMesh& mesh);

/// Rows that all have the same size, because their only list has three whole numbers.
struct TriangleRows {
    const char* begin = nullptr;
    std::size_t stride = 0;
    std::size_t list = 0;  ///< where it lies in a row
};

/// Whether faces that begin at `begin` are such rows.
std::optional<TriangleRows> as_triangle_rows(const PlyInput& input, const PlyElement& faces, const char* begin);

/// Copies their indices to `indices`. False: some are not below `vertex_count`.
bool copy_triangles(const PlyInput& input, const PlyElement& faces, const TriangleRows& rows, std::uint64_t vertex_count,
                    std::uint32_t* indices);

}  // namespace lamella
