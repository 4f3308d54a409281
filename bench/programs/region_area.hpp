// The area of a region of one layer.
#pragma once

#include "base/numbers.hpp"
#include "lamella/assemble.hpp"

namespace lamella::bench {

/// Outers minus holes, square grid units. O(contours).
inline double area_of(const LayerContours& region) {
    Int128 twice = 0;
    for (const Contour& contour : region.contours) {
        twice += to_int128(contour.twice_area);
    }
    return static_cast<double>(twice) / 2;
}

}  // namespace lamella::bench
