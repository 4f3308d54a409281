// Whether a result keeps the promises of result.hpp that can be seen from the result alone: for tests, and for results that
// were read or changed.
//
//     const lamella::Status valid = lamella::validate(result);
//     if (!valid) {
//         std::fprintf(stderr, "layer %d: %s\n", static_cast<int>(valid.error().plane), valid.error().message.c_str());
//     }
#pragma once

#include <span>

#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/parts.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Checks that offsets are contiguous, contours closed and in their order, oriented as their role says, areas exact, parents
/// around their children and nested where contours do not cross, layers ordered, and no segment lost. The error
/// (invalid_argument, with the layer as Error::plane) names the first broken promise with its layer and contour. O(m log m)
/// for m points, on the calling thread. Errors: also out_of_memory.
/// Of origins, where there are some, it looks at what needs no mesh: how many they are, their parts and edges.
Status validate(const SliceResult& result) noexcept;

/// The same, and checks the origins against the mesh that was sliced, or against all parts: the triangle is there, and the
/// plane cuts the edges that are named; the point lies on the named edge to the unit, and the contour edge on what the plane
/// cuts of the triangle; where no region was made it runs as the facet does, unless the contour is marked or was turned
/// round. Besides O(n) for n triangles. Errors: also those of slice() about the mesh.
Status validate(const SliceResult& result, const MeshView& mesh) noexcept;
Status validate(const SliceResult& result, std::span<const Part> parts) noexcept;

}  // namespace lamella
