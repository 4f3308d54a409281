// DICOM structure sets (RTSTRUCT): the contours of organs on the slices of a CT.
//
//     const lamella::Roi organ{.result = &result, .name = "liver"};  // sliced at the CT's slices, in its frame
//     const lamella::Result<lamella::StructureSetSummary> written =
//         lamella::write_structure_set({&organ, 1}, image, "liver.dcm", {.without_ct = true});
//     if (written) {
//         std::printf("%llu contours\n", static_cast<unsigned long long>(written->contours));
//     }
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "lamella/control.hpp"
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
    bool without_ct = false;                         ///< write one although `image` is no DICOM series
    std::optional<std::int64_t> seconds_since_1970;  ///< date and time of the structure set; without them they stay empty
    std::string label = "lamella";
    Control control{};
};

struct StructureSetSummary {
    std::uint64_t contours = 0;
    std::uint64_t points = 0;
    std::uint64_t open_contours = 0;  ///< left out, because they enclose nothing
    std::uint64_t open_slices = 0;    ///< slices with such
};

/// Writes one ROI a part. Errors: invalid_argument, unwritable_file, cancelled, out_of_memory.
Result<StructureSetSummary> write_structure_set(std::span<const Roi> rois, const ImageGeometry& image,
                                                const std::filesystem::path& path,
                                                const StructureSetOptions& options = {}) noexcept;

}  // namespace lamella
