// The header of a mask's file: everything before the voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "base/little_endian.hpp"
#include "lamella/medical/mask.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

/// NIfTI's numbers, and gzip's, are written little-endian.
template <class T>
void put_at(std::string& header, std::size_t at, T value) {
    std::memcpy(header.data() + at, &value, sizeof value);
}

std::string nifti_header(const MaskLayout& layout, std::size_t labels, const ImageGeometry& image);
/// `layers`: of each part.
std::string nrrd_header(const MaskLayout& layout, std::span<const MaskPart> parts, std::span<const std::size_t> layers,
                        const ImageGeometry& image);
/// Of voxels that are not compressed: MetaImage would state how many bytes they have then.
std::string meta_header(const MaskLayout& layout, const ImageGeometry& image);

}  // namespace lamella
