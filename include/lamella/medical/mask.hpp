// Label masks: which voxels of an image lie inside which mesh.
//
//     const lamella::MaskPart organ{.result = &result, .name = "liver"};  // sliced at the image's slices, in its frame
//     const lamella::Result<lamella::MaskSummary> written = lamella::write_mask({&organ, 1}, image, "liver.nii.gz");
//     if (written) {
//         std::printf("%llu voxels\n", static_cast<unsigned long long>(written->voxels[0]));
//     }
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// A mesh of a mask; the label of part i is i + 1.
struct MaskPart {
    const SliceResult* result = nullptr;  ///< cut at ImageGeometry::slice_heights_mm(), in ImageGeometry::slicing_frame()
    std::string name;
};

struct MaskOptions {
    bool coverage = false;  ///< the share of each voxel's area that lies inside, instead of a label
    int subslices = 1;      ///< more than 1: the mean share over so many planes a slice
    Control control{};
};

struct MaskSummary {
    std::vector<std::uint64_t> voxels;    ///< of each label; by coverage, those that are not 0
    std::uint64_t overlapped_voxels = 0;  ///< voxels in several parts: they have the later label
    std::uint64_t open_slices = 0;        ///< slices with open polylines, which enclose nothing
    std::vector<double> cut_off_share;    ///< of each part: the share of its area in the slices that lies outside the image
};

/// Writes a mask of the size of `image`. A voxel is in where the winding number around its centre is not 0; centres on a
/// left or bottom edge are inside. The end of the name decides the format: .nii, .nii.gz, .nrrd or .seg.nrrd. Errors:
/// invalid_argument, unwritable_file, cancelled, out_of_memory.
Result<MaskSummary> write_mask(std::span<const MaskPart> parts, const ImageGeometry& image,
                               const std::filesystem::path& path, const MaskOptions& options = {}) noexcept;

}  // namespace lamella
