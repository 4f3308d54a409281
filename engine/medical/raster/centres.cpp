#include "medical/raster/centres.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lamella/grid.hpp"

namespace lamella {

Centres::Centres(std::size_t count, double spacing_mm, double unit_mm)
    : places_(count + 2), voxels_per_unit_(unit_mm / spacing_mm) {
    constexpr std::int64_t beyond = std::int64_t{grid_limit} + 1;
    for (std::size_t voxel = 0; voxel < count; ++voxel) {
        const double place = std::round(static_cast<double>(voxel) * spacing_mm / unit_mm);
        places_[voxel + 1] = place < static_cast<double>(beyond) ? static_cast<std::int64_t>(place) : beyond;
    }
    places_.front() = std::numeric_limits<std::int64_t>::min();
    places_.back() = std::numeric_limits<std::int64_t>::max();
}

std::size_t Centres::search(std::int64_t place) const noexcept {
    return static_cast<std::size_t>(std::lower_bound(places_.begin() + 1, places_.end() - 1, place) - places_.begin()) - 1;
}

}  // namespace lamella
