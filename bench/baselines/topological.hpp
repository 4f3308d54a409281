// TSlicer: tracing through the half-edge structure of the mesh. R. D. da Silva, H. R. Ramalho, R. Minetto, N. Volpato and
// J. Stolfi, "TSlicer: An optimal topology-based slicing algorithm for Z-monotone 3D meshes", 2024: the successor of the
// paper's own algorithm, by its authors.
//
// Edges are put into lists by the first plane that cuts them (the paper's Algorithm 2, for edges instead of triangles), and
// planes are met from the lowest up with the set of edges that are cut. A contour is traced from any edge that no contour of
// this plane has met, from half-edge to half-edge: the next crossing is on the same face, and then on its twin. Which
// half-edge of a face it was is remembered (the short cut): while that one is still cut, faces need not be looked at,
// however many edges they have.
//
// O(n + k + m) for uniform planes, O(n log k + k + m) for others, and the topology: O(n) here, by hashing.
//
// Kept: closed meshes only; of any other no contours are given. Faces are triangles here, as the soup's are. Written from
// the published abstract and what is said of the algorithm, not from its source.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

extern const WholeMethod topological;

}  // namespace lamella::baselines
