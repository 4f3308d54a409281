// How two triangles of the grid meet, exactly.
#pragma once

#include <array>
#include <cstdint>

#include "slicing/grid/exact.hpp"

namespace lamella {

enum class Meeting : std::uint8_t {
    none,     ///< not at all, or in what they share: a vertex, an edge, or all three vertices
    touch,    ///< elsewhere too, but no inside meets the other's
    cross,    ///< their insides meet, in two planes
    overlap,  ///< their insides meet, in one plane
};

/// A triangle with area. Corners with equal ids are one vertex, and corners at one place have equal ids.
struct ExactFace {
    std::array<std::uint32_t, 3> ids;
    std::array<GridVector, 3> corners;
    GridVector normal;

    ExactFace(const std::array<std::uint32_t, 3>& vertex_ids, const std::array<GridVertex, 3>& vertices) noexcept
        : ids(vertex_ids),
          corners{half(vertices[0]), half(vertices[1]), half(vertices[2])},
          normal(cross(corners[1] - corners[0], corners[2] - corners[0])) {}

    bool has_area() const noexcept { return !(normal == GridVector{}); }
    /// Times the normal's length: how far p lies in front of the plane.
    Int128 height(const GridVector& p) const noexcept { return dot(normal, p - corners[0]); }
};

/// True if p lies in the triangle, its sides included. Precondition: it has area.
bool contains(const ExactFace& face, const GridVector& p) noexcept;

/// Precondition: both have area.
Meeting meet(const ExactFace& a, const ExactFace& b) noexcept;

/// The ends of the segment in which two triangles that cross meet, in halves of grid units, approximately.
std::array<std::array<double, 3>, 2> crossing_segment(const ExactFace& a, const ExactFace& b) noexcept;

}  // namespace lamella
