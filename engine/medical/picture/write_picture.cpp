#include "lamella/medical/picture.hpp"

#include "base/parallel.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/picture/page.hpp"
#include "medical/raster/coverage.hpp"

namespace lamella {

namespace {

constexpr int most_cells = 4096;

void require_that(bool holds, const std::string& what) {
    if (!holds) {
        throw Refused{{ErrorCode::invalid_argument, what}};
    }
}

void require_drawable(std::span<const PicturePart> parts, const std::filesystem::path& path, const PictureOptions& options) {
    const std::string size =
        "a picture of " + std::to_string(options.width) + " x " + std::to_string(options.height) + " pixels";
    require_that(can_write_pictures(),
                 "cannot write '" + path.string() + "': this build of lamella is without PNG (libpng-dev)");
    for (const int side : {options.width, options.height}) {
        require_that(
            side >= least_picture_side && side <= largest_picture_side,
            size + ": a side has " + std::to_string(least_picture_side) + " to " + std::to_string(largest_picture_side));
    }
    require_that(std::int64_t{options.width} * options.height <= most_picture_pixels, size + " is larger than 2^26");
    require_that(!parts.empty() &&
                     std::all_of(parts.begin(), parts.end(), [](const PicturePart& part) { return part.result != nullptr; }),
                 "a picture shows one mesh or more, each with its result");
    require_that(options.layers >= 1 && options.layers <= most_cells,
                 "a contact sheet shows 1 to " + std::to_string(most_cells) + " layers");
}

/// A part's layer at a height.
struct DrawnLayer {
    const SliceResult* result = nullptr;
    std::uint64_t layer = 0;
    Colour colour{};
};

/// The layers of the parts that have one at a height, and where on a canvas they are drawn.
struct Drawing {
    double height_mm = 0;
    std::vector<DrawnLayer> layers{};
    Rectangle area{};
};

/// The layer whose slab holds the height, of two the one that is nearer.
std::optional<std::uint64_t> layer_at(const SliceResult& result, double height_mm) noexcept {
    const Layer* const above = std::lower_bound(result.layers.begin(), result.layers.end(), height_mm,
                                                [](const Layer& layer, double height) { return layer.plane_mm < height; });
    const auto distance = [height_mm](const Layer& layer) { return std::abs(layer.plane_mm - height_mm); };
    const Layer* nearest = nullptr;
    for (const Layer* layer = above - (above == result.layers.begin() ? 0 : 1);
         layer != result.layers.end() && layer <= above; ++layer) {
        const bool holds = layer->plane_mm == height_mm || (layer->bottom_mm <= height_mm && height_mm <= layer->top_mm);
        if (holds && (nearest == nullptr || distance(*layer) <= distance(*nearest))) {
            nearest = layer;
        }
    }
    return nearest != nullptr ? std::optional(static_cast<std::uint64_t>(nearest - result.layers.data())) : std::nullopt;
}

Drawing drawing_at(std::span<const PicturePart> parts, double height_mm) {
    Drawing drawing{.height_mm = height_mm};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (const std::optional<std::uint64_t> layer = layer_at(*parts[i].result, height_mm)) {
            drawing.layers.push_back({parts[i].result, *layer, colour_of_part(i)});
        }
    }
    return drawing;
}

/// The heights of all parts' planes, ascending.
std::vector<double> all_heights(std::span<const PicturePart> parts) {
    std::vector<double> heights;
    for (const PicturePart& part : parts) {
        const auto middle = static_cast<std::ptrdiff_t>(heights.size());
        for (const Layer& layer : part.result->layers) {
            heights.push_back(layer.plane_mm);
        }
        std::inplace_merge(heights.begin(), heights.begin() + middle, heights.end());
        heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    }
    return heights;
}

/// Each from the middle of one of `count` equal shares.
std::vector<Drawing> evenly_spaced(std::span<const PicturePart> parts, std::size_t count) {
    const std::vector<double> heights = all_heights(parts);
    const std::size_t cells = std::min(count, heights.size());
    std::vector<Drawing> all;
    for (std::size_t i = 0; i < cells; ++i) {
        all.push_back(drawing_at(parts, heights[(2 * i + 1) * heights.size() / (2 * cells)]));
    }
    return all;
}

/// Around the meshes, and around all that is drawn, which rules may have moved beyond them.
BoxMm box_of(std::span<const PicturePart> parts, const std::vector<Drawing>& drawings) {
    BoxMm box;
    for (const PicturePart& part : parts) {
        const Box& own = part.result->info.box;
        if (own.min_mm[0] < own.max_mm[0] && own.min_mm[1] < own.max_mm[1]) {
            box.widen({own.min_mm[0], own.min_mm[1]});
            box.widen({own.max_mm[0], own.max_mm[1]});
        }
    }
    for (const Drawing& drawing : drawings) {
        for (const DrawnLayer& drawn : drawing.layers) {
            const LayerView layer = (*drawn.result)[drawn.layer];
            for (const Point& point : layer.points) {
                box.widen(layer.to_mm(point));
            }
        }
    }
    if (box.width() < 0) {
        return {{0, 0}, {1, 1}};
    }
    // A line still has a width to be drawn in.
    const double least = std::max(1e-3 * std::max(box.width(), box.height()), 1e-9);
    for (double PointMm::*axis : {&PointMm::x, &PointMm::y}) {
        if (box.max.*axis - box.min.*axis < least) {
            box.min.*axis -= least / 2;
            box.max.*axis += least / 2;
        }
    }
    return box;
}

/// As many decimals as tell the heights exactly; where more than three would be needed, three.
int decimals_of(const std::vector<double>& heights) noexcept {
    int decimals = 0;
    double factor = 1;
    const auto told = [&](double height) { return std::abs(std::round(height * factor) - height * factor) < 1e-4 * factor; };
    for (; decimals < 3 && !std::all_of(heights.begin(), heights.end(), told); ++decimals) {
        factor *= 10;
    }
    return decimals;
}

/// The height of each; of an image's slices in the patient, and along which axis.
std::vector<std::string> labels_of(const std::vector<Drawing>& drawings, const ImageGeometry* image) {
    static constexpr std::array<const char*, 3> axes = {"L ", "P ", "S "};
    std::vector<double> heights(drawings.size());
    std::transform(drawings.begin(), drawings.end(), heights.begin(), [image](const Drawing& drawing) {
        return image != nullptr ? image->height_lps_mm(drawing.height_mm) : drawing.height_mm;
    });
    const int decimals = decimals_of(heights);
    std::vector<std::string> labels(heights.size());
    std::transform(heights.begin(), heights.end(), labels.begin(), [&](double height) {
        return (image != nullptr ? axes[image->slice_axis()] : "") + decimal_text(height, decimals) + " mm";
    });
    return labels;
}

/// Counts all layers, drawn or not.
std::uint64_t layers_with_open_polylines(std::span<const PicturePart> parts) {
    std::uint64_t count = 0;
    for (const PicturePart& part : parts) {
        // The area of a layer with open contours is not known.
        count += static_cast<std::uint64_t>(std::count_if(
            part.result->begin(), part.result->end(), [](const LayerView& layer) { return std::isnan(layer.area_mm2()); }));
    }
    return count;
}

PictureOptions oriented(PictureOptions options) {
    if (options.image != nullptr) {
        const NearestAxis x = nearest_axis(options.image->axes[0]);
        const NearestAxis y = nearest_axis(options.image->axes[1]);
        options.x_leftward = x.negative;
        options.y_downward = y.axis == 2 ? y.negative : !y.negative;
    }
    return options;
}

/// Parts of a pixel that points are rounded to: a side of largest_picture_side pixels stays within 2^27.
constexpr double fractions = 4096;
constexpr double per_fraction[2] = {1 / fractions, 1 / fractions};

/// Overlaps show, and so does which part is the later one.
constexpr double opacity_over_others = 0.75;

/// The sheet counts from the centre of its first pixel.
Point fine(PointMm pixels) noexcept {
    return {static_cast<std::int32_t>(std::lround((pixels.x - 0.5) * fractions)),
            static_cast<std::int32_t>(std::lround((pixels.y - 0.5) * fractions))};
}

/// Rows of one drawing, so few that a sheet of them takes some MB.
struct Strip {
    const Drawing* drawing = nullptr;
    int begin = 0;
    int end = 0;
};

std::vector<Strip> strips_of(const std::vector<Drawing>& drawings) {
    constexpr int most_pixels = 1 << 18;
    std::vector<Strip> strips;
    for (const Drawing& drawing : drawings) {
        const int rows = std::max(1, most_pixels / drawing.area.width);
        for (int begin = 0; begin < drawing.area.height; begin += rows) {
            strips.push_back({&drawing, begin, std::min(drawing.area.height, begin + rows)});
        }
    }
    return strips;
}

/// Draws strips of layers: the box lies in the middle of each drawing's area. One a thread.
class LayerBrush {
public:
    LayerBrush(Canvas& canvas, const Page& page, const BoxMm& box, const PictureOptions& options)
        : canvas_(canvas),
          x_scale_(options.x_leftward ? -page.pixels_per_mm() : page.pixels_per_mm()),
          y_scale_(options.y_downward ? page.pixels_per_mm() : -page.pixels_per_mm()),
          middle_{box.min.x + 0.5 * box.width(), box.min.y + 0.5 * box.height()},
          line_width_(1.5 * page.unit()) {}

    void draw(const Strip& strip) {
        strip_ = strip;
        const Rectangle& area = strip.drawing->area;
        shift_ = {0.5 * area.width - x_scale_ * middle_.x, 0.5 * area.height - y_scale_ * middle_.y};
        sheet_.restart(static_cast<std::size_t>(area.width), static_cast<std::size_t>(strip.begin),
                       static_cast<std::size_t>(strip.end));
        shares_.resize(static_cast<std::size_t>(area.width));
        for (const DrawnLayer& drawn : strip.drawing->layers) {
            add_filled(drawn);
            mix_rows(drawn.colour, opacity_over_others);
        }
        bool open = false;
        for (const DrawnLayer& drawn : strip.drawing->layers) {
            open = add_open(drawn) || open;
        }
        if (open) {
            mix_rows(colours::open, 1);
        }
    }

private:
    PointMm pixels(const SliceResult& result, const Point& point) const noexcept {
        const PointMm mm = result.to_mm(point);
        return {x_scale_ * mm.x + shift_.x, y_scale_ * mm.y + shift_.y};
    }

    void add_filled(const DrawnLayer& drawn) {
        for (const std::span<const Point> points : solid_.of(*drawn.result, drawn.layer)) {
            contour_.clear();
            for (const Point& point : points) {
                contour_.push_back(fine(pixels(*drawn.result, point)));
            }
            if (x_scale_ * y_scale_ < 0) {  // what was counter-clockwise is clockwise on the picture
                std::reverse(contour_.begin(), contour_.end());
            }
            sheet_.add(contour_, per_fraction);
        }
    }

    /// Returns whether there was any.
    bool add_open(const DrawnLayer& drawn) {
        bool any = false;
        for (const Contour& contour : drawn.result->contours_of(drawn.result->layers[drawn.layer])) {
            const std::span<const Point> points = drawn.result->points_of(contour);
            for (std::size_t i = 1; contour.role == Role::open && i < points.size(); ++i) {
                any = true;
                add_line(pixels(*drawn.result, points[i - 1]), pixels(*drawn.result, points[i]));
            }
        }
        return any;
    }

    /// A counter-clockwise rectangle about the line, half a width longer at both ends.
    void add_line(PointMm from, PointMm to) {
        const double half = line_width_ / 2;
        const double length = std::sqrt((to.x - from.x) * (to.x - from.x) + (to.y - from.y) * (to.y - from.y));
        const double x = length > 0 ? half * (to.x - from.x) / length : half;
        const double y = length > 0 ? half * (to.y - from.y) / length : 0;
        const std::array<Point, 4> corners = {fine({from.x - x + y, from.y - y - x}), fine({to.x + x + y, to.y + y - x}),
                                              fine({to.x + x - y, to.y + y + x}), fine({from.x - x - y, from.y - y + x})};
        sheet_.add(corners, per_fraction);
    }

    /// `over_others`: the opacity where something else than the background is.
    void mix_rows(Colour colour, double over_others) {
        const Rectangle& area = strip_.drawing->area;
        for (int row = strip_.begin; row < strip_.end; ++row) {
            std::fill(shares_.begin(), shares_.end(), 0.0);
            sheet_.take_row(static_cast<std::size_t>(row - strip_.begin), shares_);
            for (int column = 0; column < area.width; ++column) {
                if (const double share = shares_[static_cast<std::size_t>(column)]; share > 0) {
                    const int x = area.x + column;
                    const int y = area.y + row;
                    canvas_.mix(x, y, colour, canvas_.has(x, y, colours::cell) ? share : over_others * share);
                }
            }
        }
    }

    Canvas& canvas_;
    double x_scale_;  ///< pixels in a mm
    double y_scale_;
    PointMm middle_;     ///< of the box
    double line_width_;  ///< of open polylines, pixels
    Strip strip_;
    PointMm shift_{};
    CoverageSheet sheet_;
    SolidContours solid_;
    std::vector<Point> contour_;  ///< in fractions of a pixel
    std::vector<double> shares_;  ///< of a row
};

Status draw(std::span<const PicturePart> parts, std::vector<Drawing> drawings, const std::filesystem::path& path,
            const PictureOptions& asked, const Context& context) {
    const PictureOptions options = oriented(asked);
    const std::vector<std::string> labels = labels_of(drawings, options.image);
    int label_width = 0;
    for (const std::string& label : labels) {
        label_width = std::max(label_width, text_width(label, 1));
    }
    const BoxMm box = box_of(parts, drawings);
    const Page page(box, std::max<std::size_t>(1, drawings.size()), label_width, options);
    const Parallel parallel(context);
    parallel.begin_stage(0.8);
    Canvas canvas(page.width(), page.height(), colours::page);
    std::vector<std::string> names;
    for (const PicturePart& part : parts) {
        names.push_back(part.name);
    }
    page.draw_heading(canvas, names, layers_with_open_polylines(parts));
    if (drawings.empty()) {
        page.draw_cell(canvas, 0, "no layers");
    }
    for (std::size_t i = 0; i < drawings.size(); ++i) {
        page.draw_cell(canvas, i, labels[i]);
        drawings[i].area = page.area(i);
    }
    const std::vector<Strip> strips = strips_of(drawings);
    std::vector<LayerBrush> brushes;
    for (std::size_t worker = 0; worker < parallel.workers_for(strips.size()); ++worker) {
        brushes.emplace_back(canvas, page, box, options);
    }
    parallel.run(strips.size(),
                 [&](std::size_t i, int worker) { brushes[static_cast<std::size_t>(worker)].draw(strips[i]); });
    parallel.stop_if_asked();
    Status written = canvas.write_png(path);
    if (written) {
        parallel.finish();
    }
    return written;
}

}  // namespace

Status write_layer_picture(std::span<const PicturePart> parts, std::uint64_t layer, const std::filesystem::path& path,
                           const PictureOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        require_drawable(parts, path, options);
        const SliceResult& first = *parts.front().result;
        require_that(layer >= first.info.first_layer && layer - first.info.first_layer < first.layers.size(),
                     "'" + parts.front().name + "' has no layer " + std::to_string(layer) + ": it has " +
                         std::to_string(first.layers.size()) + ", counted from " + std::to_string(first.info.first_layer));
        return draw(parts, {drawing_at(parts, first.layers[layer - first.info.first_layer].plane_mm)}, path, options,
                    context);
    });
}

Status write_contact_sheet(std::span<const PicturePart> parts, const std::filesystem::path& path,
                           const PictureOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        require_drawable(parts, path, options);
        return draw(parts, evenly_spaced(parts, static_cast<std::size_t>(options.layers)), path, options, context);
    });
}

}  // namespace lamella
