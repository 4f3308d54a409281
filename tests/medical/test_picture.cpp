// Areas of pictures: tests/readers/solid.py.
#include <optional>

#include <png.h>

#include "medical/support.hpp"

using namespace medical;

namespace {

using Pixel = std::array<int, 3>;

constexpr Pixel text_colour{0x2b, 0x30, 0x36};
constexpr Pixel first_colour{0x1f, 0x6f, 0xb4};
constexpr Pixel line_colour{0xd8, 0x1b, 0x1b};
constexpr std::size_t heading = 40;

struct Picture {
    std::size_t width = 0;
    std::size_t height = 0;
    std::vector<unsigned char> bytes;

    Pixel at(std::size_t x, std::size_t y) const {
        const unsigned char* const pixel = bytes.data() + 3 * (y * width + x);
        return {pixel[0], pixel[1], pixel[2]};
    }
    std::size_t count(const Pixel& wanted, std::size_t from_x, std::size_t end_x, std::size_t from_y,
                      std::size_t end_y) const {
        std::size_t found = 0;
        for (std::size_t y = from_y; y < end_y; ++y) {
            for (std::size_t x = from_x; x < end_x; ++x) {
                found += at(x, y) == wanted ? 1U : 0U;
            }
        }
        return found;
    }
    std::size_t count(const Pixel& wanted) const { return count(wanted, 0, width, 0, height); }
    /// Pixels of the first part's colour.
    double filled(std::size_t from_x, std::size_t end_x, std::size_t from_y, std::size_t end_y) const {
        return static_cast<double>(count(first_colour, from_x, end_x, from_y, end_y));
    }
    double filled() const { return filled(0, width, 0, height); }
    double widest_row() const {
        double widest = 0;
        for (std::size_t y = 0; y < height; ++y) {
            widest = std::max(widest, filled(0, width, y, y + 1));
        }
        return widest;
    }
};

/// One layer, or a contact sheet.
Picture drawn(const std::vector<PicturePart>& parts, std::optional<std::uint64_t> layer,
              const PictureOptions& options = {}) {
    const TempFolder folder;
    const std::filesystem::path path = folder / "a.png";
    require_ok(layer ? write_layer_picture(parts, *layer, path, options) : write_contact_sheet(parts, path, options));
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&image, path.c_str()) != 0);
    image.format = PNG_FORMAT_RGB;
    Picture picture{image.width, image.height, std::vector<unsigned char>(PNG_IMAGE_SIZE(image))};
    REQUIRE(png_image_finish_read(&image, nullptr, picture.bytes.data(), 0, nullptr) != 0);
    return picture;
}

}  // namespace

TEST_CASE("picture: a sheet shows evenly spaced layers at one scale, fewer than asked for each once", "[medical]") {
    const SliceResult result = sliced(box({0, 0, 0}, {10, 10, 100}), uniform(1));
    const Picture picture = drawn({{&result, "box"}}, std::nullopt, {.width = 900, .height = 700, .layers = 12});
    // Twelve squares of equal size, four in a row.
    const double side = picture.widest_row() / 4;
    CHECK(side > 100);
    CHECK(picture.filled() == Approx(12 * side * side).epsilon(0.01));
    CHECK(drawn({{&result, "box"}}, std::nullopt, {.width = 900, .height = 700, .layers = 1}).widest_row() > 500);
    const SliceResult few = sliced(box({0, 0, 0}, {10, 10, 3}), uniform(1));
    CHECK(drawn({{&few, "box"}}, std::nullopt, {.layers = 12}).widest_row() > 3 * 300);
}

TEST_CASE("picture: up is up, mirrored where asked, and slices of an image are seen as radiologists see them", "[medical]") {
    // A long bar along x, and a short one above its left end.
    const SliceResult result = sliced(joined({box({0, 0, 0}, {40, 10, 2}), box({0, 12, 0}, {10, 30, 2})}), uniform(1));
    std::array<ImageGeometry, 3> images;
    images[1].axes = {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
    images[2].axes = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};  // coronal
    for (const auto& [options, empty_quarter] : {std::pair{PictureOptions{}, 1},
                                                 {PictureOptions{.x_leftward = true}, 0},
                                                 {PictureOptions{.y_downward = true}, 3},
                                                 {PictureOptions{.image = &images[0]}, 3},
                                                 {PictureOptions{.image = &images[1]}, 0},
                                                 {PictureOptions{.image = &images[2]}, 1}}) {
        const Picture picture = drawn({{&result, ""}}, 0, options);
        const std::size_t x = picture.width / 2;
        const std::size_t y = heading / 2 + picture.height / 2;
        const std::array<double, 4> quarters = {
            picture.filled(0, x, heading, y), picture.filled(x, picture.width, heading, y),
            picture.filled(0, x, y, picture.height), picture.filled(x, picture.width, y, picture.height)};
        CHECK(std::min_element(quarters.begin(), quarters.end()) - quarters.begin() == empty_quarter);
    }
}

TEST_CASE("picture: open polylines are lines, not areas; empty layers and empty results are drawn empty", "[medical]") {
    const SliceResult open = sliced(open_box({0, 0, 0}, {30, 30, 10}), uniform(1));
    const Picture lines = drawn({{&open, "a"}}, 4);
    CHECK(lines.count(first_colour) < 300);  // the square of the heading only
    const auto red = static_cast<double>(lines.count(line_colour));
    CHECK((red > 3 * 800 && red < 3 * 1200 * 5));  // three sides of 30 mm, about three pixels wide
    const SliceResult result = sliced(joined({box({0, 0, 0}, {5, 5, 2}), box({10, 10, 8}, {15, 15, 10})}), uniform(1));
    const SliceResult above = sliced(box({0, 0, 0}, {5, 5, 2}), at_heights({50}));
    const SliceResult nothing;
    for (const Picture& picture : {drawn({{&result, ""}}, 5), drawn({{&nothing, "nothing"}}, std::nullopt),
                                   drawn({{&above, "above"}}, std::nullopt)}) {
        CHECK(picture.filled(0, picture.width, heading, picture.height) == 0);
        CHECK(picture.count(text_colour) > 100);
    }
}

TEST_CASE("picture: parts of different planes are shown at their heights", "[medical]") {
    const SliceResult a = sliced(box({0, 0, 0}, {10, 10, 4}), uniform(1));
    const SliceResult b = sliced(box({20, 0, 3}, {30, 10, 9}), uniform(0.7));
    // At 0.5 mm only the first is met, at 3.5 mm both.
    const Picture low = drawn({{&a, ""}, {&b, ""}}, 0);
    const Picture both = drawn({{&a, ""}, {&b, ""}}, 3);
    double new_pixels = 0;
    for (std::size_t i = both.width * heading; i < both.width * both.height; ++i) {
        const std::size_t x = i % both.width;
        new_pixels += x >= both.width / 2 && both.at(x, i / both.width) != low.at(x, i / both.width) ? 1 : 0;
    }
    CHECK(new_pixels == Approx(low.filled(0, low.width, heading, low.height)).epsilon(0.05));
}

TEST_CASE("picture: what cannot be drawn is refused, and nothing is left behind", "[medical]") {
    const SliceResult result = sliced(box({0, 0, 0}, {10, 10, 4}), uniform(1));
    const SliceResult many = sliced(box({0, 0, 0}, {10, 10, 300}), uniform(0.1));
    const SliceResult nothing;
    const TempFolder folder;
    struct Case {
        PicturePart part;
        PictureOptions options;
        std::optional<std::uint64_t> layer = std::nullopt;
    };
    const PicturePart part{&result, "a"};
    for (const auto& [what, options, layer] :
         std::vector<Case>{{part, {.width = 0, .height = 100}},
                           {part, {.width = -5, .height = 100}},
                           {part, {.width = 100, .height = 63}},
                           {part, {.width = 100, .height = 16385}},
                           {part, {.width = 2147483647, .height = 2147483647}},
                           {part, {.width = 16384, .height = 16384}},
                           {part, {.layers = 0}},
                           {part, {.layers = 2147483647}},
                           {{nullptr, "none"}, {}},
                           {{&many, "many"}, {.width = 300, .height = 300, .layers = 3000}},
                           {part, {}, 4},
                           {part, {}, std::uint64_t{1} << 63},
                           {{&nothing, ""}, {}, 0}}) {
        const Status status = layer ? write_layer_picture({&what, 1}, *layer, folder / "a.png", options)
                                    : write_contact_sheet({&what, 1}, folder / "a.png", options);
        CHECK(error_of(status).code == ErrorCode::invalid_argument);
    }
    CHECK(error_of(write_contact_sheet({}, folder / "a.png")).code == ErrorCode::invalid_argument);
    CHECK(folder.names().empty());
}

TEST_CASE("picture: names of any bytes and any number of parts", "[medical]") {
    const SliceResult result = sliced(box({0, 0, 0}, {10, 10, 4}), uniform(1));
    std::vector<PicturePart> parts;
    parts.reserve(300);
    for (int i = 0; i < 300; ++i) {
        parts.push_back({&result, std::string(static_cast<std::size_t>(i * 40), static_cast<char>(i))});
    }
    CHECK(drawn(parts, std::nullopt, {.width = 800, .height = 300}).width <= 800);
    CHECK(drawn(parts, std::nullopt, {.width = 64, .height = 64, .layers = 1}).width <= 64);
}
