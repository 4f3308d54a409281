// The core of lamella: a mesh in memory is sliced, and mesh and result are judged. Mesh files and writers: lamella/io.hpp.
//
//     lamella::Slicer slicer;
//     const lamella::Result<lamella::SliceResult> sliced = slicer.slice(mesh, {.layer_height_mm = 0.2});
//     if (sliced) {
//         for (const lamella::LayerView layer : *sliced) {
//             std::printf("%g mm: %g mm2\n", layer.plane_mm, layer.area_mm2());
//         }
//     }
//
// Which call to make when:
//
//     slice.hpp     cut a mesh, parts or a file, to a result, a sink or the host's arrays
//     source.hpp    prepare() a mesh that is sliced again and again
//     sections.hpp  cut a mesh by planes of any direction
//     heights.hpp   layers as high as the surface allows
//     layers.hpp    regions and contours that come from elsewhere than a mesh
//     overlay.hpp   combine layers: unions, differences, regions by label
//     tracks.hpp    follow islands from layer to layer: births, merges, splits, cavities
//     compare.hpp   how alike two stacks of layers are: Dice, distances of contours
//     measures.hpp  areas, moments and diameters of layers and islands
//     check.hpp     is the mesh closed, and what is wrong with it?
//     weld.hpp      mend it: join vertices, turn shells
//     audit.hpp     is the result right?
#pragma once

#include "lamella/array.hpp"
#include "lamella/audit.hpp"
#include "lamella/check.hpp"
#include "lamella/compare.hpp"
#include "lamella/context.hpp"
#include "lamella/destination.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/heights.hpp"
#include "lamella/integer128.hpp"
#include "lamella/layers.hpp"
#include "lamella/measures.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"
#include "lamella/overlay.hpp"
#include "lamella/result.hpp"
#include "lamella/sections.hpp"
#include "lamella/slice.hpp"
#include "lamella/source.hpp"
#include "lamella/tracks.hpp"
#include "lamella/version.hpp"
#include "lamella/weld.hpp"
