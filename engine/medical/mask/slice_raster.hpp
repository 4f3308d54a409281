// Slices of a mask: contours become voxels.
#pragma once

#include <cstring>

#include "base/little_endian.hpp"
#include "medical/mask/mask_file.hpp"
#include "medical/raster/coverage.hpp"
#include "medical/raster/row_crossings.hpp"
#include "slicing/grid/box.hpp"

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
        std::vector<std::uint8_t> overlapped;  ///< of the voxels of a row: counted as lying in several parts
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
    /// Voxels [first, last) of a row. `overlapped`: of each voxel of the row, whether it was counted as such.
    template <class Label>
    static void fill_span(Label* row, std::size_t first, std::size_t last, std::uint32_t part,
                          std::vector<std::uint8_t>& overlapped, MaskCounts& counts) {
        for (std::size_t i = first; part > 0 && i < last; ++i) {
            if (row[i] != 0) {
                --counts.voxels[row[i] - 1U];
                counts.overlapped += overlapped[i] != 0 ? 0U : 1U;
                overlapped[i] = 1;
            }
        }
        std::fill(row + first, row + last, static_cast<Label>(part + 1));
        counts.voxels[part] += last - first;
    }

    /// The shorter side of a rectangle with that area and perimeter: the thickness of a long wall. Where the shape is
    /// rounder than a square, the side of a square.
    static double width_of(double area, double perimeter) noexcept {
        const double half = perimeter / 4;
        const double square = half * half - area;
        return square > 0 ? half - std::sqrt(square) : std::sqrt(area);
    }

    /// Twice the area of a polygon.
    static double twice_area(const std::vector<PointMm>& polygon) {
        double sum = 0;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const PointMm& a = polygon[i];
            const PointMm& b = polygon[(i + 1) % polygon.size()];
            sum += a.x * b.y - b.x * a.y;
        }
        return sum;
    }

    /// Keeps what of a polygon lies on one side of a line x = limit or y = limit (Sutherland and Hodgman): its area is
    /// right, whatever its form.
    static std::vector<PointMm> clipped(const std::vector<PointMm>& polygon, bool along_y, double limit, double side) {
        const auto beyond = [&](const PointMm& at) { return side * ((along_y ? at.y : at.x) - limit); };
        std::vector<PointMm> kept;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const PointMm& a = polygon[i];
            const PointMm& b = polygon[(i + 1) % polygon.size()];
            const double from = beyond(a);
            const double to = beyond(b);
            if (from <= 0) {
                kept.push_back(a);
            }
            if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
                const double t = from / (from - to);
                kept.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
            }
        }
        return kept;
    }

    /// The area of the part of a polygon that lies within a rectangle; positive for counter-clockwise polygons.
    static double area_within(std::vector<PointMm> polygon, PointMm min, PointMm max) {
        polygon = clipped(clipped(polygon, false, min.x, -1), false, max.x, 1);
        polygon = clipped(clipped(polygon, true, min.y, -1), true, max.y, 1);
        return 0.5 * twice_area(polygon);
    }

    /// Calls use(part, crossings) for each part that crosses a row.
    template <class Use>
    static void for_each_part(std::span<const Crossing> crossings, const Use& use) {
        while (!crossings.empty()) {
            const std::uint32_t part = crossings.front().part();
            const auto end = std::find_if(crossings.begin(), crossings.end(),
                                          [part](const Crossing& crossing) { return crossing.part() != part; });
            const auto count = static_cast<std::size_t>(end - crossings.begin());
            use(part, crossings.first(count));
            crossings = crossings.subspan(count);
        }
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

    double area_inside(std::size_t part, const Contour& contour) const {
        const SliceResult& result = *parts_[part].result;
        std::vector<PointMm> polygon;
        for (const Point& point : result.points_of(contour)) {
            polygon.push_back(result.to_mm(point));
        }
        const PointMm half{0.5 * image_.spacing_mm[0], 0.5 * image_.spacing_mm[1]};
        return area_within(std::move(polygon), {-half.x, -half.y},
                           {static_cast<double>(image_.size[0]) * image_.spacing_mm[0] - half.x,
                            static_cast<double>(image_.size[1]) * image_.spacing_mm[1] - half.y});
    }

    template <class Label>
    void draw_spans(std::uint64_t slice, Label* to, Scratch& scratch, MaskCounts& counts) const {
        RowCrossings& crossings = scratch.crossings;
        crossings.restart(0, image_.size[1]);
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const SliceResult& result = *parts_[i].result;
            for (const Contour& contour : result.contours_of(result.layers[layer(slice, 0, i)])) {
                if (contour.role != Role::open) {
                    crossings.add(result.points_of(contour), columns_[i], rows_[i], static_cast<std::uint32_t>(i));
                }
            }
        }
        crossings.sort();
        for (std::size_t row = 0; row < image_.size[1]; ++row) {
            Label* const voxels = to + row * image_.size[0];
            scratch.overlapped.assign(parts_.size() > 1 ? image_.size[0] : 0, 0);
            for_each_part(crossings.of_row(row), [&](std::uint32_t part, std::span<const Crossing> of_part) {
                for_each_span(of_part, image_.size[0], [&](std::size_t first, std::size_t last) {
                    fill_span(voxels, first, last, part, scratch.overlapped, counts);
                });
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
        const double scale[2] = {result.info.grid_mm / image_.spacing_mm[0], result.info.grid_mm / image_.spacing_mm[1]};
        scratch.shares.assign(width * image_.size[1], 0);
        for (int subslice = 0; subslice < options_.subslices; ++subslice) {
            scratch.sheet.restart(width, 0, image_.size[1]);
            for (const std::span<const Point> contour : scratch.solid.of(result, layer(slice, subslice, 0))) {
                scratch.sheet.add(contour, scale);
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
