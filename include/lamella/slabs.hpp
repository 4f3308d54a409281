// What upward and downward faces of a mesh project onto each layer: its top and bottom surfaces, or those of a part of it
// that a user has marked.
//
//     lamella::SlabOptions slab_options;
//     slab_options.plan.spacing = lamella::ExplicitPlanes{.heights_mm = {1, 2, 3}};
//     const lamella::Result<lamella::Slabs> slabs = lamella::slice_slabs(mesh, slab_options);
//     if (slabs) {
//         for (const lamella::Layer& layer : slabs->top.layers) {
//             std::printf("z %g mm: %g mm2 of top surface\n", layer.plane_mm, slabs->top.area_mm2(layer));
//         }
//     }
//
// Planes cut the faces into pieces. A piece projects straight down or up to the nearest plane on the side of its solid,
// which lies below an upward face and above a downward one:
//
//                    .---.                  upward: to plane 2
//     plane 2   -----|---|-------------
//                    |   '.                 upward, cut in two by plane 1: to planes 1 and 0
//     plane 1   -----|-----'.----------
//                    '--.    '.             downward: to plane 1
//     plane 0   --------|-----|--------
//                       '-----'             downward: to plane 0
//
// So the upward faces of a closed mesh between planes i and i + 1 are the top surface of layer i. Where none of them lies
// above another, that is what layer i has and layer i + 1 has not. Upward pieces below the lowest plane and downward pieces
// above the highest one project to none. Two planes, far below and far above the mesh, give the whole shadow: of upward
// faces in layer 0, of downward ones in layer 1.
//
// A horizontal face at a plane's very height lies where a vertex of that height does (planes.hpp). By PlaneSide::below, the
// default, it lies above the plane: an upward one projects to that plane, a downward one to the next plane above.
#pragma once

#include <cstdint>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/planes.hpp"
#include "lamella/region.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"

namespace lamella {

/// As the fields of SliceOptions with the same names.
struct SlabOptions {
    LayerPlan plan{};
    double unit_mm = 0;
    UnitFit unit_fit = UnitFit::as_asked;
    bool allow_empty = false;
    /// One that mirrors turns no face inside out: what is outside stays outside.
    Transform transform{};
    /// What is done after pieces are united. The fill rule is given, and must be left out here.
    RegionRules region{};
    bool top = true;     ///< what upward faces project
    bool bottom = true;  ///< what downward faces project
    std::uint64_t memory_limit_bytes = 0;
    Control control{};
};

/// One of them that was not asked for has no layers. Each as slice() gives a result, with the layers of slice() for the same
/// plan, but that:
///  - the contours of a layer are the region of all pieces that project to it, by FillRule::positive; they are outers and
///    holes, with their edges as Contour::segments;
///  - Layer::segments counts the pieces, and the summary the pieces as segments and the faces that have some as crossed.
struct Slabs {
    SliceResult top;
    SliceResult bottom;
};

/// Projects the faces of `mesh`, which may be open: a part of a surface is projected by itself. A face looks upward where
/// its projection runs counter-clockwise on the grid, downward where it runs clockwise; one without area there projects
/// nothing. Faces that share a mesh edge share the points where planes cut it, which are those of slice(): neither gaps nor
/// overlaps arise between them, and borders of layers meet the contours of slice() on the same planes. Every other point is
/// a vertex, or made as regions make it. The bytes do not depend on threads, the order of triangles, or of their vertices.
///
/// n triangles, m pieces, q points left of a layer when its edges between pieces have cancelled: O(n + k + m) for k uniform
/// planes, O(n log k + k + m) otherwise, and O(q log q) a layer for the region, as region_of(). Threads share triangles,
/// then slabs: all pieces of a layer are united by one thread. Memory from `control.memory`: 8 bytes a piece, about 100 a
/// piece of the largest layer for each thread, and the result; some counters and objects of a fixed size take operator new.
/// A result is refused as too large by its layers and pieces, before either is stored. Not for make_ledger() and
/// certify_volume(). Errors: those of slice(), and invalid_argument (neither top nor bottom, a fill rule in `region`).
Result<Slabs> slice_slabs(const MeshView& mesh, const SlabOptions& options = {}) noexcept;

}  // namespace lamella
