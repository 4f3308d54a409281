// Slices of a mask: contours become voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lamella/medical/mask.hpp"
#include "medical/mask/mask_file.hpp"
#include "medical/raster/coverage.hpp"
#include "medical/raster/row_crossings.hpp"
#include "medical/raster/solid_contours.hpp"

namespace lamella {

/// Sums over what was drawn: by a thread, or by all.
struct MaskCounts {
    std::vector<std::uint64_t> voxels;
    std::uint64_t overlapped = 0;
    std::vector<double> area;    ///< of each part, mm2
    std::vector<double> inside;  ///< of it, what lies within the image
    std::vector<double> length;  ///< of each part, mm: area over width, summed over slices

    explicit MaskCounts(std::size_t parts) : voxels(parts), area(parts), inside(parts), length(parts) {}
    void add(const MaskCounts& other);
};

/// Draws slices in any order, on any number of threads. What it is made of must outlive it.
class SliceRaster {
public:
    /// Throws std::bad_alloc.
    SliceRaster(std::span<const MaskPart> parts, const ImageGeometry& image, const MaskOptions& options,
                const MaskLayout& layout);

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
    void draw(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const;

private:
    const Layer& layer(std::size_t part, std::uint64_t slice, int subslice) const;
    void measure(std::size_t part, const Layer& layer, MaskCounts& counts) const;
    bool reaches_beyond(std::size_t part, const Contour& contour) const noexcept;
    double area_inside(std::size_t part, const Contour& contour) const;
    template <class Label>
    void draw_spans(std::uint64_t slice, Label* to, Scratch& scratch, MaskCounts& counts) const;
    void draw_wide_labels(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const;
    void draw_shares(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const;

    std::span<const MaskPart> parts_;
    const ImageGeometry& image_;
    const MaskOptions& options_;
    const MaskLayout& layout_;
    std::vector<Centres> columns_;  ///< of each part, whose grids may differ
    std::vector<Centres> rows_;
};

}  // namespace lamella
