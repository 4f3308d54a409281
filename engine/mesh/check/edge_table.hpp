// The edges of a grid mesh with the faces at each.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/check/grid_mesh.hpp"

namespace lamella {

/// Sides are numbered 3 * face + corner, each running from that corner to the next.
class EdgeTable {
public:
    struct Edge {
        std::uint32_t lower;
        std::uint32_t upper;
    };

    /// O(n log(faces at a vertex)), in eight calls of run(). `mesh` must outlive the table. Throws std::bad_alloc.
    EdgeTable(const GridMesh& mesh, const Parallel& parallel);

    /// By lower vertex, then upper.
    std::size_t size() const noexcept { return first_sides_.size() - 1; }
    Edge operator[](std::size_t edge) const noexcept;

    /// Ascending.
    std::span<const std::uint32_t> sides(std::size_t edge) const noexcept {
        return {sides_.data() + first_sides_[edge], first_sides_[edge + 1] - first_sides_[edge]};
    }
    static std::uint32_t face_of(std::uint32_t side) noexcept { return side / 3; }

    /// As many faces run one way along the edge as the other.
    bool is_balanced(std::size_t edge) const noexcept {
        const std::span<const std::uint32_t> own = sides(edge);
        const auto forward = std::count_if(own.begin(), own.end(), [&](std::uint32_t side) {
            const auto& corners = mesh_.faces[side / 3].corners;
            return corners[side % 3] < corners[(side % 3 + 1) % 3];
        });
        return 2 * static_cast<std::size_t>(forward) == own.size();
    }

    /// Edges that have not one face on either hand, ascending: one face, or more than two, or two that run the same way.
    const Array<std::uint32_t>& irregular() const noexcept { return irregular_; }
    /// Edges with one face, ascending.
    const std::vector<std::uint32_t>& boundary() const noexcept { return boundary_; }

    /// True if two vertices are joined by an edge. O(log n).
    bool joins(std::uint32_t a, std::uint32_t b) const noexcept;

private:
    const GridMesh& mesh_;
    Array<std::uint32_t> first_sides_;  ///< by edge, and the end of the last
    Array<std::uint32_t> sides_;
    Array<std::uint32_t> irregular_;
    std::vector<std::uint32_t> boundary_;
};

}  // namespace lamella
