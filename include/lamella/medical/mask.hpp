// Label masks: which voxels of an image lie inside which mesh.
//
//     const lamella::Result<lamella::ImageGeometry> image = lamella::read_image_geometry("ct.nii.gz");
//     const lamella::MaskPart organ{.result = &result, .name = "liver"};  // sliced at the image's slices, in its frame
//     if (image) {
//         const lamella::Result<lamella::MaskSummary> written = lamella::write_mask({&organ, 1}, *image, "liver.nii.gz");
//         std::printf("%s\n", written ? "written" : written.error().message.c_str());
//     }
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "lamella/audit.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/medical/labels.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// A mesh of a mask; the label of part i is i + 1.
struct MaskPart {
    const SliceResult* result = nullptr;  ///< cut at ImageGeometry::slice_heights_mm(), in ImageGeometry::slicing_frame()
    std::string name;
    SegmentTerms terms{};  ///< for .seg.nrrd and DICOM segmentations
};

struct MaskOptions {
    bool coverage = false;  ///< the share of each voxel's area that lies inside, instead of a label
    int subslices = 1;      ///< more than 1: the mean share over so many planes a slice
    /// Of draw_mask(): from this slice on as many are drawn as there are voxels for. Results need have their layers only.
    std::uint64_t first_slice = 0;
};

struct MaskSummary {
    std::vector<std::uint64_t> voxels;    ///< of each label; by coverage, those that are not 0
    std::uint64_t overlapped_voxels = 0;  ///< voxels in several parts of a layer: they have the later label
    std::vector<OpenLayers> open;         ///< of each part: slices with open polylines, which enclose nothing
    /// Of each part: the share of its area in the slices that lies beside the image, of slices without open polylines. NaN
    /// where there are none.
    std::vector<double> cut_off_share;
    /// Of each part: how wide its slices are on average, by their areas: the shorter side of a rectangle with a slice's area
    /// and perimeter. Of a wall that is its thickness. NaN where no area is known.
    std::vector<double> mean_wall_mm;
};

/// Writes a mask of the size of `image`. A voxel is in where the winding number around its centre is not 0; centres on a
/// left or bottom edge are inside. Centres are rounded to the grid of the result, so that the answer is exact. The end of
/// the name decides the format: .nii, .nii.gz, .nrrd, .seg.nrrd (with 3D Slicer's keys) or .mha. Labels are bytes up to 255
/// parts, else two bytes; shares are bytes of which 255 stand for 1. Beside a mask of several parts stands NAME.labels.csv,
/// but for .seg.nrrd, which holds names: there parts that overlap lie in several layers, and none loses a voxel.
///
/// v voxels, q points: O(v + q) and memory for some slices. The bytes do not depend on threads. Errors: invalid_argument
/// (not cut at the image's slices; a side over 32,767 for NIfTI; too large), unwritable_file, cancelled, out_of_memory.
Result<MaskSummary> write_mask(std::span<const MaskPart> parts, const ImageGeometry& image,
                               const std::filesystem::path& path, const MaskOptions& options = {},
                               const Context& context = {}) noexcept;

/// The same mask in memory: `voxels` has room for whole slices of the image, i fastest, a byte each or with more than 255
/// parts two; of shares 255 stand for 1. O(v + q); memory of some slices for each thread. Errors: invalid_argument,
/// cancelled, out_of_memory.
Result<MaskSummary> draw_mask(std::span<const MaskPart> parts, const ImageGeometry& image, std::span<unsigned char> voxels,
                              const MaskOptions& options = {}, const Context& context = {}) noexcept;

}  // namespace lamella
