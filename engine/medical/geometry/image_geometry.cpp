#include "lamella/medical/geometry.hpp"

#include <cmath>
#include <system_error>

#include "base/guard.hpp"
#include "medical/dicom/series.hpp"
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

namespace {

constexpr double largest_voxel_mm = 1e6;  ///< coordinates end at 1e9

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
            const double first = std::floor(min_mm[axis] / spacing);
            const double count = std::ceil(max_mm[axis] / spacing) - first + 1;
            if (!(count >= 1 && count <= static_cast<double>(largest_image_side))) {
                return Error{ErrorCode::invalid_argument, "voxels of that size are too many around the mesh"};
            }
            image.origin_mm[axis] = first * spacing;
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
        const HeaderBytes header(path);
        if (header.bytes().size() > 132 && header.bytes().substr(128, 4) == "DICM") {
            return header.refused("one DICOM file; name the folder that holds its series");
        }
        return header.begins_with("NRRD") ? read_nrrd(header) : read_nifti(header);
    });
}

}  // namespace lamella
