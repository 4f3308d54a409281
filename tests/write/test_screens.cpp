// Pictures of layers for resin printers: hand-worked sums, orientations, settings, refusals.
#include <map>

#include <zlib.h>

#include "engine/slicing.hpp"
#include "lamella/io/layer_file.hpp"
#include "temp_folder.hpp"

using namespace lamella;

namespace {

std::uint64_t number_at(std::string_view bytes, std::size_t at, bool big_endian = false) {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        number |= std::uint64_t{static_cast<unsigned char>(bytes.at(at + i))} << 8 * (big_endian ? 3 - i : i);
    }
    return number;
}

/// Stored entries, as their own headers give them. The directory is looked at by tests/readers/screens.py.
std::map<std::string, std::string> written(const SliceResult& result, const Screen& screen,
                                           const std::string& name = "a.zip", const Context& context = {}) {
    const TempFolder folder;
    CHECK(value_of(write_layers(result, folder / name, {.screen = screen}, context)).layers == result.size());
    const std::string zip = bytes_of(folder / name);
    std::map<std::string, std::string> entries;
    for (std::size_t at = 0; zip.substr(at, 4) == "PK\3\4";) {
        const std::size_t name_length = number_at(zip, at + 26) & 0xffff;
        const std::string entry = zip.substr(at + 30, name_length);
        entries[entry] = zip.substr(at + 30 + name_length, number_at(zip, at + 18));
        at += 30 + name_length + entries[entry].size();
    }
    return entries;
}

struct Grey {
    explicit Grey(const std::string& png)
        : width(number_at(png, 16, true)), height(number_at(png, 20, true)), raw(height * (width + 1), '\0') {
        uLongf size = raw.size();
        REQUIRE(uncompress(reinterpret_cast<Bytef*>(raw.data()), &size, reinterpret_cast<const Bytef*>(png.data()) + 41,
                           number_at(png, 33, true)) == Z_OK);
        REQUIRE(size == raw.size());
        adler = number_at(png, 41 + number_at(png, 33, true) - 4, true);
        for (const char c : raw) {
            sum += static_cast<unsigned char>(c);
        }
    }

    unsigned at(std::size_t column, std::size_t row) const {
        return static_cast<unsigned char>(raw.at(row * (width + 1) + 1 + column));
    }
    /// '#' white, '.' black; a line a row.
    std::string text() const {
        std::string lines;
        for (std::size_t row = 0; row < height; ++row) {
            for (std::size_t column = 0; column < width; ++column) {
                lines += at(column, row) == 255 ? '#' : at(column, row) == 0 ? '.' : '?';
            }
            lines += ' ';
        }
        return lines;
    }

    std::size_t width;
    std::size_t height;
    std::string raw;  ///< a byte for the filter, then the row
    std::uint64_t adler = 0;
    std::uint64_t sum = 0;
};

Grey first_of(const SliceResult& result, const Screen& screen) {
    return Grey(written(result, screen).at("1.png"));
}

SliceResult cube(shapes::Xyz by = {0, 0, 0}) {
    return sliced(shapes::moved(shapes::box({0, 0, 0}, {10, 10, 10}), by), {.layer_height_mm = 1});
}

constexpr Screen fine{.width = 400, .height = 300, .pixel_x_mm = 0.05, .pixel_y_mm = 0.05};

}  // namespace

TEST_CASE("screens: an aligned cube is white pixels and nothing else", "[write]") {
    const auto entries = written(cube(), fine);
    REQUIRE(entries.size() == 11);
    for (int layer = 1; layer <= 10; ++layer) {
        const Grey grey(entries.at(std::to_string(layer) + ".png"));
        CHECK(grey.sum == 10'200'000);
        CHECK(grey.at(100, 50) + grey.at(299, 249) == 510);
        CHECK(grey.at(99, 50) + grey.at(100, 49) + grey.at(300, 249) + grey.at(299, 250) == 0);
    }
    CHECK(entries.at("manifest.uvtools")
              .find("<LayerHeight>1</LayerHeight>\n  <ResolutionX>400</ResolutionX>\n  "
                    "<ResolutionY>300</ResolutionY>\n  <DisplayWidth>20</") != std::string::npos);
}

TEST_CASE("screens: half a pixel is half of the levels, and a side or none by its centre", "[write]") {
    Screen screen{.width = 200, .height = 190, .pixel_x_mm = 0.0625, .pixel_y_mm = 0.0625, .centred = false};
    const SliceResult half = cube({1.03125, 1, 0});  // exact on the grid
    const Grey grey = first_of(half, screen);
    CHECK(grey.sum == 160 * (159 * 255 + 2 * 128));
    CHECK((grey.at(16, 20) == 128 && grey.at(176, 20) == 128));
    screen.levels = 16;
    CHECK(first_of(half, screen).sum == 160 * (159 * 255 + 2 * 136));
    screen.levels = 2;
    CHECK(first_of(half, screen).sum == 160 * 160 * 255);
    CHECK(first_of(cube({1, 1.03125, 0}), screen).sum == 160 * 160 * 255);
}

TEST_CASE("screens: an empty layer of 59 million pixels takes 58 kB", "[write]") {
    const SliceResult gap = sliced(
        shapes::joined({shapes::box({0, 0, 0}, {10, 10, 1}), shapes::box({0, 0, 2}, {10, 10, 3})}), {.layer_height_mm = 1});
    const auto png = written(gap, {.width = 11520, .height = 5120, .pixel_x_mm = 0.019, .pixel_y_mm = 0.024}).at("2.png");
    CHECK(Grey(png).adler == 0x48bc0001);
    CHECK(Grey(png).sum == 0);
    CHECK(png.size() < 60'000);
}

TEST_CASE("screens: a letter stands as it is seen from above, turned, then mirrored", "[write]") {
    const SliceResult letter = sliced(
        shapes::walls({{0, 0}, {1, 0}, {1, 2}, {2, 2}, {2, 3}, {1, 3}, {1, 4}, {3, 4}, {3, 5}, {0, 5}}), at_heights({5}));
    const int levels = GENERATE(2, 16, 256);
    const bool centred = GENERATE(true, false);
    const auto seen = [&](int turn, bool mirror_x, bool mirror_y) {
        const bool across = turn % 180 != 0;
        return first_of(letter, {across ? 5U : 3U, across ? 3U : 5U, 1, 1, mirror_x, mirror_y, turn, levels, centred})
            .text();
    };
    CHECK(seen(0, false, false) == "### #.. ##. #.. #.. ");
    CHECK(seen(0, true, false) == "### ..# .## ..# ..# ");
    CHECK(seen(0, true, true) == "..# ..# .## ..# ### ");
    CHECK(seen(180, false, true) == "### ..# .## ..# ..# ");
    CHECK(seen(90, false, false) == "#.... #.#.. ##### ");
    CHECK(seen(270, false, false) == "##### ..#.# ....# ");
    CHECK(seen(270, true, false) == "##### #.#.. #.... ");
}

TEST_CASE("screens: contours that overlap count once, whatever the fill rule", "[write]") {
    SliceOptions options{.layer_height_mm = 1};
    options.region.fill_rule = GENERATE(FillRule::contours, FillRule::non_zero);
    const SliceResult two =
        sliced(shapes::joined({shapes::box({0, 0, 0}, {2, 2, 1}), shapes::box({1, 1, 0}, {3, 3, 1})}), options);
    const Screen screen{.width = 4, .height = 3, .pixel_x_mm = 1, .pixel_y_mm = 1, .centred = false};
    CHECK(first_of(two, screen).text() == ".##. ###. ##.. ");
}

TEST_CASE("screens: SL1 files have the settings and numbers that printers look for", "[write]") {
    const Screen screen{.width = 240, .height = 250, .pixel_x_mm = 0.05, .pixel_y_mm = 0.05, .mirror_x = true, .turn = 90};
    const std::string model = GENERATE("SL1", "SL1S");
    auto entries = written(cube(), screen, "a." + model);
    REQUIRE(entries.size() == 12);
    CHECK(Grey(entries.at("JOB00000.png")).width == 240);
    CHECK(entries.count("JOB00009.png") == 1);
    CHECK(entries.at("config.ini") ==
          "action = print\nexpTime = 8\nexpTimeFirst = 35\nexpUserProfile = 0\nhollow = 0\njobDir = JOB\nlayerHeight = "
          "1\nlayerHeightFirst = 1\nnumFade = 10\nnumFast = 0\nnumSlow = 10\nprinterModel = " +
              model + "\nprinterVariant = default\nusedMaterial = 1\n");
    for (const char* const line : {"display_height = 12.5", "display_mirror_x = 1", "display_mirror_y = 0",
                                   "display_orientation = landscape", "display_pixels_x = 240", "display_pixels_y = 250",
                                   "display_width = 12", "initial_layer_height = 1", "layer_height = 1"}) {
        INFO(line);
        CHECK(entries.at("prusaslicer.ini").find("\n" + std::string(line) + "\n") != std::string::npos);
    }
}

TEST_CASE("screens: what they cannot hold is refused, with the reason, and leaves no file", "[write]") {
    const TempFolder folder;
    const auto refused = [&](const SliceResult& result, const LayerFileOptions& options, const std::string& words) {
        const Error error = error_of(write_layers(result, folder / "a.sl1", options));
        INFO(error.message);
        CHECK(error.code == ErrorCode::invalid_argument);
        CHECK(error.message.find(words) != std::string::npos);
        CHECK(folder.names().empty());
    };
    const SliceResult whole = cube();
    const SliceResult open = sliced(shapes::without(shapes::box({0, 0, 0}, {10, 10, 10}), 4, 1), {.layer_height_mm = 1});
    refused(open, {.screen = fine}, "10 of 10 layers have open contours");
    refused(sliced(shapes::box({0, 0, 0}, {10, 10, 10}), at_heights({0.5, 1, 3}, 0)), {.screen = fine}, " mm in height");
    refused(whole, {}, "no screen");
    refused(whole, {.screen = fine, .times = {.exposure_s = 61}}, "0.1 to 60 s");
    refused(whole, {.screen = fine, .times = {.first_exposure_s = NAN}}, "up to 120 s");
    Screen screen = fine;
    screen.width = 176;
    refused(whole, {.screen = screen}, "1.2 mm beyond the screen in x, where it is 10 mm long and the screen 8.8 mm");
    screen = fine;
    screen.centred = false;
    refused(cube({0, 7, 0}), {.screen = screen}, "2 mm beyond the screen in y");
    screen.turn = 270;  // 15 mm wide and 20 high as the mesh sees it
    CHECK(check_fit(screen, cube({5, 10, 0}).info).ok());
    CHECK_FALSE(check_fit(screen, cube({5.01, 10, 0}).info).ok());
    for (const Screen& wrong : {Screen{}, Screen{.width = 70000, .height = 1, .pixel_x_mm = 1, .pixel_y_mm = 1},
                                Screen{.width = 9, .height = 9, .pixel_x_mm = NAN, .pixel_y_mm = 1},
                                Screen{.width = 99, .height = 99, .pixel_x_mm = 1, .pixel_y_mm = 1, .turn = 45},
                                Screen{.width = 99, .height = 99, .pixel_x_mm = 1, .pixel_y_mm = 1, .levels = 3}}) {
        refused(whole, {.screen = wrong}, "the screen is not");
    }
    const auto left_out = value_of(write_layers(open, folder / "a.sl1", {.leave_out_open = true, .screen = fine}));
    CHECK((left_out.open_left_out == 10 && left_out.layers == 10));
}

TEST_CASE("screens: the bytes are the same on any number of threads, and their sums are areas", "[write][threads]") {
    const SliceResult gyroid = sliced(generated(models::Shape::gyroid, 20'000), {.layer_height_mm = 0.4});
    const Screen screen{.width = 1600, .height = 1500, .pixel_x_mm = 0.02, .pixel_y_mm = 0.025};
    const auto one = written(gyroid, screen, "a.zip", {.threads = 1});
    CHECK(written(gyroid, screen, "a.zip", {.threads = 2}) == one);
    CHECK(written(gyroid, screen, "a.zip", {.threads = 7}) == one);
    for (const LayerView layer : gyroid) {
        const auto grey = static_cast<double>(Grey(one.at(std::to_string(layer.index + 1) + ".png")).sum);
        CHECK(grey / 255 * 0.02 * 0.025 == Approx(layer.area_mm2()).epsilon(1e-4));
    }
}

TEST_CASE("screens: printers are found by the words of their names", "[write]") {
    const auto called = [](std::string_view words) {
        return std::count_if(printers().begin(), printers().end(), [&](const Printer& p) { return is_called(p, words); });
    };
    CHECK((called("") == 23 && called("ULTRA  saturn 3") == 1 && called("sl1") == 2 && called("saturn nothing") == 0));
    for (const auto& [name, screen] : printers()) {
        CHECK((screen.pixel_x_mm / screen.pixel_y_mm > 0.66 && screen.pixel_x_mm / screen.pixel_y_mm < 1.5));
        CHECK(check_fit(screen, cube().info).ok());
    }
}
