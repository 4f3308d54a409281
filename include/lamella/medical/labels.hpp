// Names, colours and terminology of labels: what segments are called and shown as, by a table that a lab keeps.
//
//     lamella::MaskPart femur{.result = &result, .name = "femur"};
//     const lamella::Result<std::vector<lamella::LabelRow>> rows = lamella::read_label_table("bones.csv");
//     if (rows && !rows->empty()) {
//         femur.terms = rows->front().terms;
//     }
//
// The table:
//
//     label,name,color,category,type,region
//     1,left femur,#e64d33,SCT^91723000^Anatomical Structure,SCT^71341001^Femur,SCT^7771000^Left
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lamella/error.hpp"

namespace lamella {

/// A code of a terminology: {"SCT", "71341001", "Femur"} of SNOMED CT.
struct Code {
    std::string scheme;   ///< at most 16 characters
    std::string value;    ///< at most 16 characters
    std::string meaning;  ///< at most 64 characters
};

/// Of a segment: what it is, and how it is shown. The default is that of 3D Slicer.
struct SegmentTerms {
    std::optional<std::array<std::uint8_t, 3>> colour{};  ///< red, green, blue; else one of six, in turn
    Code category{"SCT", "85756007", "Tissue"};
    Code type{"SCT", "85756007", "Tissue"};
    Code region{};  ///< of the body; without texts: not stated

    /// The colour, which for the segment of this index may be one of the six.
    std::array<std::uint8_t, 3> colour_of(std::size_t index) const noexcept;
};

/// A line of a table of labels.
struct LabelRow {
    std::size_t label = 0;  ///< 1 to 65,535; no two rows have the same
    std::string name;       ///< may be empty: the mesh's is kept
    SegmentTerms terms;
};

/// Reads a CSV file in UTF-8 whose first line names its columns, in any order: `label`; and if it likes `name`, `color`
/// (`#rrggbb`), `category`, `type` and `region` (each scheme^value^meaning). Empty cells state nothing. A column `voxels`,
/// as in the tables beside masks, is passed over. O(bytes). Errors, with file and line: unreadable_file, malformed_mesh
/// (another column, a label twice, no colour, no code; larger than 16 MiB), out_of_memory.
Result<std::vector<LabelRow>> read_label_table(const std::filesystem::path& path) noexcept;

}  // namespace lamella
