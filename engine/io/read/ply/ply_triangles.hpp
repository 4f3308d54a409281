// Triangles of the faces and strips of a PLY file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io/read/polygon.hpp"

namespace lamella {

/// Fills a given room with three indices a triangle.
class PlyTriangles {
public:
    PlyTriangles(const VertexCoordinates& vertices, std::span<std::uint32_t> room) : vertices_(vertices), room_(room) {}

    /// Of a polygon, whose indices are those of vertices. One of fewer than three corners is counted and left out. False:
    /// why() holds the error.
    bool add_face(std::span<const std::uint32_t> corners);

    /// Of strips that strip_end separates: a b c d e makes a b c, c b d and c d e. Triangles of two equal
    /// indices, which join strips, are left out.
    bool add_strips(std::span<const std::uint32_t> corners);

    /// Counts indices that the caller wrote into the room itself.
    void use(std::size_t indices) noexcept { used_ += indices; }

    std::size_t index_count() const noexcept { return used_; }
    std::uint64_t small_faces() const noexcept { return small_faces_; }
    const std::string& why() const noexcept { return why_; }

private:
    bool fits(std::size_t triangles);
    bool all_finite(std::span<const std::uint32_t> corners);

    VertexCoordinates vertices_;
    std::span<std::uint32_t> room_;
    std::size_t used_ = 0;
    std::uint64_t small_faces_ = 0;
    PolygonTriangulator polygon_;
    std::string why_;
};

}  // namespace lamella
