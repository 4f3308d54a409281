// What the tests of medical files share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/lamella.hpp"
#include "lamella/medical.hpp"
#include "temp_folder.hpp"

namespace medical {

using namespace lamella;
using namespace shapes;
using Catch::Contains;

/// Upright in LPS.
inline ImageGeometry image_of(std::array<std::uint64_t, 3> size, std::array<double, 3> spacing,
                              std::array<double, 3> origin) {
    ImageGeometry image;
    image.size = size;
    image.spacing_mm = spacing;
    image.origin_mm = origin;
    return image;
}

/// Options to cut a mesh at the slices of an image.
inline SliceOptions at_slices(const ImageGeometry& image, int subslices = 1) {
    return {.heights_mm = image.slice_heights_mm(subslices), .frame = {.transform = image.slicing_frame(PatientFrame::lps)}};
}

inline SliceResult cut(const Soup& soup, const ImageGeometry& image, int subslices = 1) {
    return sliced(soup, at_slices(image, subslices));
}

/// A box without its last side.
inline Soup open_box(Xyz low, Xyz high) {
    return without(box(low, high), 10, 2);
}

/// Damages a file byte by byte, and cuts it off: each is read as some image, or refused in one line. Returns how many were
/// refused.
template <class Read>
int refused_of_damaged(const std::string& whole, std::size_t end, std::size_t step, const Read& read) {
    int refused = 0;
    for (std::size_t at = 0; at < std::min(whole.size(), end); at += step) {
        std::vector<std::string> variants = {whole.substr(0, at), whole, whole};
        variants[1][at] = static_cast<char>(variants[1][at] ^ 0xff);
        variants[2][at] = static_cast<char>(variants[2][at] ^ 0x01);
        for (const std::string& bytes : variants) {
            const Result<ImageGeometry> image = read(bytes);
            if (image) {
                REQUIRE(std::isfinite(image->slicing_frame(PatientFrame::lps).m[3]));
            } else {
                ++refused;
                REQUIRE(error_of(image).code == ErrorCode::malformed_mesh);
            }
        }
    }
    return refused;
}

/// A host that wants every call to end.
inline constexpr auto always = []() noexcept { return true; };

}  // namespace medical
