// Sections: one mesh cut by many planes of any direction, in one call.
//
//     std::vector<lamella::Transform> frames;  // each turns and moves its plane to z = 0
//     for (int i = 0; i < 9; ++i) {
//         frames.push_back(lamella::Transform::from_normal(1, 0.1 * i, 0));
//         frames.back().m[11] = -1;  // 1 mm beyond the origin
//     }
//     const auto sections = lamella::slice_sections(mesh, frames);
//     if (sections) {
//         for (const lamella::LayerView section : *sections) {
//             std::printf("plane %llu: %g mm2\n", (unsigned long long)section.index, section.area_mm2());
//         }
//     }
//
// Layer i of the result is the section at z = 0 of the mesh after frames[i], in that frame's x and y; its heights are 0. It
// has the bytes that slice() of the mesh has with that transform and the height 0, on the same grid and with the same
// stitch_mm.
//
// Triangles are first put in order along a curve that fills space, with boxes around runs of them. A plane then reads the
// triangles of the boxes that it meets, and the few that reach it are sliced by themselves: each plane by one thread.
#pragma once

#include <span>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Of the options those of planes and heights have no meaning here, and Frame::transform is applied before each frame. All
/// sections share one grid: the one asked for, or the finest of the default's that holds the mesh's box in every frame.
/// stitch_by_mesh is a hundredth of the diagonal of the mesh's box.
///
/// O(n) for n triangles, then for each plane O(n / 1024) and what it meets; memory 48 bytes a triangle and the result.
/// Errors: those of slice(), of which the message begins with
/// "section N: " where one is to blame; invalid_argument (contents other than sections).
Result<SliceResult> slice_sections(const MeshView& mesh, std::span<const Transform> frames, const SliceOptions& options = {},
                                   const Context& context = {}) noexcept;

/// Of each section what a curve through the frames' origins runs in: the island whose solid holds (0, 0), else the one whose
/// outer contour comes nearest, of several the first; with its holes. Open contours stay, since nobody knows what they would
/// enclose. Origins and stitches are dropped. O(points). Errors: out_of_memory.
Result<SliceResult> keep_nearest_islands(const SliceResult& sections, const Context& context = {}) noexcept;

}  // namespace lamella
