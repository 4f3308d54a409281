// Which triangles of a float soup a uniform set of planes cuts, sixteen at a time from their z alone: on a fine mesh nine
// triangles in ten meet no plane, and looking at the rest of them would cost more than all that follows.
#pragma once

#include <cstddef>
#include <cstdint>

#include "3_planes/plane_set.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

/// What is known of 64 triangles.
struct ZBlock {
    std::int32_t low[64];  ///< grid units
    std::int32_t high[64];
    std::uint32_t first[64];   ///< first plane above `low`
    std::uint64_t crossed;     ///< bit t: plane first[t] lies below high[t]
    std::uint64_t level_edge;  ///< bit t: two vertices have equal z, so it may be degenerate
};

class ZScan {
public:
    ZScan(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes) noexcept;

    /// Whether this processor, mesh and set of planes allow it; else triangles must be looked at one by one.
    bool usable() const noexcept { return usable_; }

    /// Triangles [begin, begin + 64), all of which must exist. Precondition: usable().
    void operator()(std::size_t begin, ZBlock& block) const noexcept;

private:
    const std::byte* vertices_;
    std::int32_t stride_;
    float scale_;  // mm to half grid units
    const std::int32_t* planes_;
    float first_z_ = 0;
    float planes_per_unit_ = 0;
    std::int32_t last_plane_ = 0;
    bool usable_ = false;
};

}  // namespace lamella
