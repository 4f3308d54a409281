// The table of labels beside a mask of several parts.
#pragma once

#include <filesystem>
#include <span>

#include "lamella/medical/mask.hpp"

namespace lamella {

/// NAME.labels.csv beside NAME.nii.gz: label, name, voxels. Errors: unwritable_file. Throws std::bad_alloc.
Status write_label_table(std::span<const MaskPart> parts, const MaskSummary& summary, const std::filesystem::path& path);

}  // namespace lamella
