
#include <png.h>

#include "medical/support.hpp"

using namespace medical;

namespace {

using Pixel = std::array<int, 3>;

constexpr Pixel cell_colour{0xf1, 0xf3, 0xf5};
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
    std::size_t count(const Pixel& wanted) const {
        std::size_t found = 0;
        for (std::size_t i = 0; i < width * height; ++i) {
            found += at(i % width, i / width) == wanted ? 1U : 0U;
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
    double filled() const { return filled(0, width, 0, height); }
    double widest_row() const {
        double widest = 0;
        for (std::size_t y = 0; y < height; ++y) {
            widest = std::max(widest, filled(0, width, y, y + 1));
        }
        return widest;
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

}  // namespace

TEST_CASE("picture: filled pixels add up to the area of the layer", "[medical]") {
    // A box fills its row: the scale is known, and the area follows.
    const Soup pierced_box = joined({box({0, 0, 0}, {30, 20, 5}), flipped(box({4, 5, -1}, {11, 13, 6}))});
    const SliceResult result = sliced(pierced_box, uniform(1));
    for (const PictureOptions& options : {PictureOptions{}, PictureOptions{.x_leftward = true},
                                          PictureOptions{.width = 900, .height = 300, .y_downward = true}}) {
        const Picture picture = layer_picture({{&result, "a"}}, 2, options);
        CHECK(picture.width <= static_cast<std::size_t>(options.width));
        CHECK(picture.height <= static_cast<std::size_t>(options.height));
        const double scale = picture.widest_row() / 30;
        CHECK(scale > 10);
        CHECK(picture.filled() / (scale * scale) == Approx(30 * 20 - 7 * 8).epsilon(5e-3));
    }
    // Far from the origin, shells that overlap: by the scale that a box beside them shows.
    const Soup far = joined({octasphere({0, 0, 0}, 5, 3), octasphere({4, 3, 0}, 5, 3), box({-10, 20, -5}, {20, 21, 5})});
    const SliceResult united = sliced(moved(far, {-900, 900, 0}), uniform(1.7));
    SliceOptions by_rule = uniform(1.7);
    by_rule.region.fill_rule = FillRule::non_zero;
    const Picture picture = layer_picture({{&united, "a"}}, 3);
    const double scale = picture.widest_row() / 30;
    CHECK(picture.filled() / (scale * scale) == Approx(sliced(far, by_rule)[3].area_mm2()).epsilon(5e-3));
}

TEST_CASE("picture: a sheet shows evenly spaced layers at one scale, fewer than asked for each once", "[medical]") {
    const SliceResult result = sliced(box({0, 0, 0}, {10, 10, 100}), uniform(1));
    const Picture picture = contact_sheet({{&result, "box"}}, {.width = 900, .height = 700, .layers = 12});
    // Twelve squares of equal size, four in a row.
    const double side = picture.widest_row() / 4;
    CHECK(side > 100);
    CHECK(picture.filled() == Approx(12 * side * side).epsilon(0.01));
    CHECK(contact_sheet({{&result, "box"}}, {.width = 900, .height = 700, .layers = 1}).widest_row() > 500);
    const SliceResult few = sliced(box({0, 0, 0}, {10, 10, 3}), uniform(1));
    CHECK(contact_sheet({{&few, "box"}}, {.layers = 12}).widest_row() > 3 * 300);
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
        const Picture picture = layer_picture({{&result, ""}}, 0, options);
        const std::size_t x = picture.width / 2;
        const std::size_t y = heading / 2 + picture.height / 2;
        const std::array<double, 4> quarters = {
            picture.filled(0, x, heading, y), picture.filled(x, picture.width, heading, y),
            picture.filled(0, x, y, picture.height), picture.filled(x, picture.width, y, picture.height)};
        CHECK(std::min_element(quarters.begin(), quarters.end()) - quarters.begin() == empty_quarter);
    }
}

TEST_CASE("picture: open polylines are lines, not areas", "[medical]") {
    const SliceResult result = sliced(open_box({0, 0, 0}, {30, 30, 10}), uniform(1));
    REQUIRE(result.info.open_contours > 0);
    const Picture picture = layer_picture({{&result, "a"}}, 4);
    CHECK(picture.count(first_colour) < 300);  // the square of the heading only
    // Three sides of 30 mm, about three pixels wide.
    const auto red = static_cast<double>(picture.count(line_colour));
    CHECK(red > 3 * 800);
    CHECK(red < 3 * 1200 * 5);
}

TEST_CASE("picture: empty layers and empty results are drawn empty", "[medical]") {
    const SliceResult result = sliced(joined({box({0, 0, 0}, {5, 5, 2}), box({10, 10, 8}, {15, 15, 10})}), uniform(1));
    SliceOptions one_plane;
    one_plane.heights_mm = std::vector<double>{50};
    const SliceResult above = sliced(box({0, 0, 0}, {5, 5, 2}), one_plane);
    const SliceResult nothing;
    for (const Picture& picture :
         {layer_picture({{&result, ""}}, 5), contact_sheet({{&nothing, "nothing"}}), contact_sheet({{&above, "above"}})}) {
        CHECK(picture.filled(0, picture.width, heading, picture.height) == 0);
        CHECK(picture.count(text_colour) > 100);
    }
}

TEST_CASE("picture: parts of different planes are shown at their heights", "[medical]") {
    const SliceResult a = sliced(box({0, 0, 0}, {10, 10, 4}), uniform(1));
    const SliceResult b = sliced(box({20, 0, 3}, {30, 10, 9}), uniform(0.7));
    // At 0.5 mm only the first is met, at 3.5 mm both.
    const Picture low = layer_picture({{&a, ""}, {&b, ""}}, 0);
    const Picture both = layer_picture({{&a, ""}, {&b, ""}}, 3);
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
    const std::vector<PicturePart> parts = {{&result, "a"}};
    const TempFolder folder;
    const PictureOptions plain;
    using Parts = std::vector<PicturePart>;
    for (const auto& [what, options] :
         std::vector<std::pair<Parts, PictureOptions>>{{parts, {.width = 0, .height = 100}},
                                                       {parts, {.width = -5, .height = 100}},
                                                       {parts, {.width = 100, .height = 63}},
                                                       {parts, {.width = 100, .height = 16385}},
                                                       {parts, {.width = 2147483647, .height = 2147483647}},
                                                       {parts, {.width = 16384, .height = 16384}},
                                                       {parts, {.layers = 0}},
                                                       {parts, {.layers = 2147483647}},
                                                       {{}, plain},
                                                       {{{nullptr, "none"}}, plain},
                                                       {{{&many, "many"}}, {.width = 300, .height = 300, .layers = 3000}}}) {
        CHECK(error_of(write_contact_sheet(what, folder / "a.png", options)).code == ErrorCode::invalid_argument);
    }
    for (const auto& [what, layer] :
         std::vector<std::pair<Parts, std::uint64_t>>{{parts, 4}, {parts, std::uint64_t{1} << 63}, {{{&nothing, ""}}, 0}}) {
        CHECK(error_of(write_layer_picture(what, layer, folder / "a.png")).code == ErrorCode::invalid_argument);
    }
    CHECK(folder.names().empty());
}

TEST_CASE("picture: names of any bytes and any number of parts", "[medical]") {
    const SliceResult result = sliced(box({0, 0, 0}, {10, 10, 4}), uniform(1));
    std::vector<PicturePart> parts;
    parts.reserve(300);
    for (int i = 0; i < 300; ++i) {
        parts.push_back({&result, std::string(static_cast<std::size_t>(i * 40), static_cast<char>(i))});
    }
    CHECK(contact_sheet(parts, {.width = 800, .height = 300}).width <= 800);
    CHECK(contact_sheet(parts, {.width = 64, .height = 64, .layers = 1}).width <= 64);
}
