// The questions of audit(), each answered in a source of its own.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "lamella/audit.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// A result and its mesh, which can be what was sliced: as many triangles, each index in range, coordinates within the grid.
struct SlicedMesh {
    const SliceResult& result;
    const MeshView& mesh;
    Placing placing;
    Bounds bounds;
    PlaneSet planes{nullptr};  ///< with their heights on the grid only
};

// What takes long leads the progress on to `progress`.
OpenLayers find_open_layers(const SliceResult& result, const Parallel& parallel);
/// All but VolumeCertificate::open.
VolumeCertificate certify_volume(const SlicedMesh& sliced, const Parallel& parallel, double progress);
Ledger make_ledger(const SlicedMesh& sliced, const Parallel& parallel, double progress);
Crossings find_crossings(const SliceResult& result, const Parallel& parallel, double progress);

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

/// Within a closed path, in square units.
inline Int128 twice_area_of(std::span<const Point> points) noexcept {
    Int128 sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += cross(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
    }
    return sum;
}

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
