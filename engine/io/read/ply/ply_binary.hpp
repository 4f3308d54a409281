// Binary PLY rows of one size, which are copied without parsing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "io/read/ply/ply_body.hpp"

namespace lamella {

/// Where the vertices begin in the file, if their coordinates can be used where they lie, swapped or not.
std::optional<std::size_t> vertices_in_place(const PlyElement& vertices, std::size_t offset);

/// Reverses the bytes of all coordinates in place.
void swap_vertices(MeshFile& mesh, const Parallel& parallel);

/// Copies the coordinates of vertices without lists, which begin at `rows`, into those of `mesh`.
void copy_vertices(const PlyInput& input, const PlyElement& vertices, const char* rows, MeshFile& mesh);

/// The same for `count` rows, to packed coordinates at `to`.
void copy_vertex_rows(const PlyElement& vertices, bool swapped, const char* rows, std::size_t count, CoordinateType number,
                      std::byte* to);

/// Bytes of a row that is a triangle; nothing if such rows may differ in size, or indices are no whole numbers.
std::optional<std::size_t> triangle_row_bytes(const PlyElement& faces);

/// Copies the indices of `count` such rows. False: a row has not three, or one that is not below `vertex_count`, which is
/// at most most_ply_vertices.
bool copy_triangle_rows(const PlyElement& faces, bool swapped, const char* rows, std::size_t count,
                        std::uint64_t vertex_count, std::uint32_t* to);

/// Beyond, what is negative could be a vertex.
inline constexpr std::uint64_t most_ply_vertices = std::uint64_t{1} << 31;

/// Where the row's property of this use begins, if all lists before it are empty.
std::size_t offset_in_row(const PlyElement& element, PlyUse use);

/// Copies the indices of the faces at `rows` to `indices`, if every one is a triangle: rows of one size, whose only list has
/// three whole numbers. False: there are other rows, an index that is no vertex, or memory does not suffice.
bool copy_triangle_rows(const PlyInput& input, const PlyElement& faces, const char* rows, Array<std::uint32_t>& indices);

}  // namespace lamella
