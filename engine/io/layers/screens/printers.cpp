// Sizes as makers state them; mirrors are what slicers set.
#include <algorithm>
#include <array>

#include "io/text/text.hpp"
#include "lamella/io/screen.hpp"

namespace lamella {

namespace {

/// Pixels are in um.
constexpr Printer printer(std::string_view name, std::uint32_t width, std::uint32_t height, double pixel_x, double pixel_y,
                          bool mirror_x = true, bool mirror_y = false) {
    return {name, {width, height, pixel_x / 1000, pixel_y / 1000, mirror_x, mirror_y}};
}

constexpr std::array all_printers = {
    printer("Anycubic Photon M3 Max", 6480, 3600, 46, 46),
    printer("Anycubic Photon Mono 4", 9024, 5120, 17, 17),
    printer("Anycubic Photon Mono 4K", 3840, 2400, 35, 35),
    printer("Anycubic Photon Mono M5s", 11520, 5120, 19, 24),
    printer("Anycubic Photon Mono M7 Pro", 13312, 5120, 16.8, 24.8),
    printer("Anycubic Photon Mono X 6K", 5760, 3600, 34.4, 34.4),
    printer("Creality Halot Mage Pro", 7680, 4320, 29.7, 29.7),
    printer("Creality Halot One CL-60", 1620, 2560, 50, 50, false),
    printer("Elegoo Jupiter 2", 15120, 6230, 20, 26),
    printer("Elegoo Mars 2 Pro", 1620, 2560, 51, 51),
    printer("Elegoo Mars 3", 4098, 2560, 35, 35),
    printer("Elegoo Mars 4 Ultra", 8520, 4320, 18, 18),
    printer("Elegoo Mars 5 Ultra", 8520, 4320, 18, 18),
    printer("Elegoo Saturn", 3840, 2400, 50, 50),
    printer("Elegoo Saturn 2", 7680, 4320, 28.5, 28.5),
    printer("Elegoo Saturn 3 Ultra", 11520, 5120, 19, 24),
    printer("Elegoo Saturn 4 Ultra 16K", 15120, 6230, 14, 19),
    printer("Phrozen Sonic Mega 8K", 7680, 4320, 43, 43),
    printer("Phrozen Sonic Mighty 8K", 7680, 4320, 28.5, 28.5),
    printer("Phrozen Sonic Mini 8K S", 7536, 3240, 22, 22),
    printer("Prusa SL1", 1440, 2560, 47.25, 47.25),
    printer("Prusa SL1S SPEED", 1620, 2560, 50, 50),
    printer("Uniformation GKtwo", 7680, 4320, 29.7, 29.7, false, true),
};

}  // namespace

std::span<const Printer> printers() noexcept {
    return all_printers;
}

bool is_called(const Printer& printer, std::string_view words) noexcept {
    const auto same = [](char a, char b) { return lower_case(a) == lower_case(b); };
    const char* const end = words.data() + words.size();
    for (const char* at = skip_space(words.data(), end); at != end; at = skip_space(at, end)) {
        const char* const word = at;
        at = skip_word(at, end);
        if (std::search(printer.name.begin(), printer.name.end(), word, at, same) == printer.name.end()) {
            return false;
        }
    }
    return true;
}

}  // namespace lamella
