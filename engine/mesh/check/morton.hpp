// Morton order (the Z-order curve): vertices that follow one another in it lie close to one another.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "lamella/mesh/inspect.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// The order within a box. Its bits take turns:
///
///     x = 1 0 1      key = 1 0 0  0 1 1  1 1 0      of each axis the highest 21 bits that the box has
///     y = 0 1 1            x y z  x y z  x y z
///     z = 0 1 0
class MortonOrder {
public:
    /// In the box of `mesh`, on its grid.
    explicit MortonOrder(const MeshInfo& mesh) noexcept {
        std::int64_t extent = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis] = to_even_grid(mesh.min_mm[axis], mesh.unit_mm);
            extent = std::max(extent, std::int64_t{to_even_grid(mesh.max_mm[axis], mesh.unit_mm)} - low_[axis]);
        }
        shift_ = std::max(0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(extent))) - axis_bits);
    }

    /// Vertices that are closer than what 21 bits tell apart may have equal keys.
    std::uint64_t key(const GridVertex& v) const noexcept {
        return spread(v.x, low_[0]) << 2 | spread(v.y, low_[1]) << 1 | spread(v.z, low_[2]);
    }

private:
    static constexpr int axis_bits = 21;  ///< three fit 64

    /// Two zeros before each bit.
    std::uint64_t spread(std::int32_t coordinate, std::int64_t low) const noexcept {
        std::uint64_t bits = static_cast<std::uint64_t>(std::max<std::int64_t>(coordinate - low, 0)) >> shift_;
        bits &= 0x1FFFFF;
        bits = (bits | bits << 32) & 0x001F00000000FFFF;
        bits = (bits | bits << 16) & 0x001F0000FF0000FF;
        bits = (bits | bits << 8) & 0x100F00F00F00F00F;
        bits = (bits | bits << 4) & 0x10C30C30C30C30C3;
        return (bits | bits << 2) & 0x1249249249249249;
    }

    std::array<std::int64_t, 3> low_{};
    int shift_ = 0;
};

}  // namespace lamella
