// UIDs of a structure set, by what it holds.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "lamella/medical/structure_set.hpp"

namespace lamella {

/// SHA-256 over all that decides the bytes of a structure set. Throws std::bad_alloc.
std::array<unsigned char, 32> content_of(std::span<const Roi> rois, const ImageGeometry& image,
                                         const StructureSetOptions& options);

/// 2.25. and the UUID (version 8, RFC 9562) that the content and the purpose give, in decimals: at most 44 characters.
std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose);

}  // namespace lamella
