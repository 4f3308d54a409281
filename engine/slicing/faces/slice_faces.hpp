// Projecting faces onto layers: LayerContent other than sections.
#pragma once

#include "lamella/source.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

/// Refuses sources that have no faces, and rules that pieces cannot have.
void check_faces(const Source& from, const SliceOptions& options);

/// Precondition: options were checked. Throws Refused, Stopped, std::bad_alloc. n triangles, m pieces, q points left of a
/// layer when its edges between pieces have cancelled: O(n + k + m) for k uniform planes, O(n log k + k + m) otherwise, and
/// O(q log q) a layer. Memory: 8 bytes a piece, about 200 a piece of the largest layer for each thread, and the result.
void slice_faces(const MeshView& mesh, const SliceCall& call, LayerTarget& target, SliceResult& result);

/// The stages up to the count of pieces.
void outline_faces(const MeshView& mesh, const SliceCall& call, SliceInfo& info);

}  // namespace lamella
