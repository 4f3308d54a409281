// Where every triangle of a sliced mesh went, so that nothing vanishes unsaid: what lies between two planes is in no layer.
#pragma once

#include <cstdint>
#include <vector>

#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "lamella/status.hpp"

namespace lamella {

/// What lies between two neighbouring planes and crosses neither.
struct Slab {
    std::uint64_t layer = 0;  ///< the plane above it, as an index into SliceResult::layers; their number: above all planes
    std::uint64_t triangles = 0;  ///< wholly inside, horizontal ones among them
    double flat_up_mm2 = 0;       ///< horizontal faces that face up: where the part ends
    double flat_down_mm2 = 0;     ///< and down: where it begins
};

/// triangles = cut + between + degenerate.
struct Ledger {
    std::uint64_t triangles = 0;
    std::uint64_t cut = 0;  ///< by at least one plane
    std::uint64_t between = 0;
    std::uint64_t degenerate = 0;  ///< two equal vertices on the grid; dropped
    std::uint64_t horizontal = 0;  ///< of those between planes
    double flat_up_mm2 = 0;
    double flat_down_mm2 = 0;
    std::vector<Slab> slabs;          ///< those that hold something, from below
    std::vector<std::uint64_t> gaps;  ///< layers without a contour that have some below and above
};

/// Counts again, from the mesh and the result's planes alone. `mesh` must be what was sliced. O(n log k). Errors:
/// invalid_argument (the mesh has not the result's number of triangles), out_of_memory.
Result<Ledger> ledger(const MeshView& mesh, const SliceResult& result) noexcept;

}  // namespace lamella
