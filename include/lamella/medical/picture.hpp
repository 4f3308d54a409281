// Pictures (PNG): one layer, or a contact sheet of evenly spaced ones that shows a whole mesh at a glance.
//
//     const lamella::PicturePart organ{.result = &result, .name = "liver"};
//     const lamella::Status written = lamella::write_contact_sheet({&organ, 1}, "liver.png", {.width = 800, .height = 600});
//     std::printf("%s\n", written ? "written" : written.error().message.c_str());
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// A mesh of a picture, in a colour of its own. The parts are in one frame; their planes may differ.
struct PicturePart {
    const SliceResult* result = nullptr;
    std::string name;
};

/// Pixels along a side, and in all.
inline constexpr int least_picture_side = 64;
inline constexpr int largest_picture_side = 16384;
inline constexpr std::int64_t most_picture_pixels = std::int64_t{1} << 26;

struct PictureOptions {
    int width = 1600;         ///< pixels, at most: what stays empty is cut off
    int height = 1200;        ///< likewise
    int layers = 24;          ///< of a contact sheet, at most
    bool x_leftward = false;  ///< x runs to the left, not to the right
    bool y_downward = false;  ///< y runs down, not up
    /// At whose slices the parts were cut. They are then drawn as radiologists see them, left, posterior and superior to the
    /// right, right, anterior and superior up; heights are the patient's, as "S 12.5 mm", towards left (L), posterior (P) or
    /// superior (S), whichever the slices follow nearest.
    const ImageGeometry* image = nullptr;
};

/// Whether this build writes pictures: whether it has libpng. Without it the calls below give invalid_argument.
bool can_write_pictures() noexcept;

/// Draws the layer of this index in the first part, and of each other part the layer whose slab holds that height. Solid
/// areas are filled in the colour of their part, anti-aliased: the sum of the shares of all pixels is the layer's area. Open
/// polylines, which enclose nothing, are red lines. Above stand the names, a scale, the height, and how many of all layers
/// have open polylines.
///
/// p pixels, q points: O(p + q), and memory for p pixels of six bytes. The bytes do not depend on threads. Errors:
/// invalid_argument (no such layer; a side or an area beyond the limits above), unwritable_file, cancelled, out_of_memory.
Status write_layer_picture(std::span<const PicturePart> parts, std::uint64_t layer, const std::filesystem::path& path,
                           const PictureOptions& options = {}, const Context& context = {}) noexcept;

/// Draws evenly spaced layers side by side at one scale, each with its height in mm. Empty layers are shown empty. Errors:
/// as above; also where so many layers leave no room.
Status write_contact_sheet(std::span<const PicturePart> parts, const std::filesystem::path& path,
                           const PictureOptions& options = {}, const Context& context = {}) noexcept;

}  // namespace lamella
