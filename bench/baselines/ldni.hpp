// Layered depth-normal images. L. Zeng, L. M. Lai, D. Qi, Y.-H. Lai and M. M.-F. Yuen 2011 and D. Qi, L. Zeng and M. M.-F.
// Yuen 2013, as the paper describes them (2.2): each layer is sampled by parallel rays, here along x, which gives a list of
// points with the sense in which each ray passes the surface; points of neighbouring rays are then connected.
//
// Two rays next to each other bound a strip. Stretches of the rays that lie within the solid belong together where they
// overlap; what belongs together is one piece of the solid within the strip, and its border connects the points:
//
//     ray j + 1   ----o=========o----o====o--------o===o-----        = solid
//                    /           `--'      \        `-'              stretches alone are closed at once
//     ray j       --o=======================o----------------
//
// O(n log k + m + s log s) for s samples. Its answer holds to about the resolution: an area is off by at most the length of
// the contours times the distance of two rays, and what lies between two rays is lost, as are the mesh's own corners.
//
// Kept: closed meshes only; a stretch that does not end is dropped. Left out: the images themselves, which the authors have
// made by graphics hardware, and resolutions that vary with the shape.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

inline constexpr double ldni_resolution_mm = 0.1;  ///< from ray to ray

/// Its number of segments is that of its samples.
extern const WholeMethod ldni;

}  // namespace lamella::baselines
