// DICOM structure sets (RTSTRUCT): the contours of organs on the slices of a CT.
//
//     const lamella::Result<lamella::ImageGeometry> ct = lamella::read_image_geometry("ct.nii.gz");  // or a DICOM folder
//     const lamella::Roi organ{.result = &result, .name = "liver"};  // sliced at the image's slices, in its frame
//     if (ct) {
//         const lamella::Result<lamella::StructureSetSummary> written =
//             lamella::write_structure_set({&organ, 1}, *ct, "liver.dcm", {.without_ct = true});
//         std::printf("%s\n", written ? "written" : written.error().message.c_str());
//     }
//
// This is no medical device: whoever uses it for patients validates what comes of it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// A mesh of a structure set.
struct Roi {
    const SliceResult* result = nullptr;  ///< cut at ImageGeometry::slice_heights_mm(), in ImageGeometry::slicing_frame()
    std::string name;
    std::array<std::uint8_t, 3> colour{255, 0, 0};
};

enum class HoleForm : std::uint8_t {
    keyhole,       ///< each hole is joined to its outer contour by a bridge that is walked twice
    exclusive_or,  ///< all contours of a ROI that has holes are CLOSEDPLANAR_XOR
};

struct StructureSetOptions {
    HoleForm holes = HoleForm::keyhole;
    bool without_ct = false;  ///< write one although `image` is no DICOM series: with UIDs of its own, and without a patient
    std::optional<std::int64_t> seconds_since_1970{};  ///< date and time (UTC) of the structure set; else they stay empty
    std::string label = "lamella";                     ///< at most 16 characters
};

struct StructureSetSummary {
    std::uint64_t contours = 0;  ///< as written: a region with its holes is one where they are keyholes
    std::uint64_t points = 0;
    std::uint64_t holes = 0;
    std::uint64_t open_contours = 0;     ///< left out, because they enclose nothing
    std::uint64_t nested_contours = 0;   ///< outer contours in the solid part of another: a fill rule unites them
    std::vector<std::string> roi_names;  ///< as written: cut to 64 characters of the set's own, and told apart
};

/// Writes an RT Structure Set (PS3.3, A.19) with one ROI a part: contours on the slices of `image` in the patient's frame,
/// in mm, each with the slice that it lies on. Where `image` is a DICOM series, its patient, study and frame of reference
/// are those of the structure set. Places have so many decimals that they give the slicing's grid back, in at most 16
/// characters: 7 by default.
///
/// The same input gives the same bytes, on any number of threads: UIDs are 2.25. and 128 bits of a SHA-256 of all that is
/// written. Implicit VR Little Endian. q points: O(q log q), memory for some slices. Errors: invalid_argument (no DICOM
/// series; one that lacks a UID; not cut at the image's slices; nothing on any slice), unwritable_file, cancelled,
/// out_of_memory.
Result<StructureSetSummary> write_structure_set(std::span<const Roi> rois, const ImageGeometry& image,
                                                const std::filesystem::path& path, const StructureSetOptions& options = {},
                                                const Context& context = {}) noexcept;

}  // namespace lamella
