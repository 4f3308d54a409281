// What a PreparedMesh holds.
#pragma once

#include "lamella/mesh.hpp"
#include "slicing/buckets/prepared_triangles.hpp"
#include "slicing/planes/shared_frame.hpp"

namespace lamella::detail {

struct PreparedParts {
    explicit PreparedParts(const Memory* memory) : triangles(memory) {}

    PreparedTriangles triangles;
    SharedFrame frame{};
    Transform transform{};
    double asked_unit_mm = 0;
    MeshView counted{};  ///< of the input its number of triangles only
};

}  // namespace lamella::detail
