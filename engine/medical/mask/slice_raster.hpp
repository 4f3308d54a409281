// Where the centres of voxels lie on the grid of a result, and where contours cross their rows: exact, by integers. Then
// slices of a mask: contours become voxels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/little_endian.hpp"
#include "io/raster/coverage.hpp"
#include "lamella/grid.hpp"
#include "lamella/medical/mask.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// The centres of voxels 0, 1, ... along one axis in grid units, from that at `first_mm` on, each rounded: they ascend, and
/// where voxels are smaller than a unit several share a place. What lies beyond the grid stands just beyond it, where no
/// contour reaches.
class Centres {
public:
    /// Preconditions: the lengths are finite and above 0. Throws std::bad_alloc.
    Centres(std::size_t count, double spacing_mm, double grid_mm, double first_mm = 0)
        : places_(count + 2), voxels_per_unit_(grid_mm / spacing_mm), entry_of_zero_(1 - first_mm / spacing_mm) {
        constexpr std::int64_t beyond = std::int64_t{grid_limit} + 1;
        for (std::size_t voxel = 0; voxel < count; ++voxel) {
            const double place = std::round((first_mm + static_cast<double>(voxel) * spacing_mm) / grid_mm);
            places_[voxel + 1] = std::abs(place) < static_cast<double>(beyond) ? static_cast<std::int64_t>(place)
                                 : place < 0                                   ? -beyond
                                                                               : beyond;
        }
        places_.front() = std::numeric_limits<std::int64_t>::min();
        places_.back() = std::numeric_limits<std::int64_t>::max();
    }

    std::size_t size() const noexcept { return places_.size() - 2; }
    std::int64_t operator[](std::size_t voxel) const noexcept { return places_[voxel + 1]; }

    /// The first voxel whose centre lies at `place` or after it; size() where none does. O(1), or O(log n) where voxels are
    /// about as small as a unit.
    std::size_t first_from(std::int64_t place) const noexcept {
        const double guess = static_cast<double>(place) * voxels_per_unit_ + entry_of_zero_;  // the entry in places_
        const auto last = static_cast<double>(places_.size() - 1);
        auto entry = static_cast<std::size_t>(guess < 1 ? 1 : guess > last ? last : guess);
        entry += static_cast<std::size_t>(places_[entry] < place);
        return places_[entry - 1] < place && place <= places_[entry] ? entry - 1 : search(place);
    }

    /// first_from(place) is `voxel`.
    bool begins(std::size_t voxel, std::int64_t place) const noexcept {
        return places_[voxel] < place && place <= places_[voxel + 1];
    }

private:
    std::size_t search(std::int64_t place) const noexcept {
        return static_cast<std::size_t>(std::lower_bound(places_.begin() + 1, places_.end() - 1, place) - places_.begin()) -
               1;
    }

    std::vector<std::int64_t> places_;  ///< between two that no coordinate reaches
    double voxels_per_unit_;
    double entry_of_zero_;  ///< in places_, of a centre at place 0
};

/// Where contours cross the rows of an image. An edge crosses the rows whose centres lie at its lower end or above, and
/// below its upper end; it lies to the left of the centres at its place or to the right: so left and bottom edges are
/// inside.
class RowCrossings {
public:
    /// Forgets all.
    void restart(std::size_t rows) {
        found_.clear();
        first_.assign(rows + 2, 0);
    }

    /// A closed contour of any orientation. Preconditions: its points are within grid_limit.
    void add(std::span<const Point> contour, const Centres& columns, const Centres& rows) {
        if (contour.empty()) {
            return;
        }
        Point from = contour.back();
        std::size_t from_row = rows.first_from(from.y);
        for (const Point& to : contour) {
            if (!rows.begins(from_row, to.y)) {
                const std::size_t to_row = rows.first_from(to.y);
                if (from_row < to_row) {
                    add_edge(from, to, from_row, to_row, upward, columns, rows);
                } else {
                    add_edge(to, from, to_row, from_row, 0, columns, rows);
                }
                from_row = to_row;
            }
            from = to;
        }
    }

    /// After the last add(): calls span(row, begin, end) for the voxels of each row, `width` long, whose winding number is
    /// not 0.
    template <class Span>
    void for_each_span(std::size_t width, Span&& span) {
        sort_by_rows();
        for (std::size_t row = 0; row + 2 < first_.size(); ++row) {
            const auto row_begin = sorted_.begin() + static_cast<std::ptrdiff_t>(first_[row]);
            const auto row_end = sorted_.begin() + static_cast<std::ptrdiff_t>(first_[row + 1]);
            std::sort(row_begin, row_end);
            int winding = 0;
            std::size_t begin = 0;
            for (auto crossing = row_begin; crossing != row_end; ++crossing) {
                const std::size_t column = *crossing >> 1;
                begin = winding == 0 ? column : begin;
                winding += (*crossing & upward) != 0 ? 1 : -1;
                if (winding == 0 && column > begin) {
                    span(row, begin, column);
                }
            }
            if (winding != 0) {
                span(row, begin, width);
            }
        }
    }

private:
    static constexpr std::uint32_t upward = 1;

    /// From voxel `column` on, centres lie to the right of a contour. Ordered by column.
    struct Crossing {
        std::uint32_t row = 0;
        std::uint32_t column_and_way = 0;  ///< 2 column, and `upward` where the contour runs so
    };

    /// The quotient rounded up. |numerator| <= 2^62, 0 < denominator <= 2^31, and the quotient fits 32 bits: the quotient of
    /// doubles, which takes a third of the time of the integers', is at most one off.
    static std::int64_t ceiling(std::int64_t numerator, std::int64_t denominator) noexcept {
        auto quotient = static_cast<std::int64_t>(static_cast<double>(numerator) / static_cast<double>(denominator));
        quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
        quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
        quotient -= static_cast<std::int64_t>((quotient - 1) * denominator >= numerator);
        return quotient;
    }

    void add_edge(Point low, Point high, std::size_t first_row, std::size_t end_row, std::uint32_t way,
                  const Centres& columns, const Centres& rows) {
        const std::int64_t run = std::int64_t{high.x} - low.x;
        const std::int64_t rise = std::int64_t{high.y} - low.y;
        for (std::size_t row = first_row; row < end_row; ++row) {
            const std::size_t column = columns.first_from(low.x + ceiling((rows[row] - low.y) * run, rise));
            if (column < columns.size()) {
                found_.push_back({static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column) << 1 | way});
                ++first_[row + 2];
            }
        }
    }

    void sort_by_rows() {
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        sorted_.resize(found_.size());
        for (const Crossing& crossing : found_) {
            sorted_[first_[crossing.row + 1]++] = crossing.column_and_way;
        }
    }

    std::vector<Crossing> found_;
    std::vector<std::size_t> first_;  ///< of each row, in sorted_; two places after it until they are sorted
    std::vector<std::uint32_t> sorted_;
};

enum class MaskForm : std::uint8_t { nifti, nrrd, segmentation, meta };

struct MaskLayout {
    std::string_view name_end;  ///< of the file's name
    MaskForm form = MaskForm::nifti;
    bool compressed = false;
    bool shares = false;  ///< bytes of which 255 stand for 1, not labels
    std::size_t voxel_bytes = 1;
    std::size_t layers = 1;  ///< of which each voxel has a label
};

constexpr std::size_t most_mask_labels = 65535;
constexpr std::size_t mask_voxel_bytes(std::size_t labels) noexcept {
    return labels > 255 ? 2 : 1;
}

/// By the end of the name. Throws Refused.
MaskLayout layout_of(const std::filesystem::path& path, std::span<const MaskPart> parts, bool shares);

/// Sums over what was drawn: by a thread, or by all.
struct MaskCounts {
    struct Part {
        std::uint64_t voxels = 0;
        double area = 0;    ///< mm2
        double inside = 0;  ///< of it, what lies within the image
        double length = 0;  ///< mm: area over width, summed over slices

        void add(const Part& other) {
            voxels += other.voxels;
            area += other.area;
            inside += other.inside;
            length += other.length;
        }
    };
    std::vector<Part> parts;
    std::uint64_t overlapped = 0;

    explicit MaskCounts(std::size_t count) : parts(count) {}
    void add(const MaskCounts& other) {
        overlapped += other.overlapped;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            parts[i].add(other.parts[i]);
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
        for (std::size_t i = 0; i < parts.size(); ++i) {
            columns_.push_back(centres(i, 0, 0));
            rows_.push_back(centres(i, 1, 0));
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
        std::optional<Centres> columns;        ///< of a slice of a sheared image
        std::optional<Centres> rows;
    };

    /// All slice_bytes() of a slice. Throws std::bad_alloc.
    void draw(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const {
        std::memset(to, 0, slice_bytes());
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            for (int subslice = 0; subslice < options_.subslices; ++subslice) {
                measure(i, slice, (*parts_[i].result)[layer(slice, subslice, i)], scratch.sheet, counts.parts[i]);
            }
        }
        if (layout_.shares) {
            draw_shares(slice, to, scratch, counts);
        } else if (layout_.voxel_bytes == 1) {
            draw_spans(slice, to, scratch, counts);
        } else {
            scratch.wide.assign(image_.size[0] * image_.size[1], 0);
            draw_spans(slice, scratch.wide.data(), scratch, counts);
            std::memcpy(to, scratch.wide.data(), slice_bytes());
        }
    }

    /// Calls span(row, begin, end) for the voxels of a part, in a slice of one plane.
    template <class Span>
    void for_each_span(std::uint64_t slice, std::size_t part, Scratch& scratch, Span&& span) const {
        const SliceResult& result = *parts_[part].result;
        scratch.crossings.restart(image_.size[1]);
        if (image_.is_sheared()) {
            scratch.columns.emplace(centres(part, 0, first_mm(slice, 0)));
            scratch.rows.emplace(centres(part, 1, first_mm(slice, 1)));
        }
        const Centres& columns = image_.is_sheared() ? *scratch.columns : columns_[part];
        const Centres& rows = image_.is_sheared() ? *scratch.rows : rows_[part];
        for (const Contour& contour : result.contours_of(result.layers[layer(slice, 0, part)])) {
            if (contour.role != Role::open) {
                scratch.crossings.add(result.points_of(contour), columns, rows);
            }
        }
        scratch.crossings.for_each_span(image_.size[0], span);
    }

private:
    std::uint64_t layer(std::uint64_t slice, int subslice, std::size_t part) const {
        const std::uint64_t height =
            slice * static_cast<std::uint64_t>(options_.subslices) + static_cast<std::uint64_t>(subslice);
        const SliceInfo& info = parts_[part].result->info;
        return info.layer_of[height] - info.first_layer;
    }

    Centres centres(std::size_t part, std::size_t axis, double from_mm) const {
        return {image_.size[axis], image_.spacing_mm[axis], parts_[part].result->info.grid_mm, from_mm};
    }

    /// Along i or j, where the first voxel of a slice lies.
    double first_mm(std::uint64_t slice, std::size_t axis) const noexcept {
        return static_cast<double>(slice) * image_.shear_mm[axis];
    }

    /// Where points lie, in voxels from the lower left corner of the first: a voxel reaches half its side around its centre.
    auto placing(const SliceResult& result, std::uint64_t slice) const noexcept {
        const PointMm scale{result.info.grid_mm / image_.spacing_mm[0], result.info.grid_mm / image_.spacing_mm[1]};
        const PointMm corner{0.5 - first_mm(slice, 0) / image_.spacing_mm[0],
                             0.5 - first_mm(slice, 1) / image_.spacing_mm[1]};
        return [scale, corner](const Point& point) {
            return PointMm{point.x * scale.x + corner.x, point.y * scale.y + corner.y};
        };
    }

    /// Adds the areas of a layer where they are known.
    void measure(std::size_t part, std::uint64_t slice, const LayerView& layer, CoverageSheet& sheet,
                 MaskCounts::Part& counts) const {
        const double net = layer.area_mm2();
        if (std::isnan(net)) {
            return;
        }
        double perimeter = 0;
        for (const Contour& contour : layer.contours) {
            if (contour.encloses_area()) {
                const std::span<const Point> points = layer.points_of(contour);
                const double area = layer.area_mm2(contour);
                counts.area += area;
                perimeter += perimeter_of(points) * layer.grid_mm;
                counts.inside +=
                    reaches_beyond(part, slice, points) ? area_inside(part, slice, points, area < 0 ? -1 : 1, sheet) : area;
            }
        }
        if (net > 0) {
            // The shorter side of a rectangle with that area and perimeter: the thickness of a long wall. Where the shape is
            // rounder than a square, the side of a square.
            const double half = perimeter / 4;
            const double square = half * half - net;
            counts.length += net / (square > 0 ? half - std::sqrt(square) : std::sqrt(net));
        }
    }

    /// Beyond the outer sides of the outermost voxels.
    bool reaches_beyond(std::size_t part, std::uint64_t slice, std::span<const Point> points) const noexcept {
        constexpr double rounding = 1e-3;  // as of an image around the mesh
        const auto [min, max] = FlatBox::around(points);
        const auto place = placing(*parts_[part].result, slice);
        const PointMm low = place(min);
        const PointMm high = place(max);
        return std::min(low.x, low.y) < -rounding || high.x > static_cast<double>(image_.size[0]) + rounding ||
               high.y > static_cast<double>(image_.size[1]) + rounding;
    }

    /// The area of the part of a contour that lies within the image, mm2: what it covers of one voxel as large as the image.
    /// `sign`: that of the area.
    double area_inside(std::size_t part, std::uint64_t slice, std::span<const Point> points, double sign,
                       CoverageSheet& sheet) const {
        const PointMm size{static_cast<double>(image_.size[0]), static_cast<double>(image_.size[1])};
        const auto place = placing(*parts_[part].result, slice);
        double share = 0;
        sheet.restart(1, 0, 1);
        sheet.add(
            points,
            [&](const Point& point) {
                return PointMm{place(point).x / size.x, place(point).y / size.y};
            },
            sign);
        sheet.take_row(0, {&share, 1});
        return sign * share * size.x * image_.spacing_mm[0] * size.y * image_.spacing_mm[1];
    }

    template <class Label>
    void draw_spans(std::uint64_t slice, Label* to, Scratch& scratch, MaskCounts& counts) const {
        const std::size_t width = image_.size[0];
        scratch.overlapped.assign(parts_.size() > 1 ? width * image_.size[1] : 0, 0);
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            for_each_span(slice, i, scratch, [&](std::size_t row, std::size_t first, std::size_t last) {
                for (std::size_t at = row * width + first; i > 0 && at < row * width + last; ++at) {
                    if (to[at] != 0) {
                        --counts.parts[to[at] - 1U].voxels;
                        counts.overlapped += std::exchange(scratch.overlapped[at], 1) != 0 ? 0U : 1U;
                    }
                }
                std::fill(to + row * width + first, to + row * width + last, static_cast<Label>(i + 1));
                counts.parts[i].voxels += last - first;
            });
        }
    }

    void draw_shares(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const {
        const SliceResult& result = *parts_[0].result;
        const std::size_t width = image_.size[0];
        scratch.shares.assign(width * image_.size[1], 0);
        for (int subslice = 0; subslice < options_.subslices; ++subslice) {
            scratch.sheet.restart(width, 0, image_.size[1]);
            for (const std::span<const Point> contour : scratch.solid.of(result.info, result[layer(slice, subslice, 0)])) {
                scratch.sheet.add(contour, placing(result, slice));
            }
            for (std::size_t row = 0; row < image_.size[1]; ++row) {
                scratch.sheet.take_row(row, std::span(scratch.shares).subspan(row * width, width));
            }
        }
        for (std::size_t i = 0; i < scratch.shares.size(); ++i) {
            if (scratch.shares[i] > 0) {
                to[i] = static_cast<unsigned char>(std::lround(255 * scratch.shares[i] / options_.subslices));
                counts.parts[0].voxels += to[i] != 0 ? 1 : 0;
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

/// What is known once all is drawn.
MaskSummary summary_of(const MaskCounts& counts, std::span<const MaskPart> parts, const Context& context);

/// Throws Refused unless every part has a layer for each plane of the image, or of so many slices of it.
void require_cut_for(std::span<const MaskPart> parts, const ImageGeometry& image, const MaskOptions& options,
                     std::optional<std::uint64_t> slices = std::nullopt);

}  // namespace lamella
