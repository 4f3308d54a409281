// Screens of resin printers: what a layer is drawn on, pixel by pixel.
//
//     for (const lamella::Printer& printer : lamella::printers()) {
//         if (lamella::is_called(printer, "saturn 2")) {
//             const auto written = lamella::write_layers(result, "part.zip", {.screen = printer.screen});
//             std::printf("%s: %s\n", printer.name.data(), written ? "written" : written.error().message.c_str());
//         }
//     }
//
//     mesh, from above          screen, as its picture is stored
//                               column 0
//       y                         v
//       ^  F F F             row 0> F F F . . .
//       |  F                        F . . . . .     turned counter-clockwise by `turn`, then mirrored; row 0 is the
//       |  F F        ->            F F . . . .     one of the greatest y
//       |  F                        F . . . . .
//       +-----> x
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "lamella/error.hpp"
#include "lamella/result.hpp"

namespace lamella {

struct Screen {
    std::uint32_t width = 0;   ///< pixels of a row, at most 65535
    std::uint32_t height = 0;  ///< rows, at most 65535
    double pixel_x_mm = 0;
    double pixel_y_mm = 0;
    bool mirror_x = false;  ///< left and right change places, for panels that are seen from behind
    bool mirror_y = false;
    int turn = 0;         ///< the mesh on the screen, counter-clockwise: 0, 90, 180 or 270 degrees
    int levels = 256;     ///< of grey: 256 or 16 by the share of a pixel that is inside; 2 by its centre
    bool centred = true;  ///< the mesh's box on the screen; else x = 0, y = 0 is the lower left corner of the turned screen
};

/// How long a printer lights a layer.
struct PrintTimes {
    double exposure_s = 8;
    double first_exposure_s = 35;
};

struct Printer {
    std::string_view name;
    Screen screen;
};

/// Common ones, by name.
std::span<const Printer> printers() noexcept;

/// True if each of the words, in any case, is in the printer's name.
bool is_called(const Printer& printer, std::string_view words) noexcept;

/// Whether all that is sliced, as Slicer::outline() or a sink's begin() tells it, lies on the screen. Errors:
/// invalid_argument, also where the screen is none.
Status check_fit(const Screen& screen, const SliceInfo& info) noexcept;

}  // namespace lamella
