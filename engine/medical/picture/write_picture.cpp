#include "lamella/medical/picture.hpp"

#include <optional>

#include "base/parallel.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/picture/canvas.hpp"
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

/// The layers at one height, and where on the canvas they are drawn.
struct Cell {
    double height_mm = 0;
    std::vector<std::optional<std::uint64_t>> layers{};  ///< of each part: nothing where it has none there
    Rectangle area{};
};

/// The layer whose slab holds the height, of several the one that is nearest.
std::optional<std::uint64_t> layer_at(const SliceResult& result, double height_mm) noexcept {
    std::optional<std::uint64_t> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < result.layers.size(); ++i) {
        const Layer& layer = result.layers[i];
        const double distance = std::abs(layer.plane_mm - height_mm);
        const bool holds = distance == 0 || (layer.bottom_mm <= height_mm && height_mm <= layer.top_mm);
        if (holds && distance <= least) {
            least = distance;
            nearest = i;
        }
    }
    return nearest;
}

Cell cell_at(std::span<const PicturePart> parts, double height_mm) {
    Cell cell{.height_mm = height_mm};
    cell.layers.reserve(parts.size());
    for (const PicturePart& part : parts) {
        cell.layers.push_back(layer_at(*part.result, height_mm));
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

/// Calls use(i, layer) for each part's layer in a cell.
template <class Use>
void for_each_layer(std::span<const PicturePart> parts, const Cell& cell, const Use& use) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (cell.layers[i]) {
            use(i, (*parts[i].result)[*cell.layers[i]]);
        }
    }
}

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
        for_each_layer(parts, cell, [&](std::size_t, const LayerView& layer) {
            for (const Point& point : layer.points) {
                box.widen(layer.to_mm(point));
            }
        });
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
    std::transform(cells.begin(), cells.end(), labels.begin(), [&](const Cell& cell) {
        return decimal_text(image != nullptr ? image->height_lps_mm(cell.height_mm) : cell.height_mm, 3);
    });
    std::size_t idle = 4;  // zeros at the end of all, and the point before three of them
    for (const std::string& label : labels) {
        const std::size_t zeros = label.size() - 1 - label.find_last_not_of('0');
        idle = std::min(idle, zeros < 3 ? zeros : 4);
    }
    for (std::string& label : labels) {
        label = (image != nullptr ? axes[image->slice_axis()] : "") + label.substr(0, label.size() - idle) + " mm";
    }
    return labels;
}

/// Counts all layers, drawn or not.
std::uint64_t layers_with_open_polylines(std::span<const PicturePart> parts) {
    std::uint64_t count = 0;
    for (const PicturePart& part : parts) {
        for (const LayerView layer : *part.result) {
            count += std::isnan(layer.area_mm2()) ? 1U : 0U;  // it is not known where there is one
        }
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
          line_width_(1.5 * page.unit()) {}

    void draw(const Strip& strip) {
        constexpr double opacity_over_others = 0.75;  // overlaps show, and so does which part is the later one
        const Rectangle& area = strip.cell->area;
        const auto pixels = [&](PointMm mm) {
            return PointMm{scale_.x * (mm.x - middle_.x) + 0.5 * area.width,
                           scale_.y * (mm.y - middle_.y) + 0.5 * area.height};
        };
        sheet_.restart(static_cast<std::size_t>(area.width), static_cast<std::size_t>(strip.begin),
                       static_cast<std::size_t>(strip.end));
        for_each_layer(parts_, *strip.cell, [&](std::size_t part, const LayerView& layer) {
            for (const std::span<const Point> contour : solid_.of(*parts_[part].result, layer.index)) {
                const double sign = scale_.x * scale_.y < 0 ? -1 : 1;
                sheet_.add(
                    contour, [&](const Point& point) { return pixels(layer.to_mm(point)); }, sign);
            }
            mix_rows(strip, colour_of_part(part), opacity_over_others);
        });
        bool open = false;
        for_each_layer(parts_, *strip.cell, [&](std::size_t, const LayerView& layer) {
            for (const Contour& contour : layer.contours) {
                const std::span<const Point> points = layer.points_of(contour);
                for (std::size_t i = 1; contour.role == Role::open && i < points.size(); ++i) {
                    add_line(pixels(layer.to_mm(points[i - 1])), pixels(layer.to_mm(points[i])));
                    open = true;
                }
            }
        });
        if (open) {
            mix_rows(strip, colours::open, 1);
        }
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
                    const int x = area.x + column;
                    const int y = area.y + row;
                    canvas_.mix(x, y, colour, canvas_.has(x, y, colours::cell) ? share : over_others * share);
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
            const PictureOptions& asked, const Context& context) {
    const PictureOptions options = oriented(asked);
    std::vector<std::string> labels = labels_of(cells, options.image);
    if (cells.empty()) {
        labels.emplace_back("no layers");
    }
    int label_width = 0;
    for (const std::string& label : labels) {
        label_width = std::max(label_width, text_width(label, 1));
    }
    const BoxMm box = box_of(parts, cells);
    const Page page(box, labels.size(), label_width, options);
    const Parallel parallel(context);
    parallel.begin_stage(0.8);
    Canvas canvas(page.width(), page.height(), colours::page);
    page.draw_heading(canvas, parts, layers_with_open_polylines(parts));
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
