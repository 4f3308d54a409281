#include "lamella/medical/picture.hpp"

#include <charconv>
#include <limits>
#include <optional>
#include <string>

#include "base/parallel.hpp"
#include "base/words.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/picture/canvas.hpp"
#include "medical/raster/coverage.hpp"

namespace lamella {

namespace {

constexpr int most_cells = 4096;
constexpr Colour page_colour{0xff, 0xff, 0xff};
constexpr Colour cell_colour{0xf1, 0xf3, 0xf5};
constexpr Colour text_colour{0x2b, 0x30, 0x36};
constexpr Colour open_colour{0xd8, 0x1b, 0x1b};

/// Colours repeat after twelve parts.
Colour colour_of_part(std::size_t part) noexcept {
    // clang-format off
    static constexpr std::array<Colour, 12> palette = {{
        {0x1f, 0x6f, 0xb4}, {0xf2, 0x8e, 0x2b}, {0x2a, 0x9d, 0x5c}, {0x8e, 0x5b, 0xb5}, {0xe5, 0xb8, 0x13}, {0x17, 0xa2, 0xb8},
        {0xe3, 0x77, 0xa8}, {0x8c, 0x62, 0x45}, {0x9a, 0xb9, 0x3a}, {0x3d, 0x48, 0x9c}, {0x7a, 0x86, 0x92}, {0x0b, 0x5d, 0x4e}}};
    // clang-format on
    return palette[part % palette.size()];
}

void require_that(bool holds, const std::string& what) {
    if (!holds) {
        throw Refused{{ErrorCode::invalid_argument, what}};
    }
}

std::string size_text(const PictureOptions& options) {
    return "a picture of " + std::to_string(options.width) + " x " + std::to_string(options.height) + " pixels";
}

void require_drawable(std::span<const PicturePart> parts, const std::filesystem::path& path, const PictureOptions& options) {
    require_that(can_write_pictures(),
                 "cannot write '" + path.string() + "': this build of lamella is without PNG (libpng-dev)");
    for (const int side : {options.width, options.height}) {
        require_that(side >= least_picture_side && side <= largest_picture_side,
                     size_text(options) + ": a side has " + std::to_string(least_picture_side) + " to " +
                         std::to_string(largest_picture_side));
    }
    require_that(std::int64_t{options.width} * options.height <= most_picture_pixels,
                 size_text(options) + " is larger than 2^26");
    require_that(!parts.empty() &&
                     std::all_of(parts.begin(), parts.end(), [](const PicturePart& part) { return part.result != nullptr; }),
                 "a picture shows one mesh or more, each with its result");
    require_that(options.layers >= 1 && options.layers <= most_cells,
                 "a contact sheet shows 1 to " + std::to_string(most_cells) + " layers");
}

/// With so many decimals, without a sign where it rounds to zero.
std::string decimal_text(double value, int decimals) {
    std::array<char, 400> text{};
    const auto [end, error] =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals);
    std::string all(text.data(), end);
    return all.find_first_not_of("-0.") == std::string::npos && all.front() == '-' ? all.substr(1) : all;
}

// --- what is drawn

/// The layers at one height, and where on the canvas they are drawn.
struct Cell {
    double height_mm = 0;
    std::vector<LayerView> layers{};  ///< of each part: empty where it has none there
    Rectangle area{};
};

/// The layer of each part whose slab holds the height, of several the one that is nearest.
Cell cell_at(std::span<const PicturePart> parts, double height_mm) {
    Cell cell{.height_mm = height_mm};
    cell.layers.resize(parts.size());
    for (std::size_t part = 0; part < parts.size(); ++part) {
        const SliceResult& result = *parts[part].result;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < result.layers.size(); ++i) {
            const Layer& layer = result.layers[i];
            const double distance = std::abs(layer.plane_mm - height_mm);
            const bool holds = distance == 0 || (layer.bottom_mm <= height_mm && height_mm <= layer.top_mm);
            if (holds && distance <= least) {
                least = distance;
                cell.layers[part] = result[i];
            }
        }
    }
    return cell;
}

/// Of all parts' heights, each from the middle of one of `count` equal shares.
std::vector<Cell> evenly_spaced(std::span<const PicturePart> parts, std::size_t count) {
    std::vector<double> heights;
    for (const PicturePart& part : parts) {
        for (const Layer& layer : part.result->layers) {
            heights.push_back(layer.plane_mm);
        }
    }
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    std::vector<Cell> cells(std::min(count, heights.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) {
        cells[i] = cell_at(parts, heights[(2 * i + 1) * heights.size() / (2 * cells.size())]);
    }
    return cells;
}

/// In mm, in the frame of the slicing; empty at first.
struct BoxMm {
    PointMm min{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    PointMm max{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    double width() const noexcept { return max.x - min.x; }
    double height() const noexcept { return max.y - min.y; }
    void widen(PointMm at) noexcept {
        min = {std::min(min.x, at.x), std::min(min.y, at.y)};
        max = {std::max(max.x, at.x), std::max(max.y, at.y)};
    }
};

/// Around the meshes, and around all that is drawn, which rules may have moved beyond them.
BoxMm box_of(std::span<const PicturePart> parts, const std::vector<Cell>& cells) {
    BoxMm box;
    for (const PicturePart& part : parts) {
        const Box& own = part.result->info.box;
        if (own.min_mm[0] < own.max_mm[0] && own.min_mm[1] < own.max_mm[1]) {
            box.widen({own.min_mm[0], own.min_mm[1]});
            box.widen({own.max_mm[0], own.max_mm[1]});
        }
    }
    for (const Cell& cell : cells) {
        for (const LayerView& layer : cell.layers) {
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

/// The height of each, with as many decimals as tell them all, at most three; of an image's slices in the patient, and along
/// which axis.
std::vector<std::string> labels_of(const std::vector<Cell>& cells, const ImageGeometry* image) {
    static constexpr std::array<const char*, 3> axes = {"L ", "P ", "S "};
    std::vector<std::string> labels(cells.size());
    std::size_t idle = 4;  // zeros at the end of all, and the point before three of them
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const double height_mm = cells[i].height_mm;
        labels[i] = decimal_text(image != nullptr ? image->height_lps_mm(height_mm) : height_mm, 3);
        const std::size_t zeros = labels[i].size() - 1 - labels[i].find_last_not_of('0');
        idle = std::min(idle, zeros < 3 ? zeros : 4);
    }
    for (std::string& label : labels) {
        label = (image != nullptr ? axes[image->slice_axis()] : "") + label.substr(0, label.size() - idle) + " mm";
    }
    if (cells.empty()) {
        labels.emplace_back("no layers");
    }
    return labels;
}

// --- where it is drawn

/// Cells of one size in rows, below a line with names and scale.
class Page {
public:
    /// Chooses the number of columns that gives the largest scale. Throws Refused where the cells would be too small.
    Page(const BoxMm& box, const std::vector<std::string>& labels, const PictureOptions& options) {
        unit_ = std::max(1, std::min(options.width, options.height) / 600);
        gap_ = 4 * unit_;
        label_height_ = text_height(unit_) + gap_;
        const auto count = static_cast<int>(labels.size());
        int rows = 1;
        for (int columns = 1; columns <= count; ++columns) {
            const int rows_then = (count + columns - 1) / columns;
            const int width = (options.width - gap_ * (columns + 1)) / columns;
            const int height = (options.height - label_height_ - gap_ - gap_ * rows_then) / rows_then;
            const double scale =
                std::min((width - 2 * gap_) / box.width(), (height - label_height_ - 2 * gap_) / box.height());
            if (columns == 1 || scale > pixels_per_mm_) {
                pixels_per_mm_ = scale;
                columns_ = columns;
                rows = rows_then;
                cell_width_ = width;
                cell_height_ = height;
            }
        }
        constexpr int least_pixels = 16;  // the narrowest that still shows something
        require_that(pixels_per_mm_ * std::max(box.width(), box.height()) >= least_pixels,
                     size_text(options) + " has no room for " + counted(labels.size(), "layer"));
        const auto around = [&](double mm) { return static_cast<int>(std::ceil(mm * pixels_per_mm_)) + 2 * gap_; };
        int wanted_width = around(box.width());
        for (const std::string& label : labels) {
            wanted_width = std::max(wanted_width, text_width(label, unit_) + 2 * gap_);
        }
        cell_width_ = std::min(cell_width_, wanted_width);
        cell_height_ = std::min(cell_height_, around(box.height()) + label_height_);
        // A few narrow cells leave room for the names.
        width_ = std::max(gap_ + columns_ * (cell_width_ + gap_), std::min(options.width, 200 * unit_));
        height_ = label_height_ + gap_ + rows * (cell_height_ + gap_);
    }

    Canvas canvas() const { return {width_, height_, page_colour}; }
    double line_width() const noexcept { return 1.5 * unit_; }  ///< of open polylines, pixels
    double pixels_per_mm() const noexcept { return pixels_per_mm_; }

    /// Draws a cell and its label. Returns the part of it that the layer is drawn into.
    Rectangle draw_cell(Canvas& canvas, std::size_t i, const std::string& label) const {
        const int x = gap_ + static_cast<int>(i) % columns_ * (cell_width_ + gap_);
        const int y = label_height_ + gap_ + static_cast<int>(i) / columns_ * (cell_height_ + gap_);
        canvas.fill({x, y, cell_width_, cell_height_}, cell_colour);
        canvas.write(x + gap_, y + gap_, label, unit_, text_colour);
        return {x + 1, y + label_height_, cell_width_ - 2, cell_height_ - label_height_ - 1};
    }

    /// One line: a coloured square and the name of each part as far as they go, how many layers have open polylines
    /// if any, and a bar of a round length.
    void draw_heading(Canvas& canvas, std::span<const PicturePart> parts) const {
        const int end = draw_scale(canvas) - gap_;
        const int square = text_height(unit_);
        int x = gap_;
        // Returns whether there was room.
        const auto entry = [&](std::string_view name, Colour colour, int mark_height, int left_over) {
            const int width = square + 2 * unit_ + text_width(name, unit_) + 2 * gap_;
            if (x + width + left_over > end) {
                return false;
            }
            canvas.fill({x, gap_ + (square - mark_height) / 2, square, mark_height}, colour);
            canvas.write(x + square + 2 * unit_, gap_, name, unit_, text_colour);
            x += width;
            return true;
        };
        std::uint64_t open_layers = 0;  // drawn or not
        for (const PicturePart& part : parts) {
            for (const LayerView layer : *part.result) {
                open_layers += std::isnan(layer.area_mm2()) ? 1U : 0U;  // it is not known where there is one
            }
        }
        if (open_layers > 0) {
            entry("open in " + counted(open_layers, "layer"), open_colour, 2 * unit_, 0);
        }
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const std::string rest = "+" + std::to_string(parts.size() - i);
            const int left_over = i + 1 < parts.size() ? text_width(rest, unit_) : 0;
            if (!entry(parts[i].name, colour_of_part(i), square, left_over)) {
                if (x + text_width(rest, unit_) <= end) {
                    canvas.write(x, gap_, rest, unit_, text_colour);
                }
                return;
            }
        }
    }

private:
    /// A bar of 1, 2, 5, 10, 20, ... mm, as long as there is room. Returns where it begins.
    int draw_scale(Canvas& canvas) const {
        const double most_mm = std::min(0.5 * cell_width_, 0.25 * width_) / pixels_per_mm_;
        const double exponent = std::floor(std::log10(most_mm));
        const double step = std::pow(10, exponent);
        const double length_mm = step * (5 * step <= most_mm ? 5 : 2 * step <= most_mm ? 2 : 1);
        const std::string text = decimal_text(length_mm, static_cast<int>(std::clamp(-exponent, 0.0, 9.0))) + " mm";
        const int length = std::max(1, static_cast<int>(std::lround(length_mm * pixels_per_mm_)));
        const int right = width_ - gap_ - text_width(text, unit_);
        const int left = right - 2 * unit_ - length;
        const int middle = gap_ + text_height(unit_) / 2;
        canvas.write(right, gap_, text, unit_, text_colour);
        canvas.fill({left, middle - unit_ / 2, length, unit_}, text_colour);
        for (const int end : {left, left + length - unit_}) {
            canvas.fill({end, middle - 2 * unit_, unit_, 4 * unit_}, text_colour);
        }
        return left;
    }

    int unit_ = 1;  ///< pixels of a dot of the font
    int gap_ = 0;
    int label_height_ = 0;
    int columns_ = 1;
    int cell_width_ = 0;
    int cell_height_ = 0;
    int width_ = 0;
    int height_ = 0;
    double pixels_per_mm_ = 0;
};

// --- drawing

/// Rows of one cell, so few that a sheet of them takes some MB.
struct Strip {
    const Cell* cell = nullptr;
    int begin = 0;
    int end = 0;
};

std::vector<Strip> strips_of(const std::vector<Cell>& cells) {
    constexpr int most_pixels = 1 << 18;
    std::vector<Strip> strips;
    for (const Cell& cell : cells) {
        const int rows = std::max(1, most_pixels / cell.area.width);
        for (int begin = 0; begin < cell.area.height; begin += rows) {
            strips.push_back({&cell, begin, std::min(cell.area.height, begin + rows)});
        }
    }
    return strips;
}

/// Draws strips of cells: the box lies in the middle of each cell's area. One a thread.
class LayerBrush {
public:
    LayerBrush(Canvas& canvas, std::span<const PicturePart> parts, const Page& page, const BoxMm& box,
               const PictureOptions& options)
        : canvas_(canvas),
          parts_(parts),
          scale_{options.x_leftward ? -page.pixels_per_mm() : page.pixels_per_mm(),
                 options.y_downward ? page.pixels_per_mm() : -page.pixels_per_mm()},
          middle_{box.min.x + 0.5 * box.width(), box.min.y + 0.5 * box.height()},
          line_width_(page.line_width()) {}

    void draw(const Strip& strip) {
        constexpr double opacity_over_others = 0.75;  // overlaps show, and so does which part is the later one
        const Rectangle& area = strip.cell->area;
        const std::vector<LayerView>& layers = strip.cell->layers;
        const auto pixels = [&](const LayerView& layer, const Point& point) {
            const PointMm mm = layer.to_mm(point);
            return PointMm{scale_.x * (mm.x - middle_.x) + 0.5 * area.width,
                           scale_.y * (mm.y - middle_.y) + 0.5 * area.height};
        };
        sheet_.restart(static_cast<std::size_t>(area.width), static_cast<std::size_t>(strip.begin),
                       static_cast<std::size_t>(strip.end));
        for (std::size_t part = 0; part < layers.size(); ++part) {
            if (layers[part].contours.empty()) {
                continue;
            }
            const double sign = scale_.x * scale_.y < 0 ? -1 : 1;
            for (const std::span<const Point> contour : solid_.of(*parts_[part].result, layers[part].index)) {
                sheet_.add(
                    contour, [&](const Point& point) { return pixels(layers[part], point); }, sign);
            }
            mix_rows(strip, colour_of_part(part), opacity_over_others);
        }
        for (const LayerView& layer : layers) {
            for (const Contour& contour : layer.contours) {
                const std::span<const Point> points = layer.points_of(contour);
                for (std::size_t i = 1; contour.role == Role::open && i < points.size(); ++i) {
                    add_line(pixels(layer, points[i - 1]), pixels(layer, points[i]));
                }
            }
        }
        mix_rows(strip, open_colour, 1);
    }

private:
    /// A counter-clockwise rectangle about the line, half a width longer at both ends.
    void add_line(PointMm from, PointMm to) {
        const double half = line_width_ / 2;
        const double length = std::hypot(to.x - from.x, to.y - from.y);
        const double x = length > 0 ? half * (to.x - from.x) / length : half;
        const double y = length > 0 ? half * (to.y - from.y) / length : 0;
        const std::array<PointMm, 4> corners = {{{from.x - x + y, from.y - y - x},
                                                 {to.x + x + y, to.y + y - x},
                                                 {to.x + x - y, to.y + y + x},
                                                 {from.x - x - y, from.y - y + x}}};
        sheet_.add(corners, [](PointMm corner) { return corner; });
    }

    /// `over_others`: the opacity where something else than the background is.
    void mix_rows(const Strip& strip, Colour colour, double over_others) {
        const Rectangle& area = strip.cell->area;
        for (int row = strip.begin; row < strip.end; ++row) {
            shares_.assign(static_cast<std::size_t>(area.width), 0);
            sheet_.take_row(static_cast<std::size_t>(row - strip.begin), shares_);
            for (int column = 0; column < area.width; ++column) {
                if (const double share = shares_[static_cast<std::size_t>(column)]; share > 0) {
                    canvas_.mix(area.x + column, area.y + row, colour, share, cell_colour, over_others);
                }
            }
        }
    }

    Canvas& canvas_;
    std::span<const PicturePart> parts_;
    PointMm scale_;      ///< pixels in a mm, along x and y
    PointMm middle_;     ///< of the box
    double line_width_;  ///< of open polylines, pixels
    CoverageSheet sheet_;
    SolidContours solid_;
    std::vector<double> shares_;  ///< of a row
};

Status draw(std::span<const PicturePart> parts, std::vector<Cell> cells, const std::filesystem::path& path,
            PictureOptions options, const Context& context) {
    if (options.image != nullptr) {
        const NearestAxis x = nearest_axis(options.image->axes[0]);
        const NearestAxis y = nearest_axis(options.image->axes[1]);
        options.x_leftward = x.negative;
        options.y_downward = y.axis == 2 ? y.negative : !y.negative;
    }
    const std::vector<std::string> labels = labels_of(cells, options.image);
    const BoxMm box = box_of(parts, cells);
    const Page page(box, labels, options);
    const Parallel parallel(context);
    parallel.begin_stage(0.8);
    Canvas canvas = page.canvas();
    page.draw_heading(canvas, parts);
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const Rectangle area = page.draw_cell(canvas, i, labels[i]);
        if (i < cells.size()) {
            cells[i].area = area;
        }
    }
    const std::vector<Strip> strips = strips_of(cells);
    std::vector<LayerBrush> brushes;
    brushes.reserve(parallel.workers_for(strips.size()));
    while (brushes.size() < brushes.capacity()) {
        brushes.emplace_back(canvas, parts, page, box, options);
    }
    parallel.run(strips.size(),
                 [&](std::size_t i, int worker) { brushes[static_cast<std::size_t>(worker)].draw(strips[i]); });
    parallel.stop_if_asked();
    canvas.write_png(path);
    parallel.finish();
    return {};
}

}  // namespace

bool can_write_pictures() noexcept {
#ifdef LAMELLA_HAS_PNG
    return true;
#else
    return false;
#endif
}

Status write_layer_picture(std::span<const PicturePart> parts, std::uint64_t layer, const std::filesystem::path& path,
                           const PictureOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        require_drawable(parts, path, options);
        const SliceResult& first = *parts.front().result;
        require_that(layer >= first.info.first_layer && layer - first.info.first_layer < first.layers.size(),
                     "'" + parts.front().name + "' has no layer " + std::to_string(layer) + ": it has " +
                         std::to_string(first.layers.size()) + ", counted from " + std::to_string(first.info.first_layer));
        return draw(parts, {cell_at(parts, first.layers[layer - first.info.first_layer].plane_mm)}, path, options, context);
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
