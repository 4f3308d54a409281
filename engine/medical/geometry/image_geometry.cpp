#include "lamella/medical/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "base/guard.hpp"
#include "medical/geometry/directions.hpp"
#include "medical/geometry/headers.hpp"

namespace lamella {

Transform ImageGeometry::slicing_frame(PatientFrame frame) const noexcept {
    const std::array<std::array<double, 3>, 3> rows = {axes[0], axes[1], cross(axes[0], axes[1])};
    const double mirror = frame == PatientFrame::ras ? -1 : 1;  // of the first two coordinates: RAS to LPS
    Transform to;
    for (std::size_t row = 0; row < 3; ++row) {
        to.m[4 * row] = mirror * rows[row][0];
        to.m[4 * row + 1] = mirror * rows[row][1];
        to.m[4 * row + 2] = rows[row][2];
        to.m[4 * row + 3] = -dot(rows[row], origin_mm);
    }
    return to;
}

std::vector<double> ImageGeometry::slice_heights_mm(int subslices) const {
    const double hand = dot(axes[2], cross(axes[0], axes[1])) < 0 ? -1 : 1;
    const auto centre = [&](std::uint64_t slice) {
        return slice < uneven_slices_mm.size() ? uneven_slices_mm[slice] : static_cast<double>(slice) * spacing_mm[2];
    };
    std::vector<double> heights;
    for (std::uint64_t slice = 0; slice < size[2]; ++slice) {
        for (int part = 0; part < subslices; ++part) {
            heights.push_back(hand * (centre(slice) + ((part + 0.5) / subslices - 0.5) * spacing_mm[2]));
        }
    }
    return heights;
}

std::array<double, 3> ImageGeometry::to_lps(const std::array<double, 3>& sliced_mm) const noexcept {
    const Direction normal = cross(axes[0], axes[1]);
    std::array<double, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) {
        at[i] = origin_mm[i] + axes[0][i] * sliced_mm[0] + axes[1][i] * sliced_mm[1] + normal[i] * sliced_mm[2];
    }
    return at;
}

std::size_t ImageGeometry::slice_axis() const noexcept {
    return nearest_axis(cross(axes[0], axes[1])).axis;
}

double ImageGeometry::height_lps_mm(double height_mm) const noexcept {
    const Direction normal = cross(axes[0], axes[1]);
    const double along = dot(normal, origin_mm) + height_mm;
    return nearest_axis(normal).negative ? -along : along;
}

namespace {

constexpr double largest_voxel_mm = 1e6;  ///< coordinates end at 1e9
constexpr double rounding = 1e-3;         ///< of a voxel

/// As a float where that is next to nothing.
double stored(double at_mm, double spacing_mm) {
    const auto as_float = static_cast<double>(static_cast<float>(at_mm));
    return std::abs(as_float - at_mm) <= rounding * spacing_mm ? as_float : at_mm;
}

}  // namespace

Result<ImageGeometry> geometry_around(const std::array<double, 3>& min_mm, const std::array<double, 3>& max_mm,
                                      const std::array<double, 3>& spacing_mm) noexcept {
    return guarded([&]() -> Result<ImageGeometry> {
        ImageGeometry image;
        image.spacing_mm = spacing_mm;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double spacing = spacing_mm[axis];
            if (!(spacing > 0 && spacing <= largest_voxel_mm)) {
                return Error{ErrorCode::invalid_argument, "a voxel's size must be a number of mm above 0, and at most 1e6"};
            }
            const double needed = std::ceil((max_mm[axis] - min_mm[axis]) / spacing - rounding);
            const double count = std::max(1.0, needed);
            if (!(needed >= 0 && needed <= static_cast<double>(largest_image_side))) {
                return Error{ErrorCode::invalid_argument, "voxels of that size are too many around the mesh"};
            }
            const double middle = min_mm[axis] + (max_mm[axis] - min_mm[axis]) / 2;
            image.origin_mm[axis] = stored(middle - (count - 1) / 2 * spacing, spacing);
            image.size[axis] = static_cast<std::uint64_t>(count);
        }
        return image;
    });
}

Result<ImageGeometry> read_image_geometry(const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Result<ImageGeometry> {
        std::error_code unknown;
        if (std::filesystem::is_directory(path, unknown)) {
            return read_dicom_folder(path);
        }
        const ImageHeader header = read_image_header(path);
        if (header.bytes.size() > 132 && header.bytes.compare(128, 4, "DICM") == 0) {
            return header.refused("one DICOM file; name the folder that holds its series");
        }
        return header.bytes.starts_with("NRRD") ? read_nrrd(header) : read_nifti(header);
    });
}

}  // namespace lamella
