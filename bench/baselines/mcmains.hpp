// The coherent sweep plane slicer: S. McMains and C. Séquin, "A coherent sweep plane slicer for layered manufacturing",
// 1999; the paper's section 2.1. It slices meshes with topology. Here the topology is first recovered from the soup by
// a binary tree of the vertices, as in E. Béchet, J.-C. Cuillière and F. Trochu (2002).
//
// A plane sweeps the mesh upwards and keeps its contours as rings of edges. Rings change only at vertices: edges that
// end there are replaced by those that begin there. At a vertex with one run of edges below and one above, the ring
// continues. The lowest vertex of a part begins a ring, and the highest ends it. At any other vertex rings merge or
// split, so the rings through it are walked to find which they are. At a slicing plane each ring is a contour; only its
// points have to be computed.
//
// O(n log n + m). As the paper says, up to O(n^2) where rings merge and split often, because each such vertex costs the
// length of its rings.
//
// Kept from the source: only closed meshes are sliced; others give no contours. Vertices of equal height are swept in
// the order of their numbers, as if the mesh were tilted slightly. Level edges and facets therefore need no special
// cases. Planes never meet a vertex. Left out: the nesting of the rings, which no measurement here needs.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

extern const WholeMethod mcmains;

}  // namespace lamella::baselines
