// The way of Slic3r's TriangleMeshSlicer (A. Ranellucci and others), which the paper times as "Slic3r".
//
// First the topology: vertices that facets share, and a number for each edge, found by sorting the edges of all facets. Then
// facet by facet: the planes between its lowest and its highest vertex are found by binary search, and for each a line is
// appended to that plane's list, with the numbers of the two edges on which it ends. Then plane by plane: lines are sorted
// by the edge on which they begin, and a chain goes on with the line, found by binary search, that begins on the edge where
// the last one ended. Chains that did not close are joined with one another at last, the other way round if need be.
//
// O(n log n + n log k + m log m). Any planes, any mesh.
//
// Mended: nothing. As in later versions, lines are sorted in each layer; the one that the paper timed made a table of all 3
// n edge numbers anew in every layer, O(n k). Left out: numbers of vertices and marks of level facets, by which Slic3r
// chains what ends exactly on a vertex, since planes never meet one here; the locks of its threads; and the closing of gaps.
// Where more than two facets share an edge, Slic3r pairs them as they come, and here they are paired as in the engine.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

extern const WholeMethod slic3r_way;

}  // namespace lamella::baselines
