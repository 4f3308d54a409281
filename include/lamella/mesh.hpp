// The mesh as the caller holds it: a view, never a copy.
//
//     // A tetrahedron: four vertices of three numbers, and three indices a triangle.
//     const std::vector<float> xyz = {0, 0, 0, 10, 0, 0, 0, 10, 0, 0, 0, 10};
//     const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
//     const lamella::MeshView tetrahedron = lamella::MeshView::indexed(xyz, indices);
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(tetrahedron);
//
// A triangle is three vertices, counter-clockwise as seen from outside the solid, as in STL. Nothing is assumed about the
// order of triangles or about shared vertices. Coordinates are in mm once SliceOptions::transform has been applied to them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace lamella {

/// Integers are read as doubles: what one of them means in mm is the transform's to say, as Transform::scale(1e-6).
enum class CoordinateType : std::uint8_t { f32, f64, i32, i64 };

enum class IndexType : std::uint8_t { u32, u64 };

/// What a transform is computed in. A host that moves meshes of floats by a matrix of floats has flat faces where float
/// arithmetic puts them, and asks for planes there. In double the same faces lie up to half a step of float beside them, so
/// that a face on a plane may be missed; by `as_mesh` it never is.
enum class Arithmetic : std::uint8_t {
    f64,      ///< double, whatever the mesh has; heights are then rounded to the grid alone
    as_mesh,  ///< the mesh's own number type: of floats, the entries of `m` are rounded to float first, and heights too
};

/// A 3x4 affine map, row by row, to mm: x' = m[0] x + m[1] y + m[2] z + m[3]; y' by m[4..7] and z' by m[8..11] likewise.
/// Every product is rounded and sums run from left to right, without contraction. Applied to every vertex while it is
/// rounded to the grid. The identity changes nothing, in either arithmetic.
struct Transform {
    std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    Arithmetic arithmetic = Arithmetic::f64;

    bool is_identity() const noexcept { return m == Transform{}.m; }
    friend bool operator==(const Transform&, const Transform&) = default;

    /// It flattens every mesh: its determinant is 0, but for rounding.
    bool is_singular() const noexcept;

    /// The rotation that turns `normal` (any length but zero) into +z, so that planes are cut perpendicular to `normal`.
    /// (0, 0, 1) gives the identity exactly.
    static Transform from_normal(double x, double y, double z) noexcept;

    /// All three axes times `factor`: from other units to mm.
    static Transform scale(double factor) noexcept;

    /// `first`, then `second`: computed in double, and `as_mesh` if either is.
    friend Transform operator*(const Transform& second, const Transform& first) noexcept;
};

/// Triangles in memory, in one of two shapes:
///  - soup: triangle t has its three vertices, three numbers each, packed at `vertices + t * stride`;
///  - indexed: vertex v is three numbers at `vertices + v * stride`, triangle t is three indices at
///    `indices + t * index_stride`.
/// Numbers need no alignment. The memory belongs to the caller and must outlive the call that it is passed to.
struct MeshView {
    const std::byte* vertices = nullptr;
    std::size_t stride = 0;              ///< bytes from one triangle (soup) or vertex (indexed) to the next
    std::size_t vertex_count = 0;        ///< indexed only; indices are checked against it
    const std::byte* indices = nullptr;  ///< null for soup
    std::size_t index_stride = 0;        ///< bytes from one triangle's indices to the next's
    IndexType index_type = IndexType::u32;
    std::size_t triangle_count = 0;
    CoordinateType coordinate_type = CoordinateType::f32;

    /// Nine numbers a triangle. Precondition: a multiple of nine (asserted; the rest is left out).
    static MeshView soup(std::span<const float> coordinates) noexcept;
    static MeshView soup(std::span<const double> coordinates) noexcept;
    /// `stride` in bytes between triangles: 50 with `first` at offset 84 + 12 views a binary STL file where it lies.
    static MeshView strided_soup(const std::byte* first, std::size_t triangles, std::size_t stride,
                                 CoordinateType coordinate_type) noexcept;
    /// Three numbers a vertex, three indices a triangle. Precondition: multiples of three (asserted; the rest is left out).
    static MeshView indexed(std::span<const float> xyz, std::span<const std::uint32_t> indices) noexcept;
    static MeshView indexed(std::span<const double> xyz, std::span<const std::uint32_t> indices) noexcept;
    static MeshView indexed(const std::byte* first, std::size_t vertices, std::size_t stride, CoordinateType coordinate_type,
                            std::span<const std::uint32_t> indices) noexcept;
    /// Of any index type and stride: for hosts that keep indices within a struct.
    static MeshView indexed(const std::byte* first, std::size_t vertices, std::size_t stride, CoordinateType coordinate_type,
                            const std::byte* first_index, std::size_t triangles, std::size_t index_stride,
                            IndexType index_type) noexcept;

    /// The vertex at a corner, 0 to 2. Precondition: indexed.
    std::uint64_t vertex_of(std::size_t triangle, std::size_t corner) const noexcept {
        const std::byte* const at = indices + triangle * index_stride;
        if (index_type == IndexType::u32) {
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
