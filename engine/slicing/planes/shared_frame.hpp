// The grid and the planes of meshes that are sliced as parts of one result.
#pragma once

#include "lamella/mesh.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

struct SharedFrame {
    Bounds bounds;  ///< of all parts
    ChosenUnit unit;
    CoordinateType number;  ///< heights are rounded to it; see PlaneSet::build()
};

}  // namespace lamella
