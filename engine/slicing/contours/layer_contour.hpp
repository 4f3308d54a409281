// A contour of a layer from the walk until it is appended to the band's output.
#pragma once

#include "lamella/assemble.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

struct LayerContour {
    NestItem item;             ///< points, area and box; then what nesting decides
    EndKey start_key;          ///< the edge that the start lies on; zero where the contour was joined or made
    std::uint32_t segments{};  ///< triangles that it crosses; of a contour that was made its edges
    bool made = false;         ///< by a fill rule, of one contour or several
};

}  // namespace lamella
