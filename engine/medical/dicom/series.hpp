// A series of DICOM images as one image.
#pragma once

#include <filesystem>

#include "lamella/medical/geometry.hpp"

namespace lamella {

/// The geometry of the one series in a folder. n files: O(n log n). Throws Refused and std::bad_alloc.
ImageGeometry read_dicom_folder(const std::filesystem::path& folder);

}  // namespace lamella
