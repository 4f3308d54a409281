// The questions of audit(), each answered in a source of its own.
#pragma once

#include <cstdint>
#include <cstdlib>
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

/// Twice the area within a closed path, in square units, and how far its edges run along the axes.
struct PathSize {
    Int128 twice_area = 0;
    std::uint64_t length = 0;  ///< up to 2^32 edges of up to 2^32
};

inline PathSize size_of(std::span<const Point> points) noexcept {
    PathSize size;
    Point from = points.empty() ? Point{} : points.back();
    for (const Point to : points) {
        const std::int64_t along_x = std::int64_t{to.x} - from.x;
        const std::int64_t along_y = std::int64_t{to.y} - from.y;
        size.twice_area += Int128{std::int64_t{from.x} + to.x} * along_y;
        size.length += static_cast<std::uint64_t>(std::abs(along_x) + std::abs(along_y));
        from = to;
    }
    return size;
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
