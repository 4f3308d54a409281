// DICOM segmentations (SEG): the voxels of organs on the slices of a CT, each organ by itself, so that they may overlap.
//
//     const lamella::Result<lamella::ImageGeometry> ct = lamella::read_image_geometry("ct.nii.gz");  // or a DICOM folder
//     const lamella::MaskPart organ{.result = &result, .name = "liver"};  // sliced at the image's slices, in its frame
//     if (ct) {
//         const lamella::Result<lamella::SegmentationSummary> written =
//             lamella::write_segmentation({&organ, 1}, *ct, "liver.seg.dcm", {.without_ct = true});
//         std::printf("%s\n", written ? "written" : written.error().message.c_str());
//     }
//
// This is no medical device: whoever uses it for patients validates what comes of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/medical/mask.hpp"

namespace lamella {

struct SegmentationOptions {
    bool coverage = false;    ///< FRACTIONAL: the share of each voxel's area that lies inside, in 255ths; else BINARY
    int subslices = 1;        ///< more than 1: FRACTIONAL, the mean share over so many planes a slice
    bool without_ct = false;  ///< write one although `image` is no DICOM series: with UIDs of its own, and without a patient
    /// Date and time (UTC) of the content; else those of the CT's study, else 1970-01-01, since DICOM demands some.
    std::optional<std::int64_t> seconds_since_1970{};
};

struct SegmentationSummary {
    MaskSummary mask;                        ///< each part is counted by itself: `overlapped_voxels` is 0
    std::uint64_t frames = 0;                ///< slices of a segment that hold some of it; one of an empty segment
    std::vector<std::string> segment_names;  ///< as written: cut to 64 characters of the file's own set, and told apart
};

/// Writes a DICOM Segmentation (PS3.3, A.51) with one segment a part. A voxel is in by the rule of write_mask(). Where
/// `image` is a DICOM series, its patient, study and frame of reference are those of the segmentation, and each frame names
/// the slice that it lies on. Slices need not be evenly spaced.
///
/// The same input gives the same bytes, on any number of threads: UIDs are 2.25. and 128 bits of a SHA-256 of all that is
/// written. Implicit VR Little Endian. All is drawn twice, since the number of frames comes first. O(parts x voxels) at
/// most, O(voxels of slices that a part meets) as a rule; memory for some slices, and 16 bytes a frame. Errors:
/// invalid_argument (no DICOM series; one that lacks a UID; not cut at the image's slices; more than 65,535 parts, voxels
/// along a side, or 4 GiB), unwritable_file, cancelled, out_of_memory.
Result<SegmentationSummary> write_segmentation(std::span<const MaskPart> parts, const ImageGeometry& image,
                                               const std::filesystem::path& path, const SegmentationOptions& options = {},
                                               const Context& context = {}) noexcept;

}  // namespace lamella
