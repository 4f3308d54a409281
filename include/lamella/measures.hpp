// Measures of sections: areas, lengths, centroids, second moments, boxes and diameters, of each layer and of each island.
//
//     const auto measured = lamella::measure(result, {.islands = true, .feret = true});
//     if (measured) {
//         for (const lamella::SectionMeasures& layer : measured->layers) {
//             std::printf("%g mm: %g mm2, Imax %g mm4\n", layer.z_mm, layer.area_mm2, layer.imax_mm4);
//         }
//         for (const lamella::SectionMeasures& island : measured->islands) {
//             std::printf("island in layer %llu: %g mm wide\n", (unsigned long long)island.layer, island.feret_min_mm);
//         }
//     }
//
// An island is an outer contour with its own holes; an island in a hole counts for itself. `area` is solid, `outer_area` has
// its holes filled: of bone the cortical area is area, the total area outer_area, the medullary area their difference.
//
//        .-----------------.         islands 2, holes 1: area = A - B + C, outer_area = A + C
//        | A  .----------. |
//        |    | B  [ C ] | |
//        |    '----------' |
//        '-----------------'
//
// Not known is NaN, empty is 0: all numbers of a layer with open contours, and of its islands, are NaN; of a layer without
// contours the sums are 0, and places, angles and shapes NaN.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/result.hpp"

namespace lamella {

struct MeasureOptions {
    bool islands = false;  ///< Measures::islands are filled
    bool feret = false;    ///< smallest and largest diameters, which take longer
};

/// One layer or island, in the frame of the section. Moments and angle are about the centroid: x to the right, y up.
struct SectionMeasures {
    static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

    std::uint64_t layer = 0;    ///< index into SliceResult::layers
    std::int64_t contour = -1;  ///< of an island the index of its outer into SliceResult::contours
    double z_mm = 0;            ///< of the plane
    std::int32_t islands = 0;
    std::int32_t holes = 0;
    std::int32_t open = 0;  ///< contours that do not close
    bool known = true;      ///< none is open
    std::array<std::uint8_t, 3> reserved{};
    double area_mm2 = 0;
    double outer_area_mm2 = 0;
    double perimeter_mm = 0;        ///< of all closed contours
    double outer_perimeter_mm = 0;  ///< of outer contours
    std::array<double, 2> centroid_mm{unknown, unknown};
    double ix_mm4 = 0;           ///< of y squared
    double iy_mm4 = 0;           ///< of x squared
    double ixy_mm4 = 0;          ///< of x times y
    double imin_mm4 = 0;         ///< about the long axis
    double imax_mm4 = 0;         ///< about the short axis
    double angle_rad = unknown;  ///< of the long axis from x, in (-pi/2, pi/2]; NaN where all axes are alike
    double polar_mm4 = 0;        ///< ix + iy
    std::array<double, 2> box_min_mm{unknown, unknown};
    std::array<double, 2> box_max_mm{unknown, unknown};
    double feret_max_mm = unknown;      ///< largest distance of two points; NaN without MeasureOptions::feret
    double feret_min_mm = unknown;      ///< smallest distance of two parallel lines around it
    double feret_angle_rad = unknown;   ///< of the largest, in (-pi/2, pi/2]; of several the smallest
    double equivalent_diameter_mm = 0;  ///< of a disc of that area
    double circularity = unknown;       ///< 4 pi outer_area / outer_perimeter^2: 1 of a disc, 1/n of n equal ones
};

struct Measures {
    explicit Measures(const Memory* memory = nullptr) noexcept : layers(memory), islands(memory) {}

    Array<SectionMeasures> layers;   ///< of each, or of the one
    Array<SectionMeasures> islands;  ///< by layer and contour
};

/// Contours count as they run: what lies in several outers counts several times, unless a fill rule has made regions. Where
/// the signed area is not above 0, or its centroid lies outside of the box, place, moments and angle are NaN.
///
/// Sums are exact integers until the last step (the edges' polynomials of Green's theorem in 128 bits about the layer's
/// middle, moved to the centroid without loss), so that nothing cancels, and equal on every platform and number of threads.
/// Layers in parallel: O(points), with `feret` O(h log h) for h points near the hull; memory 248 bytes a row. Errors:
/// invalid_argument (a point beyond grid_limit, contours that wind so often around so much that sums leave 128 bits,
/// negative threads), result_too_large, out_of_memory, cancelled.
Result<Measures> measure(const SliceResult& result, const MeasureOptions& options = {},
                         const Context& context = {}) noexcept;

/// The same of one layer, as a sink has it.
Result<Measures> measure(const LayerView& layer, const MeasureOptions& options = {}) noexcept;

}  // namespace lamella
