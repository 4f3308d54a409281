// Slicing several meshes at the same planes, as the parts of one print.
//
//     // A mesh, and with it the same at twice its size, each with its own contours.
//     const std::vector<lamella::Part> parts = {{.mesh = mesh}, {.mesh = mesh, .transform = lamella::Transform::scale(2)}};
//     const lamella::Result<lamella::SliceResult> both = lamella::slice_parts(parts);
//     if (both) {
//         for (const lamella::Contour& contour : both->contours_of(both->layers[0])) {
//             std::printf("part %u: %u points\n", contour.part, contour.point_count);
//         }
//     }
#pragma once

#include <span>

#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"

namespace lamella {

struct Part {
    MeshView mesh;
    Transform
        transform{};  ///< from the part's coordinates to those that all parts share; SliceOptions::transform comes next
};

/// Slices every part at the planes of one plan, on one grid: both are chosen for the box around all parts. Heights are
/// rounded as floats where every part is of floats that no transform moves in double, as doubles elsewhere. Facets of one
/// part never continue those of another.
///
/// PartRegions::separate: SliceOptions::region is done to each part by itself. Parts may overlap, and find_crossings() says
/// where. PartRegions::united: it is done to the contours of all parts together, by the orientation of their facets; no
/// layer's rule may be `contours`. A contour then names the part that all its edges come from, or several_parts.
///
/// Where parts are separate, a layer has the contours of part 0, then of part 1, and so on, those of each as slice() gives
/// them; Contour::part is the part's index into `parts`. Where they are united, contours are in the order of slice(). For
/// one separate part the result is that of slice(). `summary` holds sums, and the box of all. make_ledger() and
/// certify_volume() compare with one mesh and do not apply.
///
/// Costs what slicing each part costs, with a look at each box before. Parts are sliced one after another by all threads,
/// and held until they are put together, so that the result takes its memory twice. SliceOptions::memory_limit_bytes is for
/// all parts. Errors: those of slice(), which begin with "part N: " where a part is to blame; invalid_argument (no part, or
/// with SliceOptions::origins more than 65,535).
Result<SliceResult> slice_parts(std::span<const Part> parts, const SliceOptions& options = {},
                                PartRegions regions = PartRegions::separate) noexcept;

}  // namespace lamella
