// Pictures (PNG): one layer, or a contact sheet of evenly spaced ones.
//
//     const lamella::PicturePart organ{.result = &result, .name = "liver"};
//     const lamella::Status written = lamella::write_contact_sheet({&organ, 1}, "liver.png");
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// A mesh of a picture; all parts are sliced at the same planes, in the same frame.
struct PicturePart {
    const SliceResult* result = nullptr;
    std::string name;
};

struct PictureOptions {
    int width = 1200;  ///< pixels
    int height = 1200;
    int layers = 20;                ///< of a contact sheet: at most so many
    std::uint64_t first_layer = 0;  ///< of a slicing of which this is a range
    Control control{};
};

/// Draws the layer of this index. Errors: invalid_argument, unwritable_file, cancelled, out_of_memory.
Status write_layer_picture(std::span<const PicturePart> parts, std::uint64_t layer, const std::filesystem::path& path,
                           const PictureOptions& options = {}) noexcept;

/// Draws evenly spaced layers side by side, each with its height. Errors: as above.
Status write_contact_sheet(std::span<const PicturePart> parts, const std::filesystem::path& path,
                           const PictureOptions& options = {}) noexcept;

}  // namespace lamella
