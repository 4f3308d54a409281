// The core of lamella: a mesh in memory is sliced, and mesh and result are judged. Mesh files and writers: lamella/io.hpp.
//
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(mesh);
//     if (sliced) {
//         std::printf("%zu layers, %zu contours\n", sliced->layers.size(), sliced->contours.size());
//     }
//
// Which call to make when. Slicing one mesh again and again, at other heights or by other rules: prepare() it once. Top and
// bottom surfaces of layers: slice_slabs().
// Before slicing, inspect() says in O(n) whether a mesh is closed and what its box is; check() takes longer and says
// what is wrong with it and where, down to faces that cross. Slicing itself needs neither. After slicing, make_ledger()
// says what of the mesh no layer shows: parts that lie between two planes. certify_volume() compares areas and volumes
// with the mesh, by another computation than slicing: call it where a wrong layer would be costly. find_open_layers()
// says of how many layers the area is not known, and what would close them. find_crossings() says
// where contours of a layer run through one another, which check() would find in the mesh as crossing faces, more
// slowly. validate() is for tests and for results that a program has changed: it holds for every result as slice()
// returns it.
#pragma once

#include "lamella/assemble.hpp"
#include "lamella/audit/crossings.hpp"
#include "lamella/audit/ledger.hpp"
#include "lamella/audit/open_layers.hpp"
#include "lamella/audit/validate.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/experiments.hpp"
#include "lamella/grid.hpp"
#include "lamella/host_output.hpp"
#include "lamella/integer128.hpp"
#include "lamella/islands.hpp"
#include "lamella/memory.hpp"
#include "lamella/mesh.hpp"
#include "lamella/mesh/check.hpp"
#include "lamella/mesh/inspect.hpp"
#include "lamella/mesh/orient.hpp"
#include "lamella/mesh/scale.hpp"
#include "lamella/mesh/weld.hpp"
#include "lamella/parts.hpp"
#include "lamella/planes.hpp"
#include "lamella/prepare.hpp"
#include "lamella/region.hpp"
#include "lamella/result.hpp"
#include "lamella/sink.hpp"
#include "lamella/slabs.hpp"
#include "lamella/slice.hpp"
#include "lamella/version.hpp"
