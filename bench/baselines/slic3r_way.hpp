// The method of Slic3r's TriangleMeshSlicer (A. Ranellucci and others), which the paper times as "Slic3r".
//
// 1. Topology: facets get shared vertices, and edges get numbers by sorting the edges of all facets.
// 2. Facet by facet: binary search finds the planes between the facet's lowest and highest vertex. Each such plane's
// list gets a line, with the numbers of the two edges on which the line ends.
// 3. Plane by plane: lines are sorted by the edge on which they begin. Binary search finds the line that begins on the
// edge where the chain ends. Finally, chains that did not close are joined with one another, reversed if needed.
//
// O(n log n + n log k + m log m). Any planes, any mesh.
//
// Nothing is corrected. Lines are sorted in each layer, as in later versions. The version that the paper timed built a
// table of all 3 n edge numbers in every layer, O(n k). Left out: vertex numbers and marks of level facets, by which
// Slic3r chains lines that end exactly on a vertex (planes never meet a vertex here); locks; and gap closing. Where
// more than two facets share an edge, Slic3r pairs them in order of appearance; here they are paired as in the engine.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

extern const WholeMethod slic3r_way;

}  // namespace lamella::baselines
