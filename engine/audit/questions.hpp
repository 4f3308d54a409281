// The questions of audit(), each answered in a source of its own.
#pragma once

#include <span>

#include "base/parallel.hpp"
#include "lamella/audit.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// The way that the progress goes while one question is answered.
struct ProgressShare {
    const Parallel& parallel;
    double from = 0;
    double to = 1;

    /// See Parallel::begin_stage(); `fraction` is of the share.
    void begin(double fraction, std::size_t runs = 1) const { parallel.begin_stage(from + fraction * (to - from), runs); }
};

/// A result and its mesh, which can be what was sliced: as many triangles, each index in range, coordinates within the grid.
struct SlicedMesh {
    const SliceResult& result;
    const MeshView& mesh;
    Placing placing;
    Bounds bounds;
    PlaneSet planes{nullptr};  ///< with their heights on the grid only
};

OpenLayers find_open_layers(const SliceResult& result, const Parallel& parallel);
/// All but VolumeCertificate::open.
VolumeCertificate certify_volume(const SlicedMesh& sliced, const ProgressShare& progress);
Ledger make_ledger(const SlicedMesh& sliced, const ProgressShare& progress);
Crossings find_crossings(const SliceResult& result, const ProgressShare& progress);

/// Throws Refused, with the first promise that is broken. Origins are compared with `parts` where there are some: with what
/// was sliced.
void check_structure(const SliceResult& result, std::span<const Part> parts, const Parallel& parallel);

/// Throws Refused unless planes ascend, and contours of consecutive layers and points of consecutive contours follow one
/// another without gap, to the end.
void check_offsets(const SliceResult& result);

/// How the part's coordinates were placed on the result's grid.
inline Placing placing_of(const Part& part, const SliceResult& result) noexcept {
    return placing_of(part.mesh, result.info.options.frame, part.placement);
}

}  // namespace lamella
