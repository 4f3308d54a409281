// Slices of a mask: contours become voxels.
#pragma once

#include <cstring>

#include "base/little_endian.hpp"
#include "medical/mask/mask_file.hpp"
#include "medical/raster/coverage.hpp"
#include "medical/raster/row_crossings.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// Sums over what was drawn: by a thread, or by all.
struct MaskCounts {
    std::vector<std::uint64_t> voxels;
    std::uint64_t overlapped = 0;
    std::vector<double> area;    ///< of each part, mm2
    std::vector<double> inside;  ///< of it, what lies within the image
    std::vector<double> length;  ///< of each part, mm: area over width, summed over slices

    explicit MaskCounts(std::size_t parts) : voxels(parts), area(parts), inside(parts), length(parts) {}
    void add(const MaskCounts& other) {
        overlapped += other.overlapped;
        for (std::size_t i = 0; i < voxels.size(); ++i) {
            voxels[i] += other.voxels[i];
            area[i] += other.area[i];
            inside[i] += other.inside[i];
            length[i] += other.length[i];
        }
    }
};

/// Draws slices in any order, on any number of threads. What it is made of must outlive it.
class SliceRaster {
public:
    /// Throws std::bad_alloc.
    SliceRaster(std::span<const MaskPart> parts, const ImageGeometry& image, const MaskOptions& options,
                const MaskLayout& layout)
        : parts_(parts), image_(image), options_(options), layout_(layout) {
        for (const MaskPart& part : parts) {
            columns_.emplace_back(image.size[0], image.spacing_mm[0], part.result->info.grid_mm);
            rows_.emplace_back(image.size[1], image.spacing_mm[1], part.result->info.grid_mm);
        }
    }

    std::size_t slice_bytes() const noexcept { return image_.size[0] * image_.size[1] * layout_.voxel_bytes; }

    /// Memory of one thread.
    struct Scratch {
        RowCrossings crossings;
        CoverageSheet sheet;
        std::vector<double> shares;
        SolidContours solid;
        std::vector<std::uint8_t> overlapped;  ///< of the voxels of a slice: counted as lying in several parts
        std::vector<std::uint16_t> wide;       ///< labels of a slice, before they become bytes
    };

    /// All slice_bytes() of a slice. Throws std::bad_alloc.
    void draw(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const {
        std::memset(to, 0, slice_bytes());
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            for (int subslice = 0; subslice < options_.subslices; ++subslice) {
                measure(i, (*parts_[i].result)[layer(slice, subslice, i)], counts);
            }
        }
        if (layout_.shares) {
            draw_shares(slice, to, scratch, counts);
        } else if (layout_.voxel_bytes == 1) {
            draw_spans(slice, to, scratch, counts);
        } else {
            draw_wide_labels(slice, to, scratch, counts);
        }
    }

private:
    /// The shorter side of a rectangle with that area and perimeter: the thickness of a long wall. Where the shape is
    /// rounder than a square, the side of a square.
    static double width_of(double area, double perimeter) noexcept {
        const double half = perimeter / 4;
        const double square = half * half - area;
        return square > 0 ? half - std::sqrt(square) : std::sqrt(area);
    }

    std::uint64_t layer(std::uint64_t slice, int subslice, std::size_t part) const {
        const std::uint64_t height =
            slice * static_cast<std::uint64_t>(options_.subslices) + static_cast<std::uint64_t>(subslice);
        return parts_[part].result->info.layer_of[height];
    }

    /// Adds the areas of a layer where they are known.
    void measure(std::size_t part, const LayerView& layer, MaskCounts& counts) const {
        const double net = layer.area_mm2();
        if (std::isnan(net)) {
            return;
        }
        double perimeter = 0;
        for (const Contour& contour : layer.contours) {
            if (contour.role == Role::outer || contour.role == Role::hole) {
                const double area = layer.area_mm2(contour);
                counts.area[part] += area;
                perimeter += perimeter_of(layer.points_of(contour)) * layer.grid_mm;
                counts.inside[part] += reaches_beyond(part, contour) ? area_inside(part, contour) : area;
            }
        }
        if (net > 0) {
            counts.length[part] += net / width_of(net, perimeter);
        }
    }

    /// Beyond the outer sides of the outermost voxels.
    bool reaches_beyond(std::size_t part, const Contour& contour) const noexcept {
        const SliceResult& result = *parts_[part].result;
        const auto [min, max] = FlatBox::around(result.points_of(contour));
        const double scale[2] = {result.info.grid_mm / image_.spacing_mm[0], result.info.grid_mm / image_.spacing_mm[1]};
        constexpr double side = 0.5 + 1e-3;  // less is rounding, as of an image around the mesh
        return min.x * scale[0] < -side || min.y * scale[1] < -side ||
               max.x * scale[0] > static_cast<double>(image_.size[0]) - 1 + side ||
               max.y * scale[1] > static_cast<double>(image_.size[1]) - 1 + side;
    }

    /// The area of the part of a contour that lies within the image, mm2: x over each edge's height, both clamped to the
    /// sides of the image.
    double area_inside(std::size_t part, const Contour& contour) const {
        const SliceResult& result = *parts_[part].result;
        const PointMm half{0.5 * image_.spacing_mm[0], 0.5 * image_.spacing_mm[1]};
        const double right = static_cast<double>(image_.size[0]) * image_.spacing_mm[0] - half.x;
        const double top = static_cast<double>(image_.size[1]) * image_.spacing_mm[1] - half.y;
        double sum = 0;
        PointMm from = result.to_mm(result.points_of(contour).back());
        for (const Point& point : result.points_of(contour)) {
            const PointMm to = result.to_mm(point);
            const double low = std::clamp(from.y, -half.y, top);
            const double high = std::clamp(to.y, -half.y, top);
            if (low != high) {
                const double slope = (to.x - from.x) / (to.y - from.y);
                sum += (high - low) *
                       mean_clamped(from.x + (low - from.y) * slope, from.x + (high - from.y) * slope, -half.x, right);
            }
            from = to;
        }
        return sum;
    }

    /// The mean of what lies evenly between a and b, each clamped.
    static double mean_clamped(double a, double b, double least, double largest) noexcept {
        const double from = std::clamp(a, least, largest);
        const double to = std::clamp(b, least, largest);
        const bool is_one_line = from == to || (from == a && to == b);
        return is_one_line ? 0.5 * (from + to) : (to * (b - 0.5 * to) - from * (a - 0.5 * from)) / (b - a);
    }

    template <class Label>
    void draw_spans(std::uint64_t slice, Label* to, Scratch& scratch, MaskCounts& counts) const {
        const std::size_t width = image_.size[0];
        scratch.overlapped.assign(parts_.size() > 1 ? width * image_.size[1] : 0, 0);
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const SliceResult& result = *parts_[i].result;
            scratch.crossings.restart(image_.size[1]);
            for (const Contour& contour : result.contours_of(result.layers[layer(slice, 0, i)])) {
                if (contour.role != Role::open) {
                    scratch.crossings.add(result.points_of(contour), columns_[i], rows_[i]);
                }
            }
            scratch.crossings.for_each_span(width, [&](std::size_t row, std::size_t first, std::size_t last) {
                for (std::size_t at = row * width + first; i > 0 && at < row * width + last; ++at) {
                    if (to[at] != 0) {
                        --counts.voxels[to[at] - 1U];
                        counts.overlapped += std::exchange(scratch.overlapped[at], 1) != 0 ? 0U : 1U;
                    }
                }
                std::fill(to + row * width + first, to + row * width + last, static_cast<Label>(i + 1));
                counts.voxels[i] += last - first;
            });
        }
    }

    void draw_wide_labels(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const {
        scratch.wide.assign(image_.size[0] * image_.size[1], 0);
        draw_spans(slice, scratch.wide.data(), scratch, counts);
        std::memcpy(to, scratch.wide.data(), slice_bytes());
    }

    void draw_shares(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const {
        const SliceResult& result = *parts_[0].result;
        const std::size_t width = image_.size[0];
        const PointMm scale{result.info.grid_mm / image_.spacing_mm[0], result.info.grid_mm / image_.spacing_mm[1]};
        // A voxel reaches half its side around its centre.
        const auto place = [&](const Point& point) { return PointMm{point.x * scale.x + 0.5, point.y * scale.y + 0.5}; };
        scratch.shares.assign(width * image_.size[1], 0);
        for (int subslice = 0; subslice < options_.subslices; ++subslice) {
            scratch.sheet.restart(width, 0, image_.size[1]);
            for (const std::span<const Point> contour : scratch.solid.of(result, layer(slice, subslice, 0))) {
                scratch.sheet.add(contour, place);
            }
            for (std::size_t row = 0; row < image_.size[1]; ++row) {
                scratch.sheet.take_row(row, std::span(scratch.shares).subspan(row * width, width));
            }
        }
        for (std::size_t i = 0; i < scratch.shares.size(); ++i) {
            if (scratch.shares[i] > 0) {
                to[i] = static_cast<unsigned char>(std::lround(255 * scratch.shares[i] / options_.subslices));
                counts.voxels[0] += to[i] != 0 ? 1 : 0;
            }
        }
    }

    std::span<const MaskPart> parts_;
    const ImageGeometry& image_;
    const MaskOptions& options_;
    const MaskLayout& layout_;
    std::vector<Centres> columns_;  ///< of each part, whose grids may differ
    std::vector<Centres> rows_;
};

}  // namespace lamella
