// TSlicer traces contours through the half-edge structure of the mesh. R. D. da Silva, H. R. Ramalho, R. Minetto, N.
// Volpato and J. Stolfi, "TSlicer: An optimal topology-based slicing algorithm for Z-monotone 3D meshes", 2024: the
// successor of the paper's own algorithm, by its authors.
//
// Edges are put into lists by the first plane that cuts them (the paper's Algorithm 2, with edges instead of
// triangles). Planes are visited from the lowest up, with the set of edges that they cut. A contour is traced from any
// edge that this plane has not visited yet, from half-edge to half-edge: the next crossing is on the same face, and
// then on its twin. Each edge remembers the next half-edge of the last plane (the short cut). While the plane still
// cuts that one, the face need not be examined, however many edges it has.
//
// O(n + k + m) for uniform planes, O(n log k + k + m) for others, plus the topology: O(n) here, by hashing.
//
// Kept from the source: only closed meshes are sliced; others give no contours. Faces are triangles here, as the soup's
// are. Written from the published abstract and descriptions of the algorithm, not from its source code.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

extern const WholeMethod topological;

}  // namespace lamella::baselines
