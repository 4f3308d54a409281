#include "lamella/medical/picture.hpp"

#include <charconv>
#include <functional>
#include <limits>
#include <string>
#include <tuple>

#include "base/parallel.hpp"
#include "base/words.hpp"
#include "io/raster/coverage.hpp"
#include "medical/geometry/common.hpp"
#include "medical/picture/canvas.hpp"
#include "slicing/grid/bounds.hpp"

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
    const auto is_side = [](int side) { return side >= least_picture_side && side <= largest_picture_side; };
    require_that(can_write_pictures(),
                 "cannot write '" + path_text(path) + "': this build of lamella is without PNG (libpng-dev)");
    require_that(is_side(options.width) && is_side(options.height), size_text(options) + ": a side has " +
                                                                        std::to_string(least_picture_side) + " to " +
                                                                        std::to_string(largest_picture_side));
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
struct SheetCell {
    double height_mm = 0;
    std::vector<LayerView> layers{};  ///< of each part: empty where it has none there
    Rectangle area{};
};

/// The layer of each part whose slab holds the height, of several the one that is nearest.
SheetCell cell_at(std::span<const PicturePart> parts, double height_mm) {
    SheetCell cell{.height_mm = height_mm};
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
std::vector<SheetCell> evenly_spaced(std::span<const PicturePart> parts, std::size_t count) {
    std::vector<double> heights;
    for (const PicturePart& part : parts) {
        for (const Layer& layer : part.result->layers) {
            heights.push_back(layer.plane_mm);
        }
    }
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    std::vector<SheetCell> cells(std::min(count, heights.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) {
        cells[i] = cell_at(parts, heights[(2 * i + 1) * heights.size() / (2 * cells.size())]);
    }
    return cells;
}

/// Around the meshes, and around all that is drawn, which rules may have moved beyond them: mm, in the frame of the slicing.
Bounds box_of(std::span<const PicturePart> parts, const std::vector<SheetCell>& cells) {
    Bounds box = Bounds::empty();
    for (const PicturePart& part : parts) {
        const Box& own = part.result->info.box;
        for (int axis = 0; axis < 2 && own.min_mm[0] < own.max_mm[0] && own.min_mm[1] < own.max_mm[1]; ++axis) {
            const auto i = static_cast<std::size_t>(axis);
            box.add(axis, own.min_mm[i], own.max_mm[i]);
        }
    }
    for (const SheetCell& cell : cells) {
        for (const LayerView& layer : cell.layers) {
            for (const Point& point : layer.points) {
                const PointMm at = layer.to_mm(point);
                box.add(0, at.x, at.x);
                box.add(1, at.y, at.y);
            }
        }
    }
    if (box.max_mm[0] < box.min_mm[0]) {
        return {{0, 0, 0}, {1, 1, 0}};
    }
    // A line still has a width to be drawn in.
    const double extent = std::max(box.max_mm[0] - box.min_mm[0], box.max_mm[1] - box.min_mm[1]);
    const double least = std::max(1e-3 * extent, 1e-9);
    for (int axis = 0; axis < 2; ++axis) {
        if (box.max_mm[axis] - box.min_mm[axis] < least) {
            box.add(axis, box.min_mm[axis] - least / 2, box.max_mm[axis] + least / 2);
        }
    }
    return box;
}

/// The height of each, with as many decimals as tell them all, at most three; of an image's slices in the patient, and along
/// which axis.
std::vector<std::string> labels_of(const std::vector<SheetCell>& cells, const ImageGeometry* image) {
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

/// Cells of one size in rows, below a line with names and scale. Lengths are pixels.
struct Page {
    int unit = 1;  ///< a dot of the font
    int gap = 0;
    int label_height = 0;
    int columns = 1;
    int cell_width = 0;
    int cell_height = 0;
    int width = 0;
    int height = 0;
    double per_mm = 0;
    PointMm size{};    ///< of the box, mm
    PointMm middle{};  ///< of the box, mm

    /// With the number of columns that gives the largest scale. Throws Refused where the cells would be too small.
    Page(const Bounds& box, const std::vector<std::string>& labels, const PictureOptions& options)
        : unit(std::max(1, std::min(options.width, options.height) / 600)),
          gap(4 * unit),
          label_height(text_height(unit) + gap),
          size{box.max_mm[0] - box.min_mm[0], box.max_mm[1] - box.min_mm[1]},
          middle{box.min_mm[0] + 0.5 * size.x, box.min_mm[1] + 0.5 * size.y} {
        const auto count = static_cast<int>(labels.size());
        int rows = 1;
        for (int some = 1; some <= count; ++some) {
            const int rows_then = (count + some - 1) / some;
            const int wide = (options.width - gap * (some + 1)) / some;
            const int high = (options.height - label_height - gap - gap * rows_then) / rows_then;
            const double scale = std::min((wide - 2 * gap) / size.x, (high - label_height - 2 * gap) / size.y);
            if (some == 1 || scale > per_mm) {
                std::tie(per_mm, columns, rows, cell_width, cell_height) = std::tuple(scale, some, rows_then, wide, high);
            }
        }
        constexpr int least_pixels = 16;  // the narrowest that still shows something
        require_that(per_mm * std::max(size.x, size.y) >= least_pixels,
                     size_text(options) + " has no room for " + counted(labels.size(), "layer"));
        const auto around = [&](double mm) { return static_cast<int>(std::ceil(mm * per_mm)) + 2 * gap; };
        int wanted_width = around(size.x);
        for (const std::string& label : labels) {
            wanted_width = std::max(wanted_width, text_width(label, unit) + 2 * gap);
        }
        cell_width = std::min(cell_width, wanted_width);
        cell_height = std::min(cell_height, around(size.y) + label_height);
        // A few narrow cells leave room for the names.
        width = std::max(gap + columns * (cell_width + gap), std::min(options.width, 200 * unit));
        height = label_height + gap + rows * (cell_height + gap);
    }

    /// Draws a cell and its label. Returns the part of it that the layer is drawn into.
    Rectangle draw_cell(Canvas& canvas, std::size_t i, const std::string& label) const {
        const int x = gap + static_cast<int>(i) % columns * (cell_width + gap);
        const int y = label_height + gap + static_cast<int>(i) / columns * (cell_height + gap);
        canvas.fill({x, y, cell_width, cell_height}, cell_colour);
        canvas.write(x + gap, y + gap, label, unit, text_colour);
        return {x + 1, y + label_height, cell_width - 2, cell_height - label_height - 1};
    }

    /// One line: a coloured square and the name of each part as far as they go, how many layers have open polylines
    /// if any, and a bar of a round length.
    void draw_heading(Canvas& canvas, std::span<const PicturePart> parts) const {
        const int end = draw_scale(canvas) - gap;
        const int square = text_height(unit);
        int x = gap;
        // Returns whether there was room.
        const auto entry = [&](std::string_view name, Colour colour, int mark_height, int left_over) {
            const int wide = square + 2 * unit + text_width(name, unit) + 2 * gap;
            if (x + wide + left_over > end) {
                return false;
            }
            canvas.fill({x, gap + (square - mark_height) / 2, square, mark_height}, colour);
            canvas.write(x + square + 2 * unit, gap, name, unit, text_colour);
            x += wide;
            return true;
        };
        std::uint64_t open_layers = 0;  // drawn or not
        for (const PicturePart& part : parts) {
            for (const LayerView layer : *part.result) {
                open_layers += std::isnan(layer.area_mm2()) ? 1U : 0U;  // it is not known where there is one
            }
        }
        if (open_layers > 0) {
            entry("open in " + counted(open_layers, "layer"), open_colour, 2 * unit, 0);
        }
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const std::string rest = "+" + std::to_string(parts.size() - i);
            const int left_over = i + 1 < parts.size() ? text_width(rest, unit) : 0;
            if (!entry(parts[i].name, colour_of_part(i), square, left_over)) {
                canvas.write(x, gap, x + text_width(rest, unit) <= end ? rest : "", unit, text_colour);
                return;
            }
        }
    }

    /// A bar of 1, 2, 5, 10, 20, ... mm, as long as there is room. Returns where it begins.
    int draw_scale(Canvas& canvas) const {
        const double most_mm = std::min(0.5 * cell_width, 0.25 * width) / per_mm;
        const double exponent = std::floor(std::log10(most_mm));
        const double step = std::pow(10, exponent);
        const double length_mm = step * (5 * step <= most_mm ? 5 : 2 * step <= most_mm ? 2 : 1);
        const std::string text = decimal_text(length_mm, static_cast<int>(std::clamp(-exponent, 0.0, 9.0))) + " mm";
        const int length = std::max(1, static_cast<int>(std::lround(length_mm * per_mm)));
        const int right = width - gap - text_width(text, unit);
        const int left = right - 2 * unit - length;
        const int middle_height = gap + text_height(unit) / 2;
        canvas.write(right, gap, text, unit, text_colour);
        canvas.fill({left, middle_height - unit / 2, length, unit}, text_colour);
        for (const int end : {left, left + length - unit}) {
            canvas.fill({end, middle_height - 2 * unit, unit, 4 * unit}, text_colour);
        }
        return left;
    }
};

// --- drawing

/// Rows of one cell, so few that a sheet of them takes some MB.
struct Strip {
    const SheetCell* cell = nullptr;
    int begin = 0;
    int end = 0;
};

/// Memory of one thread.
struct Scratch {
    CoverageSheet sheet;
    SolidContours solid;
    std::vector<double> shares;  ///< of a row
};

/// Draws strips of cells: the box lies in the middle of each cell's area.
struct LayerBrush {
    Canvas& canvas;
    std::span<const PicturePart> parts;
    PointMm scale;  ///< pixels in a mm, along x and y
    PointMm middle;
    double line_width;  ///< of open polylines, pixels

    void draw(const Strip& strip, Scratch& scratch) const {
        constexpr double opacity_over_others = 0.75;  // overlaps show, and so does which part is the later one
        const Rectangle& area = strip.cell->area;
        const auto placing = [&](const LayerView& layer) {
            return [&](const Point& point) {
                const PointMm mm = layer.to_mm(point);
                return PointMm{scale.x * (mm.x - middle.x) + 0.5 * area.width,
                               scale.y * (mm.y - middle.y) + 0.5 * area.height};
            };
        };
        scratch.sheet.restart(static_cast<std::size_t>(area.width), static_cast<std::size_t>(strip.begin),
                              static_cast<std::size_t>(strip.end));
        for (std::size_t part = 0; part < parts.size(); ++part) {
            const LayerView& layer = strip.cell->layers[part];
            if (!layer.contours.empty()) {
                for (const std::span<const Point> contour : scratch.solid.of(parts[part].result->info, layer)) {
                    scratch.sheet.add(contour, placing(layer), scale.x * scale.y < 0 ? -1 : 1);
                }
                mix_rows(strip, colour_of_part(part), opacity_over_others, scratch);
            }
        }
        for (const LayerView& layer : strip.cell->layers) {
            for (const Contour& contour : layer.contours) {
                const std::span<const Point> points = layer.points_of(contour);
                for (std::size_t i = 1; contour.role == Role::open && i < points.size(); ++i) {
                    scratch.sheet.add(line(placing(layer)(points[i - 1]), placing(layer)(points[i])), std::identity());
                }
            }
        }
        mix_rows(strip, open_colour, 1, scratch);
    }

    /// A counter-clockwise rectangle about the line, half a width longer at both ends.
    std::array<PointMm, 4> line(PointMm from, PointMm to) const {
        const double half = line_width / 2;
        const double length = std::hypot(to.x - from.x, to.y - from.y);
        const double x = length > 0 ? half * (to.x - from.x) / length : half;
        const double y = length > 0 ? half * (to.y - from.y) / length : 0;
        return {{{from.x - x + y, from.y - y - x},
                 {to.x + x + y, to.y + y - x},
                 {to.x + x - y, to.y + y + x},
                 {from.x - x - y, from.y - y + x}}};
    }

    /// `over_others`: the opacity where something else than the background is.
    void mix_rows(const Strip& strip, Colour colour, double over_others, Scratch& scratch) const {
        const Rectangle& area = strip.cell->area;
        for (int row = strip.begin; row < strip.end; ++row) {
            scratch.shares.assign(static_cast<std::size_t>(area.width), 0);
            scratch.sheet.take_row(static_cast<std::size_t>(row - strip.begin), scratch.shares);
            for (int column = 0; column < area.width; ++column) {
                if (const double share = scratch.shares[static_cast<std::size_t>(column)]; share > 0) {
                    canvas.mix(area.x + column, area.y + row, colour, share, cell_colour, over_others);
                }
            }
        }
    }
};

Status draw(std::span<const PicturePart> parts, std::vector<SheetCell> cells, const std::filesystem::path& path,
            PictureOptions options, const Context& context) {
    constexpr int most_strip_pixels = 1 << 18;
    if (options.image != nullptr) {
        const NearestAxis x = nearest_axis(options.image->axes[0]);
        const NearestAxis y = nearest_axis(options.image->axes[1]);
        options.x_leftward = x.negative;
        options.y_downward = y.axis == 2 ? y.negative : !y.negative;
    }
    const std::vector<std::string> labels = labels_of(cells, options.image);
    const Page page(box_of(parts, cells), labels, options);
    const Parallel parallel(context);
    parallel.begin_stage(0.8);
    Canvas canvas(page.width, page.height, page_colour);
    page.draw_heading(canvas, parts);
    std::vector<Strip> strips;
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const Rectangle area = page.draw_cell(canvas, i, labels[i]);
        const int rows = std::max(1, most_strip_pixels / area.width);
        for (int begin = 0; i < cells.size() && begin < area.height; begin += rows) {
            cells[i].area = area;
            strips.push_back({&cells[i], begin, std::min(area.height, begin + rows)});
        }
    }
    const LayerBrush brush{
        canvas,
        parts,
        {options.x_leftward ? -page.per_mm : page.per_mm, options.y_downward ? page.per_mm : -page.per_mm},
        page.middle,
        1.5 * page.unit};
    std::vector<Scratch> scratch(parallel.workers_for(strips.size()));
    parallel.run(strips.size(),
                 [&](std::size_t i, int worker) { brush.draw(strips[i], scratch[static_cast<std::size_t>(worker)]); });
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
