// The headers of image files.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "lamella/medical/geometry.hpp"
#include "medical/geometry/directions.hpp"

namespace lamella {

/// The first bytes of a file, or of what gzip holds.
struct ImageHeader {
    std::string name;
    std::string bytes;

    /// malformed_mesh: "NAME: WHAT".
    Error refused(const std::string& what) const;
};

/// Throws Refused (unreadable_file) and std::bad_alloc.
ImageHeader read_image_header(const std::filesystem::path& path);

/// unreadable_file: "cannot read 'NAME': REASON".
Error unreadable(const std::string& name, int error_number);
/// malformed_mesh: "NAME: WHAT".
Error malformed_image(const std::string& name, const std::string& what);

/// Both refuse by Refused or by their result what is no such image.
Result<ImageGeometry> read_nifti(const ImageHeader& header);
Result<ImageGeometry> read_nrrd(const ImageHeader& header);
/// The geometry of the one series of DICOM images in a folder. n files: O(n log n). Throws Refused and std::bad_alloc.
ImageGeometry read_dicom_folder(const std::filesystem::path& folder);

/// The geometry of voxels that lie `steps` apart from `origin`, in LPS and mm. Throws Refused where the steps are no finite
/// lengths, or not perpendicular.
ImageGeometry upright(const std::string& name, const std::array<std::uint64_t, 3>& size,
                      const std::array<Direction, 3>& steps, const Direction& origin);

}  // namespace lamella
