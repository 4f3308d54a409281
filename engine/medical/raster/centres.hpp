// Where the centres of voxels lie on the grid of a result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lamella {

/// The centres of voxels 0, 1, ... along one axis in grid units, each rounded: they ascend, and where voxels are smaller
/// than a unit several share a place. What lies beyond the grid stands just beyond it, where no contour reaches.
class Centres {
public:
    /// Preconditions: the lengths are finite and above 0. Throws std::bad_alloc.
    Centres(std::size_t count, double spacing_mm, double unit_mm);

    std::size_t size() const noexcept { return places_.size() - 2; }
    std::int64_t operator[](std::size_t voxel) const noexcept { return places_[voxel + 1]; }

    /// The first voxel whose centre lies at `place` or after it; size() where none does. O(1), or O(log n) where voxels are
    /// about as small as a unit.
    std::size_t first_from(std::int64_t place) const noexcept {
        const double guess = static_cast<double>(place) * voxels_per_unit_ + 1;  // the entry in places_
        const auto last = static_cast<double>(places_.size() - 1);
        auto entry = static_cast<std::size_t>(guess < 1 ? 1 : guess > last ? last : guess);
        entry += static_cast<std::size_t>(places_[entry] < place);
        return places_[entry - 1] < place && place <= places_[entry] ? entry - 1 : search(place);
    }

    /// Whether first_from(place) is `voxel`.
    bool begins(std::size_t voxel, std::int64_t place) const noexcept {
        return places_[voxel] < place && place <= places_[voxel + 1];
    }

private:
    std::size_t search(std::int64_t place) const noexcept;

    std::vector<std::int64_t> places_;  ///< between two that no coordinate reaches
    double voxels_per_unit_;
};

}  // namespace lamella
