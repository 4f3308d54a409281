// What a PreparedMesh holds.
#pragma once

#include "lamella/mesh.hpp"
#include "slicing/buckets/prepared_triangles.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/planes/shared_frame.hpp"

namespace lamella::detail {

struct PreparedParts {
    explicit PreparedParts(const Memory* memory) : triangles(memory) {}

    SliceInput input() const noexcept { return {counted, &frame, this}; }

    PreparedTriangles triangles;
    Bounds bounds{};
    SharedFrame frame{};  ///< its bounds choose the planes: none where nothing is left on the grid
    Transform transform{};
    double asked_unit_mm = 0;
    MeshView counted{};  ///< of the input its number of triangles only
};

}  // namespace lamella::detail
