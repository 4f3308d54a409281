// Layered depth-normal images: L. Zeng, L. M. Lai, D. Qi, Y.-H. Lai and M. M.-F. Yuen 2011, and D. Qi, L. Zeng and M.
// M.-F. Yuen 2013, as the paper describes them (2.2). Parallel rays sample each layer, here along x. Each ray gives a
// list of points and, for each point, whether the ray enters or leaves the solid. Points of neighbouring rays are then
// connected.
//
// Two neighbouring rays bound a strip. Their intervals within the solid belong together where they overlap. Overlapping
// intervals form one piece of the solid within the strip, and the border of the piece connects the points:
//
//     ray j + 1   ----o=========o----o====o--------o===o-----        = solid
//                    /           `--'      \        `-'              an interval alone is closed at once
//     ray j       --o=======================o----------------
//
// O(n log k + m + s log s) for s samples. The answer is accurate to about the resolution: the error of an area is at
// most the contours' length times the distance of two rays. Details between two rays are lost, and so are the mesh's
// own corners.
//
// Kept from the source: only closed meshes are sliced; an interval without an end is dropped. Left out: the images
// themselves, which the authors render on graphics hardware, and resolutions that vary with the shape.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

inline constexpr double ldni_resolution_mm = 0.1;  ///< distance of neighbouring rays

/// Reports the number of samples as the number of segments.
extern const WholeMethod ldni;

}  // namespace lamella::baselines
