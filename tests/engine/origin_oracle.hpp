// Origins the obvious way: each triangle is cut by itself.
#pragma once

#include <compare>
#include <span>
#include <vector>

#include "engine/shapes.hpp"
#include "lamella/lamella.hpp"
#include "oracle/oracle.hpp"
#include "slicing/tuning.hpp"

namespace origin_oracle {

/// The piece that a plane cuts of a triangle, as its facet runs.
struct Cut {
    lamella::Point from;
    lamella::Point to;
    lamella::PointOrigin origin;
    friend auto operator<=>(const Cut&, const Cut&) = default;
};

/// The triangles of one mesh on the grid of a result.
class Triangles {
public:
    Triangles(const shapes::Soup& soup, const lamella::SliceResult& result, std::uint16_t part = 0);

    /// The cuts of all triangles whose cut has a length, sorted. Of triangles with the same corners the smallest stands for
    /// all.
    std::vector<Cut> cuts_at(lamella::PlaneHeight plane) const;

    /// The contour edges of a layer that come from a triangle and have a length, as the facets run, sorted.
    std::vector<Cut> edges_of(const lamella::LayerView& layer) const;

private:
    bool runs_down(const lamella::PointOrigin& origin) const;

    std::vector<oracle::Triangle> triangles_;  // equal corners: degenerate
    std::vector<std::uint32_t> stands_for_;    // of each: the smallest with the same corners
    std::uint16_t part_;
};

lamella::SliceOptions with_origins(lamella::SliceOptions options);

/// Requires a valid result whose origins suit the mesh and that is otherwise the same as without origins.
lamella::SliceResult traced(const shapes::Soup& soup, const lamella::SliceOptions& options,
                            const lamella::Tuning& tuning = {});

}  // namespace origin_oracle
