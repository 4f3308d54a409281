#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <png.h>
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/lamella.hpp"
#include "lamella/medical.hpp"
#include "temp_folder.hpp"

using namespace lamella;
using namespace shapes;

namespace {

using Pixel = std::array<int, 3>;

constexpr Pixel page_colour{0xff, 0xff, 0xff};
constexpr Pixel cell_colour{0xf1, 0xf3, 0xf5};
constexpr Pixel text_colour{0x2b, 0x30, 0x36};
constexpr Pixel first_colour{0x1f, 0x6f, 0xb4};
constexpr Pixel line_colour{0xd8, 0x1b, 0x1b};

struct Picture {
    std::size_t width = 0;
    std::size_t height = 0;
    std::vector<unsigned char> bytes;

    Pixel at(std::size_t x, std::size_t y) const {
        const unsigned char* const pixel = bytes.data() + 3 * (y * width + x);
        return {pixel[0], pixel[1], pixel[2]};
    }
    std::size_t count(const Pixel& wanted) const {
        std::size_t found = 0;
        for (std::size_t y = 0; y < height; ++y) {
            for (std::size_t x = 0; x < width; ++x) {
                found += at(x, y) == wanted ? 1 : 0;
            }
        }
        return found;
    }
    /// Pixels of the first part's colour, those at the edge by their share.
    double filled(std::size_t from_x, std::size_t end_x, std::size_t from_y, std::size_t end_y) const {
        double sum = 0;
        for (std::size_t y = from_y; y < end_y; ++y) {
            for (std::size_t x = from_x; x < end_x; ++x) {
                const Pixel pixel = at(x, y);
                const double share = (cell_colour[0] - pixel[0]) / static_cast<double>(cell_colour[0] - first_colour[0]);
                const double blue = (cell_colour[2] - pixel[2]) / static_cast<double>(cell_colour[2] - first_colour[2]);
                sum += share > 0 && std::abs(share - blue) < 0.03 ? share : 0;  // not of text
            }
        }
        return sum;
    }
};

Picture read_png(const std::filesystem::path& path) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&image, path.c_str()) != 0);
    image.format = PNG_FORMAT_RGB;
    Picture picture{image.width, image.height, std::vector<unsigned char>(PNG_IMAGE_SIZE(image))};
    REQUIRE(png_image_finish_read(&image, nullptr, picture.bytes.data(), 0, nullptr) != 0);
    return picture;
}

SliceResult cut_layers(const Soup& soup, double layer_height_mm = 1) {
    return sliced(MeshView::soup(floats(soup)), uniform(layer_height_mm));
}

Picture layer_picture(const std::vector<PicturePart>& parts, std::uint64_t layer, const PictureOptions& options = {}) {
    const TempFolder folder;
    require_ok(write_layer_picture(parts, layer, folder / "a.png", options));
    return read_png(folder / "a.png");
}

Picture contact_sheet(const std::vector<PicturePart>& parts, const PictureOptions& options = {}) {
    const TempFolder folder;
    require_ok(write_contact_sheet(parts, folder / "a.png", options));
    return read_png(folder / "a.png");
}

/// Pixels per mm, by the width of a solid that is as wide as the picture's box.
double widest_run(const Picture& picture) {
    double widest = 0;
    for (std::size_t y = 0; y < picture.height; ++y) {
        widest = std::max(widest, picture.filled(0, picture.width, y, y + 1));
    }
    return widest;
}

Soup pierced_box() {
    return joined({box({0, 0, 0}, {30, 20, 5}), flipped(box({4, 5, -1}, {11, 13, 6}))});
}

}  // namespace

TEST_CASE("picture: filled pixels add up to the area of the layer", "[medical]") {
    for (const Soup& soup : {pierced_box(), octasphere({3, 4, 5}, 9, 4), moved(octasphere({0, 0, 0}, 9, 2), {-900, 900, 0}),
                             joined({octasphere({0, 0, 0}, 5, 3), octasphere({20, 3, 0}, 5, 3)})}) {
        const SliceResult result = cut_layers(soup, 1.7);
        const std::uint64_t layer = result.layers.size() / 2;
        for (const PictureOptions& options : {PictureOptions{}, PictureOptions{.x_leftward = true},
                                              PictureOptions{.width = 300, .height = 900, .y_downward = true}}) {
            const Picture picture = layer_picture({{&result, "a"}}, layer, options);
            CHECK(picture.width <= static_cast<std::size_t>(options.width));
            CHECK(picture.height <= static_cast<std::size_t>(options.height));
            const double filled = picture.filled(0, picture.width, 0, picture.height);
            const double mm = result.info.box.max_mm[0] - result.info.box.min_mm[0];
            // The widest row of a sphere's layer is less than the mesh; its scale follows from the area of the cell instead.
            const double scale = std::sqrt(filled / result[layer].area_mm2());
            CHECK(scale * mm <= static_cast<double>(options.width));
            CHECK(widest_run(picture) <= scale * mm * 1.001);
        }
    }
    // A box fills its row: the scale is known, and the area follows.
    const SliceResult result = cut_layers(pierced_box());
    const Picture picture = layer_picture({{&result, "a"}}, 2);
    const double scale = widest_run(picture) / 30;
    CHECK(scale > 40);
    const double filled = picture.filled(0, picture.width, 0, picture.height);
    CHECK(filled / (scale * scale) == Approx(30 * 20 - 7 * 8).epsilon(2e-3));
}

TEST_CASE("picture: bytes do not depend on threads", "[medical][threads]") {
    const SliceResult a = cut_layers(octasphere({0, 0, 0}, 9, 4), 0.3);
    const SliceResult b = cut_layers(octasphere({4, 1, 0}, 6, 4), 0.4);
    const TempFolder folder;
    std::string sheet;
    std::string layer;
    for (const int threads : {1, 2, 7}) {
        const std::vector<PicturePart> parts = {{&a, "a"}, {&b, "b"}};
        const PictureOptions options{.width = 1500, .height = 1500};
        require_ok(write_contact_sheet(parts, folder / "s.png", options, {.threads = threads}));
        require_ok(write_layer_picture(parts, 30, folder / "l.png", options, {.threads = threads}));
        CHECK((sheet.empty() || bytes_of(folder / "s.png") == sheet));
        CHECK((layer.empty() || bytes_of(folder / "l.png") == layer));
        sheet = bytes_of(folder / "s.png");
        layer = bytes_of(folder / "l.png");
    }
    CHECK(sheet.find("tIME") == std::string::npos);
    CHECK(folder.names() == std::vector<std::string>{"l.png", "s.png"});
}

TEST_CASE("picture: a sheet shows evenly spaced layers, each at one scale", "[medical]") {
    const SliceResult result = cut_layers(box({0, 0, 0}, {10, 10, 100}));
    REQUIRE(result.layers.size() == 100);
    const Picture picture = contact_sheet({{&result, "box"}}, {.width = 900, .height = 700, .layers = 12});
    // Squares of equal size: as many as layers.
    const double one = widest_run(contact_sheet({{&result, "box"}}, {.width = 900, .height = 700, .layers = 1}));
    CHECK(one > 500);
    const double row = widest_run(picture);
    const double filled = picture.filled(0, picture.width, 0, picture.height);
    double side = 0;
    for (const double columns : {3, 4, 5, 6}) {
        if (std::abs(filled - 12 * (row / columns) * (row / columns)) < 0.01 * filled) {
            side = row / columns;
        }
    }
    CHECK(side > 100);
    // Fewer layers than asked for: each once.
    const SliceResult few = cut_layers(box({0, 0, 0}, {10, 10, 3}));
    const Picture three = contact_sheet({{&few, "box"}}, {.layers = 12});
    CHECK(three.filled(0, three.width, 0, three.height) > 0);
    CHECK(widest_run(three) > 3 * 300);
}

TEST_CASE("picture: up is up, and mirrored where asked", "[medical]") {
    // A long bar along x, and a short one above its left end.
    const SliceResult result = cut_layers(joined({box({0, 0, 0}, {40, 10, 2}), box({0, 12, 0}, {10, 30, 2})}));
    const auto quarters = [&](bool leftward, bool downward) {
        const Picture picture =
            layer_picture({{&result, ""}}, 0, {.width = 400, .height = 400, .x_leftward = leftward, .y_downward = downward});
        const std::size_t x = picture.width / 2;
        const std::size_t y = picture.height / 2;
        // Upper left, upper right.
        return std::array<bool, 2>{
            picture.filled(0, x, 0, y) > picture.filled(0, x, y, picture.height) * 0.2 && picture.filled(0, x, 0, y) > 100,
            picture.filled(x, picture.width, 0, y) > 100};
    };
    CHECK(quarters(false, false) == std::array<bool, 2>{true, false});
    CHECK(quarters(true, false) == std::array<bool, 2>{false, true});
    CHECK(quarters(false, true)[1]);
    const Picture mirrored = layer_picture({{&result, ""}}, 0, {.width = 400, .height = 400, .x_leftward = true});
    const Picture plain = layer_picture({{&result, ""}}, 0, {.width = 400, .height = 400});
    CHECK(mirrored.filled(0, 400, 0, mirrored.height) == Approx(plain.filled(0, 400, 0, plain.height)).epsilon(0.001));
}

TEST_CASE("picture: open polylines are lines, not areas", "[medical]") {
    Soup open = box({0, 0, 0}, {30, 30, 10});
    open.resize(open.size() - 18);  // without its left side
    const SliceResult result = cut_layers(open);
    REQUIRE(result.info.open_contours > 0);
    const Picture picture = layer_picture({{&result, "a"}}, 4);
    CHECK(picture.count(first_colour) < 300);  // the square of the heading only
    // Three sides of 30 mm, about three pixels wide.
    const double red = static_cast<double>(picture.count(line_colour));
    CHECK(red > 3 * 800);
    CHECK(red < 3 * 1200 * 5);
}

TEST_CASE("picture: empty layers and empty results are drawn empty", "[medical]") {
    const SliceResult result = cut_layers(joined({box({0, 0, 0}, {5, 5, 2}), box({10, 10, 8}, {15, 15, 10})}));
    const Picture picture = layer_picture({{&result, ""}}, 5);
    CHECK(picture.filled(0, picture.width, 40, picture.height) == 0);
    CHECK(picture.count(text_colour) > 100);
    const SliceResult nothing;
    const TempFolder folder;
    require_ok(write_contact_sheet(std::vector<PicturePart>{{&nothing, "nothing"}}, folder / "a.png"));
    CHECK(read_png(folder / "a.png").count(text_colour) > 100);
    CHECK(write_layer_picture(std::vector<PicturePart>{{&nothing, "nothing"}}, 0, folder / "b.png").error().code ==
          ErrorCode::invalid_argument);
    SliceOptions one_plane;
    one_plane.heights_mm = std::vector<double>{50};
    const SliceResult above = value_of(slice(MeshView::soup(floats(box({0, 0, 0}, {5, 5, 2}))), one_plane));
    require_ok(write_contact_sheet(std::vector<PicturePart>{{&above, "above"}}, folder / "c.png"));
}

TEST_CASE("picture: parts of different planes are shown at their heights", "[medical]") {
    const SliceResult a = cut_layers(box({0, 0, 0}, {10, 10, 4}), 1);
    const SliceResult b = cut_layers(box({20, 0, 3}, {30, 10, 9}), 0.7);
    // At 0.5 mm only the first is met, at 3.5 mm both.
    const Picture low = layer_picture({{&a, ""}, {&b, ""}}, 0);
    const Picture both = layer_picture({{&a, ""}, {&b, ""}}, 3);
    std::size_t new_pixels = 0;
    for (std::size_t y = 40; y < both.height; ++y) {
        for (std::size_t x = both.width / 2; x < both.width; ++x) {
            new_pixels += both.at(x, y) != low.at(x, y) ? 1 : 0;
        }
    }
    CHECK(static_cast<double>(new_pixels) == Approx(low.filled(0, low.width, 40, low.height)).epsilon(0.05));
}

TEST_CASE("picture: what cannot be drawn is refused, and nothing is left behind", "[medical]") {
    const SliceResult result = cut_layers(box({0, 0, 0}, {10, 10, 4}));
    const std::vector<PicturePart> parts = {{&result, "a"}};
    const TempFolder folder;
    const auto refused = [&](const std::vector<PicturePart>& what, const PictureOptions& options,
                             const Context& context = {}) {
        return error_of(write_contact_sheet(what, folder / "a.png", options, context)).code;
    };
    for (const auto& [width, height] :
         {std::pair{0, 100}, {-5, 100}, {100, 63}, {100, 16385}, {2147483647, 2147483647}, {16384, 16384}}) {
        CHECK(refused(parts, {.width = width, .height = height}) == ErrorCode::invalid_argument);
    }
    CHECK(refused(parts, {.layers = 0}) == ErrorCode::invalid_argument);
    CHECK(refused(parts, {.layers = 2147483647}) == ErrorCode::invalid_argument);
    CHECK(refused(parts, {}, {.threads = -1}) == ErrorCode::invalid_argument);
    CHECK(refused({}, {}) == ErrorCode::invalid_argument);
    CHECK(refused({{nullptr, "none"}}, {}) == ErrorCode::invalid_argument);
    const SliceResult many = cut_layers(box({0, 0, 0}, {10, 10, 300}), 0.1);
    CHECK(refused({{&many, "many"}}, {.width = 300, .height = 300, .layers = 3000}) == ErrorCode::invalid_argument);
    CHECK(write_layer_picture(parts, 4, folder / "a.png").error().code == ErrorCode::invalid_argument);
    CHECK(write_layer_picture(parts, 1ULL << 63, folder / "a.png").error().code == ErrorCode::invalid_argument);
    const auto stop = []() noexcept { return true; };
    CHECK(refused(parts, {}, {.stop = stop}) == ErrorCode::cancelled);
    CHECK(write_contact_sheet(parts, folder / "none" / "a.png").error().code == ErrorCode::unwritable_file);
    CHECK(folder.names().empty());
}

TEST_CASE("picture: names of any bytes and any number of parts", "[medical]") {
    const SliceResult result = cut_layers(box({0, 0, 0}, {10, 10, 4}));
    std::vector<PicturePart> parts;
    parts.reserve(300);
    for (int i = 0; i < 300; ++i) {
        parts.push_back({&result, std::string(static_cast<std::size_t>(i * 40), static_cast<char>(i))});
    }
    const Picture picture = contact_sheet(parts, {.width = 800, .height = 300});
    CHECK(picture.width <= 800);
    const Picture narrow = contact_sheet(parts, {.width = 64, .height = 64, .layers = 1});
    CHECK(narrow.count(page_colour) > 0);
}
