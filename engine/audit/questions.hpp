// The questions of audit(), each answered in a source of its own.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "base/numbers.hpp"
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

/// Where a promise is looked at.
struct ResultPlace {
    std::optional<std::size_t> layer{};
    std::optional<std::size_t> contour{};
    std::optional<std::size_t> point{};

    /// Throws Refused, which names the place, unless the promise is kept.
    void require(bool kept, std::string_view broken) const;
};

inline bool has_area(const Contour& contour) noexcept {
    return contour.role == Role::outer || contour.role == Role::hole;
}

/// True if no rule has made, cut or dropped contours of the layer.
inline bool keeps_contours(const SliceResult& result, std::size_t layer) noexcept {
    const SliceOptions& options = result.info.options;
    return options.content == LayerContent::section &&
           options.region.rule_of(result.info.first_layer + layer) == FillRule::contours;
}

/// Origins by themselves and, where there are parts, that points come from there. Precondition: contours lie within the
/// points.
void check_origins(const SliceResult& result, std::span<const Part> parts);

}  // namespace lamella
