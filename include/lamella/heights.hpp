// Layers as high as the surface allows: thick where walls stand upright, thin where they lean.
//
//     const auto slabs = lamella::adaptive_layers(mesh, {.least_mm = 0.08, .most_mm = 0.28, .cusp_mm = 0.04});
//     if (slabs) {
//         const auto sliced = lamella::slice(mesh, {.slabs = {slabs->begin(), slabs->end()}});
//         if (sliced) {
//             std::printf("%zu layers, the first %g mm high\n", sliced->size(), (*slabs)[0].top_mm);
//         }
//     }
//
// Each facet limits the height of the slabs that it reaches into. By its angle `a` from the horizontal, a slab is at most so
// high, by each measure that is not 0:
//
//     cusp_mm         c / cos a                                          the step's corner stands c off the surface
//     deviation_mm    the less of d / 0.184 and 1.44 d sqrt(tan a)       surface deviation, as slicers count it
//     slope_limit_mm  s tan a                                            a step is s wide
//
//        |      .-'|        A slab of height h, and a facet at an angle a: the step is h / tan a wide, and its corner stands
//      h |   .-'   |        h cos a off the facet.
//        |.-'a_____|
//
// Upright facets limit nothing. Exactly flat ones do not either: their slope would ask for the least height whatever the
// layers, and a flat face lies at most half a slab off its true height.
//
// Heights and slabs are whole multiples of step_mm, counted from the mesh's lowest vertex. From there up, each slab is as
// high as every facet in its reach allows. What lies within a hundredth of a step counts as equal, since coordinates are
// rounded.
//
// n triangles, k steps from the mesh's lowest vertex to its highest: O(n + k log k), one read of the mesh after that of its
// box; memory 4 k log k bytes. The answer depends neither on threads nor on the order of triangles, and on no platform.
#pragma once

#include <span>

#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/options.hpp"
#include "lamella/source.hpp"

namespace lamella {

/// Slabs that begin in a range have its height, whatever the surface: a first layer, or what the user has set by hand.
struct HeightRange {
    double from_mm = 0;  ///< above the mesh's lowest vertex, as to_mm
    double to_mm = 0;
    double height_mm = 0;  ///< may be less than AdaptiveOptions::least_mm or more than most_mm
};

/// Lengths in mm; they are rounded down to multiples of step_mm.
struct AdaptiveOptions {
    double least_mm = 0.05;  ///< no slab is lower, but those of ranges; at least a step
    double most_mm = 0.3;    ///< no slab is higher, but those of ranges
    double step_mm = 0.005;
    double cusp_mm = 0;         ///< how far the corners of steps stand off the surface at most; 0: any
    double deviation_mm = 0;    ///< the surface deviation at most; 0: any
    double slope_limit_mm = 0;  ///< how wide steps are at most; 0: any
    /// By how much a slab's height differs from that of the one below at most; 0: any. Where a range is thicker than what
    /// lies around it, it keeps its height.
    double most_change_mm = 0;
    /// The height that facets allow is at most its mean over so much below and above; 0: it is taken as it is.
    double smoothing_mm = 0;
    std::span<const HeightRange> ranges{};  ///< ascending, and none reaches into the next
    Frame frame{};  ///< slabs are horizontal after its transform, as in a slice; its grid is not used
};

/// Slabs side by side, from the mesh's lowest vertex up to the last whose middle lies below its highest: at least one. Give
/// them to a slice as SliceOptions::slabs. Of several parts, the slabs suit all of them.
///
/// Errors: invalid_argument (an option out of its bounds, named; a file in pieces), empty_mesh, bad_coordinate (with the
/// triangle), result_too_large (so many steps that the context's limit does not hold the work), out_of_memory, cancelled.
Result<Array<Slab>> adaptive_layers(const Source& mesh, const AdaptiveOptions& options = {},
                                    const Context& context = {}) noexcept;

}  // namespace lamella
