// Pictures of layers for resin printers: SL1 archives, and zips of PNGs with the manifest of UVtools.
//
//     add       layers are kept until there is a batch
//     batch     each is drawn in bands of rows, and encoded, on a thread of its own; then appended in order
//     finish    settings, which say what all layers need
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/layers/screens/run_deflate.hpp"
#include "io/layers/zip_writer.hpp"
#include "io/raster/coverage.hpp"
#include "io/text/mm_text.hpp"

namespace lamella {

namespace {

/// Where points lie: in pixels from the upper left corner of the picture, rows downwards.
class ScreenMap {
public:
    ScreenMap(const Screen& screen, const SliceInfo& info) : screen_(screen), grid_mm_(info.grid_mm) {
        const auto& [low, high] = info.box;
        const PointMm half{0.5 * screen.width * screen.pixel_x_mm, 0.5 * screen.height * screen.pixel_y_mm};
        middle_ = screen.centred           ? PointMm{(low[0] + high[0]) / 2, (low[1] + high[1]) / 2}
                  : screen.turn % 180 == 0 ? half
                                           : PointMm{half.y, half.x};
    }

    PointMm from_mm(double x_mm, double y_mm) const noexcept {
        double x = x_mm - middle_.x;
        double y = y_mm - middle_.y;
        for (int turned = 0; turned < screen_.turn; turned += 90) {
            x = -std::exchange(y, x);
        }
        return {0.5 * screen_.width + (screen_.mirror_x ? -x : x) / screen_.pixel_x_mm,
                0.5 * screen_.height + (screen_.mirror_y ? y : -y) / screen_.pixel_y_mm};
    }
    PointMm operator()(Point point) const noexcept { return from_mm(point.x * grid_mm_, point.y * grid_mm_); }

    /// -1 where contours run the other way round in the picture.
    double sign() const noexcept { return screen_.mirror_x == screen_.mirror_y ? -1 : 1; }

private:
    Screen screen_;
    double grid_mm_;
    PointMm middle_;  ///< of the screen, in the mesh
};

bool is_screen(const Screen& screen) {
    constexpr std::uint32_t most_pixels = 65535;  // UVtools counts in 16 bits
    const auto is_side = [](std::uint32_t pixels, double mm) {
        return pixels >= 1 && pixels <= most_pixels && mm >= 1e-4 && mm <= 1e3;
    };
    return is_side(screen.width, screen.pixel_x_mm) && is_side(screen.height, screen.pixel_y_mm) && screen.turn >= 0 &&
           screen.turn <= 270 && screen.turn % 90 == 0 &&
           (screen.levels == 2 || screen.levels == 16 || screen.levels == 256);
}

void append_big_endian(std::string& to, std::uint64_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) {
        to += static_cast<char>(number >> shift & 255);
    }
}

void append_chunk(std::string& png, const std::string& type_and_data) {
    append_big_endian(png, type_and_data.size() - 4);
    png += type_and_data;
    append_big_endian(png, ::crc32_z(0, reinterpret_cast<const unsigned char*>(type_and_data.data()), type_and_data.size()));
}

/// 8-bit grey.
std::string png_of(const Screen& screen, const std::string& deflated) {
    constexpr std::size_t longest_chunk = std::size_t{1} << 30;
    std::string png = "\x89PNG\r\n\x1a\n";
    std::string head = "IHDR";
    append_big_endian(head, screen.width);
    append_big_endian(head, screen.height);
    append_chunk(png, head.append("\x08\0\0\0\0", 5));
    for (std::size_t at = 0; at < deflated.size(); at += longest_chunk) {
        append_chunk(png, "IDAT" + deflated.substr(at, longest_chunk));
    }
    append_chunk(png, "IEND");
    return png;
}

/// A layer that is kept, and its picture.
struct Picture {
    LayerView layer;
    std::vector<Contour> contours;
    std::vector<Point> points;
    std::string png;
    std::uint64_t grey = 0;  ///< sum over all pixels
};

/// One a thread.
class Painter {
public:
    void paint(Picture& picture, const SliceInfo& info, const Screen& screen, const ScreenMap& map) {
        placed_.clear();
        for (const std::span<const Point> contour : solid_.of(info, picture.layer)) {
            std::transform(contour.begin(), contour.end(), std::back_inserter(placed_.emplace_back()), map);
        }
        const std::size_t band = std::max<std::size_t>(1, sheet_bytes / sizeof(double) / (screen.width + 1));
        RunDeflater deflater;
        picture.grey = 0;
        for (std::size_t begin = 0; begin < screen.height; begin += band) {
            const std::size_t end = std::min<std::size_t>(screen.height, begin + band);
            sheet_.restart(screen.width, begin, end, screen.levels == 2 ? Coverage::centre : Coverage::area);
            for (const std::vector<PointMm>& contour : placed_) {
                sheet_.add(contour, std::identity(), map.sign());
            }
            for (std::size_t row = 0; row < end - begin; ++row) {
                deflater.run(1, 0);  // how the row is filtered: it is not
                sheet_.take_runs(row, [&](std::size_t length, double share) {
                    const std::uint8_t grey = grey_of(share, screen.levels - 1);
                    picture.grey += length * grey;
                    deflater.run(length, grey);
                });
            }
        }
        picture.png = png_of(screen, deflater.finish());
    }

private:
    static constexpr std::size_t sheet_bytes = std::size_t{4} << 20;

    /// Halves up, whatever the last bits of a sum.
    static std::uint8_t grey_of(double share, int steps) {
        return static_cast<std::uint8_t>(std::floor(share * steps + 0.5 + 1e-9) * (255.0 / steps));
    }

    CoverageSheet sheet_;
    SolidContours solid_;
    std::vector<std::vector<PointMm>> placed_;
};

enum class Package : std::uint8_t { sl1, sl1s, zip };

template <Package package>
class ScreenWriter final : public LayerWriter {
public:
    ScreenWriter(const LayerFilePlan& plan, OutputFile& out)
        : info_(plan.info),
          screen_(checked(plan)),
          times_(plan.options.times),
          map_(screen_, plan.info),
          zip_(out),
          parallel_(plan.context),
          painters_(static_cast<std::size_t>(parallel_.threads())),
          batch_(layers_a_thread * static_cast<std::size_t>(parallel_.threads())) {}

    void add(const LayerView& layer) override {
        layer_mm_ = layer.top_mm - layer.bottom_mm;
        Picture& picture = batch_[waiting_++];
        picture.contours.assign(layer.contours.begin(), layer.contours.end());
        picture.points.assign(layer.points.begin(), layer.points.end());
        picture.layer = layer;
        picture.layer.contours = picture.contours;
        picture.layer.points = picture.points;
        if (waiting_ == batch_.size()) {
            write_batch();
        }
    }

    void finish() override {
        write_batch();
        const std::string layer = MmFormat().text_of_mm(layer_mm_);
        const std::string width = MmFormat().text_of_mm(screen_.width * screen_.pixel_x_mm);
        const std::string height = MmFormat().text_of_mm(screen_.height * screen_.pixel_y_mm);
        package == Package::zip ? add_manifest(layer, width, height) : add_settings(layer, width, height);
        zip_.finish();
    }

    double rounding_mm() const noexcept override { return 0; }

private:
    static constexpr std::size_t layers_a_thread = 4;  ///< so that none waits long for the last
    static constexpr double area_fill = 50;            ///< layers that cover more than so many percent are printed slowly

    static const Screen& checked(const LayerFilePlan& plan) {
        const PrintTimes& times = plan.options.times;
        const auto is_time = [](double s, double most) { return s >= 0.1 && s <= most; };
        const auto refuse_if = [&](bool wrong, const std::string& why) {
            if (wrong) {
                throw Refused{{ErrorCode::invalid_argument, "'" + plan.name + "': " + why}};
            }
        };
        refuse_if(!plan.options.screen, "no screen says how many pixels there are");
        const Status fits = check_fit(*plan.options.screen, plan.info);
        refuse_if(!fits, fits ? "" : fits.error().message);
        if (package != Package::zip) {
            refuse_if(plan.info.layers > 100'000, "more than 100000 layers, which an SL1 file has no numbers for");
            refuse_if(!is_time(times.exposure_s, 60) || !is_time(times.first_exposure_s, 120),
                      "an SL1 lights layers for 0.1 to 60 s, the first one for up to 120 s");
        }
        return *plan.options.screen;
    }

    void write_batch() {
        parallel_.run(waiting_, [this](std::size_t index, int worker) {
            painters_[static_cast<std::size_t>(worker)].paint(batch_[index], info_, screen_, map_);
        });
        for (std::size_t i = 0; i < waiting_; ++i, ++layers_) {
            const std::string number = std::to_string(layers_ + (package == Package::zip ? 1 : 0));
            const std::size_t zeros = package == Package::zip ? 0 : 5 - number.size();
            zip_.add((package == Package::zip ? "" : "JOB") + std::string(zeros, '0') + number + ".png", batch_[i].png);
            const double pixels = static_cast<double>(batch_[i].grey) / 255;
            slow_ += pixels > area_fill / 100 * screen_.width * screen_.height ? 1 : 0;
            pixels_ += pixels;
        }
        waiting_ = 0;
    }

    /// What Prusa's printers, PrusaSlicer's importer and UVtools read. Keys ascend. The picture is turned already, hence
    /// landscape, which readers do not turn again.
    void add_settings(const std::string& layer, const std::string& width, const std::string& height) {
        const std::string model = package == Package::sl1 ? "SL1" : "SL1S";
        const std::string time = exact_text(times_.exposure_s);
        const std::string first_time = exact_text(times_.first_exposure_s);
        const double ml = std::round(pixels_ * screen_.pixel_x_mm * screen_.pixel_y_mm * layer_mm_) / 1000;
        zip_.add("config.ini", "action = print\nexpTime = " + time + "\nexpTimeFirst = " + first_time +
                                   "\nexpUserProfile = 0\nhollow = 0\njobDir = JOB\nlayerHeight = " + layer +
                                   "\nlayerHeightFirst = " + layer +
                                   "\nnumFade = 10\nnumFast = " + std::to_string(layers_ - slow_) +
                                   "\nnumSlow = " + std::to_string(slow_) + "\nprinterModel = " + model +
                                   "\nprinterVariant = default\nusedMaterial = " + exact_text(ml) + "\n");
        zip_.add("prusaslicer.ini",
                 "area_fill = " + exact_text(area_fill) + "\nbed_shape = 0x0," + width + "x0," + width + "x" + height +
                     ",0x" + height + "\nbottle_volume = 1000\ndisplay_height = " + height + "\ndisplay_mirror_x = " +
                     (screen_.mirror_x ? "1" : "0") + "\ndisplay_mirror_y = " + (screen_.mirror_y ? "1" : "0") +
                     "\ndisplay_orientation = landscape\ndisplay_pixels_x = " + std::to_string(screen_.width) +
                     "\ndisplay_pixels_y = " + std::to_string(screen_.height) + "\ndisplay_width = " + width +
                     "\nexposure_time = " + time +
                     "\nfaded_layers = 10\ngamma_correction = " + (screen_.levels == 2 ? "0" : "1") +
                     "\ninitial_exposure_time = " + first_time + "\ninitial_layer_height = " + layer +
                     "\nlayer_height = " + layer + "\nmaterial_notes = \nmax_print_height = 150\nprinter_model = " + model +
                     "\nprinter_notes = \nprinter_settings_id = Original Prusa " + model +
                     "\nprinter_technology = SLA\nprinter_variant = default\n");
    }

    /// "Generic / Phrozen Zip" of UVtools.
    void add_manifest(const std::string& layer, const std::string& width, const std::string& height) {
        zip_.add(
            "manifest.uvtools",
            "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Manifest>\n  <CreatedBy>lamella</CreatedBy>\n  <LayerHeight>" +
                layer + "</LayerHeight>\n  <ResolutionX>" + std::to_string(screen_.width) +
                "</ResolutionX>\n  <ResolutionY>" + std::to_string(screen_.height) + "</ResolutionY>\n  <DisplayWidth>" +
                width + "</DisplayWidth>\n  <DisplayHeight>" + height + "</DisplayHeight>\n</Manifest>\n");
    }

    const SliceInfo& info_;
    const Screen screen_;
    const PrintTimes times_;
    const ScreenMap map_;
    ZipWriter zip_;
    const Parallel parallel_;
    PerWorker<Painter> painters_;
    std::vector<Picture> batch_;
    std::size_t waiting_ = 0;   ///< layers in batch_
    std::uint64_t layers_ = 0;  ///< written
    std::uint64_t slow_ = 0;    ///< of these
    double pixels_ = 0;         ///< white ones in them
    double layer_mm_ = 0;
};

}  // namespace

Status check_fit(const Screen& screen, const SliceInfo& info) noexcept {
    return guarded([&]() -> Status {
        if (!is_screen(screen)) {
            return Error{
                ErrorCode::invalid_argument,
                "the screen is not of 1 to 65535 pixels a side, 0.0001 to 1000 mm each, turned by 0, 90, 180 or 270 "
                "degrees, with 2, 16 or 256 levels"};
        }
        const ScreenMap map(screen, info);
        const double grown = std::max(0.0, info.options.region.offset_mm);
        const PointMm a = map.from_mm(info.box.min_mm[0] - grown, info.box.min_mm[1] - grown);
        const PointMm b = map.from_mm(info.box.max_mm[0] + grown, info.box.max_mm[1] + grown);
        std::string words;
        const auto look = [&words](double from, double to, double pixels, double pixel_mm, const char* axis) {
            const double over = std::max(0.0, -std::min(from, to)) + std::max(0.0, std::max(from, to) - pixels);
            if (over > 1e-3 && words.empty()) {
                words = "the mesh reaches " + MmFormat().text_of_mm(over * pixel_mm) + " mm beyond the screen in " + axis +
                        ", where it is " + MmFormat().text_of_mm(std::abs(to - from) * pixel_mm) +
                        " mm long and the screen " + MmFormat().text_of_mm(pixels * pixel_mm) + " mm";
            }
        };
        look(a.x, b.x, screen.width, screen.pixel_x_mm, "x");
        look(a.y, b.y, screen.height, screen.pixel_y_mm, "y");
        return words.empty() ? Status() : Error{ErrorCode::invalid_argument, words};
    });
}

std::unique_ptr<LayerWriter> make_sl1(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<ScreenWriter<Package::sl1>>(plan, out);
}

std::unique_ptr<LayerWriter> make_sl1s(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<ScreenWriter<Package::sl1s>>(plan, out);
}

std::unique_ptr<LayerWriter> make_png_zip(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<ScreenWriter<Package::zip>>(plan, out);
}

}  // namespace lamella
