// The coherent sweep plane slicer. S. McMains and C. Séquin, "A coherent sweep plane slicer for layered manufacturing",
// 1999; the paper's section 2.1. It slices structured meshes: the topology is recovered from the soup first, by a binary
// tree of the vertices, as E. Béchet, J.-C. Cuillière and F. Trochu (2002) do.
//
// A plane sweeps the mesh upwards and holds the contours in which it meets it, as rings of edges. Rings change at vertices
// alone: edges that end there leave, those that begin there take their places. A vertex with edges both below and above, in
// one run each, leaves the ring whole; a lowest one begins a ring and a highest one ends it; at any other, rings meet or
// part, and those that now go through the vertex are walked to learn which they are. At a slicing plane each ring is a
// contour, and only its points have to be computed.
//
// O(n log n + m), and as the paper says up to O(n^2) where rings meet and part often: each such vertex costs the length of
// its rings.
//
// Kept: closed meshes only; of any other no contours are given. Vertices of one height are swept in the order of their
// numbers, as if the mesh were tilted by a hair, so that level edges and facets need no cases of their own; planes never
// meet a vertex. Left out: how the rings nest, which nothing here asks for.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

extern const WholeMethod mcmains;

}  // namespace lamella::baselines
