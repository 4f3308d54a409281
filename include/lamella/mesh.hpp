// The mesh as the caller holds it: a view, never a copy.
//
//     // A tetrahedron: four vertices of three numbers, and three indices a triangle.
//     const std::vector<float> xyz = {0, 0, 0, 10, 0, 0, 0, 10, 0, 0, 0, 10};
//     const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
//     const lamella::MeshView tetrahedron = lamella::MeshView::indexed(xyz, indices);
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(tetrahedron);
//
//     // Vertices and corners that lie within a host's own structs.
//     struct Vertex { float x, y, z, colour; };
//     struct Face { std::uint32_t corners[3], material; };
//     const lamella::MeshView hosted{.vertices = host_vertices.data(), .vertex_count = host_vertices.size(),
//                                    .triangle_count = host_faces.size(), .indices = host_faces.data(),
//                                    .vertex_stride = sizeof(Vertex), .index_stride = sizeof(Face)};
//
// A triangle is three vertices, counter-clockwise as seen from outside the solid, as in STL. Nothing is assumed about the
// order of triangles or about shared vertices. A mesh knows its unit, which every call applies.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace lamella {

/// What numbers are stored as: coordinates as f32, f64, i32 or i64, of which integers are read as doubles; a host's points
/// as one of these; indices as u32 or u64.
enum class Number : std::uint8_t { f32, f64, i32, i64, u32, u64 };

constexpr std::size_t size_of(Number number) noexcept {
    return number == Number::f32 || number == Number::i32 || number == Number::u32 ? 4 : 8;
}

/// A 3x4 affine map, row by row, to mm: x' = m[0] x + m[1] y + m[2] z + m[3]; y' by m[4..7] and z' by m[8..11] likewise.
/// Every product is rounded and sums run from left to right, without contraction. Applied to every vertex while it is
/// rounded to the grid, in double, or by Frame::as_mesh_numbers in the mesh's own numbers. The identity changes nothing.
struct Transform {
    std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

    bool is_identity() const noexcept { return *this == Transform{}; }
    /// It flattens every mesh: its determinant is 0, but for rounding.
    bool is_singular() const noexcept;
    friend bool operator==(const Transform&, const Transform&) = default;

    /// The rotation that turns `normal` (any length but zero) into +z, so that planes are cut perpendicular to `normal`.
    /// (0, 0, 1) gives the identity exactly.
    static Transform from_normal(double x, double y, double z) noexcept;
    /// All three axes times `factor`.
    static Transform scale(double factor) noexcept;
    /// `first`, then `second`: computed in double.
    friend Transform operator*(const Transform& second, const Transform& first) noexcept;
};

/// An axis-aligned box, in mm.
struct Box {
    std::array<double, 3> min_mm{};
    std::array<double, 3> max_mm{};
    friend bool operator==(const Box&, const Box&) = default;
};

/// Triangles in memory, in one of two shapes:
///  - soup: triangle t has its three vertices, three numbers each, packed at `vertices + t * vertex_stride`;
///  - indexed: vertex v is three numbers at `vertices + v * vertex_stride`, triangle t is three indices at
///    `indices + t * index_stride`.
/// Numbers need no alignment. The memory belongs to the caller and must outlive the call that it is passed to.
struct MeshView {
    const void* vertices = nullptr;
    std::size_t vertex_count = 0;  ///< indexed only; indices are checked against it
    std::size_t triangle_count = 0;
    const void* indices = nullptr;  ///< null: a soup
    std::size_t vertex_stride = 0;  ///< bytes from one triangle (soup) or vertex (indexed) to the next; 0: packed
    std::size_t index_stride = 0;   ///< bytes from one triangle's indices to the next's; 0: packed
    Number vertex_type = Number::f32;
    Number index_type = Number::u32;
    double mm_per_unit = 1;  ///< of the coordinates, finite and more than 0

    /// Nine numbers a triangle. Precondition: a multiple of nine (asserted; the rest is left out).
    static MeshView soup(std::span<const float> xyz) noexcept;
    static MeshView soup(std::span<const double> xyz) noexcept;
    /// Three numbers a vertex, three indices a triangle. Precondition: multiples of three (asserted; the rest is left out).
    static MeshView indexed(std::span<const float> xyz, std::span<const std::uint32_t> indices) noexcept;
    static MeshView indexed(std::span<const double> xyz, std::span<const std::uint32_t> indices) noexcept;

    /// Bytes from one triangle (soup) or vertex (indexed), and from one triangle's indices, to the next: packed ones too.
    std::size_t vertex_step() const noexcept {
        return vertex_stride != 0 ? vertex_stride : (indices == nullptr ? 9 : 3) * size_of(vertex_type);
    }
    std::size_t index_step() const noexcept { return index_stride != 0 ? index_stride : 3 * size_of(index_type); }
    /// Where triangle (soup) or vertex (indexed) `i` lies, and the indices of a triangle.
    const std::byte* vertex_at(std::size_t i) const noexcept {
        return static_cast<const std::byte*>(vertices) + i * vertex_step();
    }
    const std::byte* indices_at(std::size_t triangle) const noexcept {
        return static_cast<const std::byte*>(indices) + triangle * index_step();
    }

    /// The vertex at a corner, 0 to 2. Precondition: indexed.
    std::uint64_t vertex_of(std::size_t triangle, std::size_t corner) const noexcept {
        const std::byte* const at = indices_at(triangle);
        if (index_type == Number::u32) {
            std::uint32_t index;
            std::memcpy(&index, at + corner * sizeof index, sizeof index);
            return index;
        }
        std::uint64_t index;
        std::memcpy(&index, at + corner * sizeof index, sizeof index);
        return index;
    }
};

}  // namespace lamella
