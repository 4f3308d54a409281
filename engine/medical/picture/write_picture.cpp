#include "lamella/medical/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "medical/geometry/directions.hpp"
#include "medical/picture/canvas.hpp"
#include "medical/picture/draw_layers.hpp"
#include "medical/picture/page.hpp"

namespace lamella {

namespace {

constexpr int most_cells = 4096;

Refused refused(const std::string& what) {
    return {{ErrorCode::invalid_argument, what}};
}

void require_drawable(std::span<const PicturePart> parts, const std::filesystem::path& path, const PictureOptions& options) {
    if (!can_write_pictures()) {
        throw refused("cannot write '" + path.string() + "': this build of lamella is without PNG (libpng-dev)");
    }
    for (const int side : {options.width, options.height}) {
        if (side < least_picture_side || side > largest_picture_side) {
            throw refused("a picture of " + std::to_string(options.width) + " x " + std::to_string(options.height) +
                          " pixels: a side has " + std::to_string(least_picture_side) + " to " +
                          std::to_string(largest_picture_side));
        }
    }
    if (std::int64_t{options.width} * options.height > most_picture_pixels) {
        throw refused("a picture of " + std::to_string(options.width) + " x " + std::to_string(options.height) +
                      " pixels is larger than 2^26");
    }
    if (parts.empty() || std::any_of(parts.begin(), parts.end(), [](const PicturePart& part) { return !part.result; })) {
        throw refused("a picture shows one mesh or more, each with its result");
    }
    if (options.layers < 1 || options.layers > most_cells) {
        throw refused("a contact sheet shows 1 to " + std::to_string(most_cells) + " layers");
    }
}

/// The layer whose slab holds the height, of two the one that is nearer; null where none does.
const Layer* layer_at(const SliceResult& result, double height_mm) noexcept {
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
    return nearest;
}

Drawing drawing_at(std::span<const PicturePart> parts, double height_mm) {
    Drawing drawing{.height_mm = height_mm};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        drawing.layers.push_back({parts[i].result, layer_at(*parts[i].result, height_mm), colour_of_part(i)});
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
        const SliceSummary& summary = part.result->summary;
        if (summary.min_mm[0] < summary.max_mm[0] && summary.min_mm[1] < summary.max_mm[1]) {
            box.widen({summary.min_mm[0], summary.min_mm[1]});
            box.widen({summary.max_mm[0], summary.max_mm[1]});
        }
    }
    for (const Drawing& drawing : drawings) {
        for (const DrawnLayer& drawn : drawing.layers) {
            for (const Contour& contour :
                 drawn.layer ? drawn.result->contours_of(*drawn.layer) : std::span<const Contour>{}) {
                for (const Point& point : drawn.result->points_of(contour)) {
                    box.widen(drawn.result->to_mm(point));
                }
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
        const auto is_open = [&part](const Layer& layer) { return std::isnan(part.result->area_mm2(layer)); };
        count += static_cast<std::uint64_t>(std::count_if(part.result->layers.begin(), part.result->layers.end(), is_open));
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

Status draw(std::span<const PicturePart> parts, std::vector<Drawing> drawings, const std::filesystem::path& path,
            const PictureOptions& asked) {
    const PictureOptions options = oriented(asked);
    const std::vector<std::string> labels = labels_of(drawings, options.image);
    int label_width = 0;
    for (const std::string& label : labels) {
        label_width = std::max(label_width, text_width(label, 1));
    }
    const BoxMm box = box_of(parts, drawings);
    const Page page(box, std::max<std::size_t>(1, drawings.size()), label_width, options);
    Parallel parallel(options.control);
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
    draw_layers(canvas, drawings, {box, page.pixels_per_mm(), 1.5 * page.unit(), options.x_leftward, options.y_downward},
                colours::cell, parallel);
    parallel.stop_if_asked();
    Status written = canvas.write_png(path);
    if (written) {
        parallel.finish();
    }
    return written;
}

}  // namespace

Status write_layer_picture(std::span<const PicturePart> parts, std::uint64_t layer, const std::filesystem::path& path,
                           const PictureOptions& options) noexcept {
    return guarded(options.control, [&]() -> Status {
        require_drawable(parts, path, options);
        const SliceResult& first = *parts.front().result;
        if (layer < first.first_layer || layer - first.first_layer >= first.layers.size()) {
            throw refused("'" + parts.front().name + "' has no layer " + std::to_string(layer) + ": it has " +
                          std::to_string(first.layers.size()) + ", counted from " + std::to_string(first.first_layer));
        }
        return draw(parts, {drawing_at(parts, first.layers[layer - first.first_layer].plane_mm)}, path, options);
    });
}

Status write_contact_sheet(std::span<const PicturePart> parts, const std::filesystem::path& path,
                           const PictureOptions& options) noexcept {
    return guarded(options.control, [&]() -> Status {
        require_drawable(parts, path, options);
        return draw(parts, evenly_spaced(parts, static_cast<std::size_t>(options.layers)), path, options);
    });
}

}  // namespace lamella
