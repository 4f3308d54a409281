// The file of a mask: a header, then slices of voxels, compressed in pieces or not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/medical/mask.hpp"

namespace lamella {

enum class MaskForm : std::uint8_t { nifti, nrrd, segmentation };

struct MaskLayout {
    MaskForm form = MaskForm::nifti;
    bool compressed = false;
    bool shares = false;  ///< bytes of which 255 stand for 1, not labels
    std::size_t voxel_bytes = 1;
    std::vector<std::string> names;  ///< of labels 1, 2, ...
};

/// By the end of the name. Throws Refused.
MaskLayout layout_of(const std::filesystem::path& path, std::span<const MaskPart> parts, bool shares);

/// Throws Refused where the format, or any, does not hold a mask of that size.
void require_mask_fits(const std::filesystem::path& path, const MaskLayout& layout, const ImageGeometry& image);

/// Everything before the voxels.
std::string mask_header(const MaskLayout& layout, const ImageGeometry& image);

/// Compresses `data` to a piece of a gzip member; `last`: which it ends. Throws std::bad_alloc.
std::vector<unsigned char> gzip_piece(std::span<const unsigned char> data, bool last);

/// Begin and end of a gzip member, without a time, around pieces that hold so much in all.
inline constexpr std::string_view gzip_begin("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);
std::string gzip_end(unsigned long crc, std::uint64_t length);

}  // namespace lamella
