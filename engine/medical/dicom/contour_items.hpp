// The contours of a slice as items of a Contour Sequence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lamella/medical/structure_set.hpp"
#include "medical/dicom/keyhole.hpp"
#include "medical/geometry/directions.hpp"

namespace lamella {

/// From a slice's grid to the patient.
class SlicePlacement {
public:
    SlicePlacement(const ImageGeometry& image, double unit_mm);

    void put_point(std::string& out, const RingPoint& point, double height_mm) const;
    std::size_t most_bytes(std::size_t points) const noexcept { return points * 3 * 17; }

private:
    std::array<Direction, 3> axes_;  ///< of x, y and z of the slicing, in the patient
    Direction origin_mm_;
    double unit_mm_;
    int decimals_;
};

/// Whether any contour of a result is a hole.
bool has_holes(const SliceResult& result);

/// What one thread works with.
class ContourItems {
public:
    /// `image`, `roi` and `placement` must outlive it.
    ContourItems(const ImageGeometry& image, const Roi& roi, const SlicePlacement& placement, HoleForm holes);

    /// Appends the items of slice k, which lies at `height_mm`; counts. Throws Refused (invalid_argument) where a contour is
    /// too long for its element.
    void append(std::uint64_t slice, double height_mm, std::string& out, StructureSetSummary& counts);

private:
    std::size_t region_end(std::span<const Contour> contours, std::size_t begin) const;
    void append_region(std::span<const Contour> region, StructureSetSummary& counts);
    void append_item(std::span<const RingPoint> ring, StructureSetSummary& counts);

    const ImageGeometry& image_;
    const Roi& roi_;
    const SlicePlacement& placement_;
    HoleForm holes_;
    bool exclusive_or_;
    std::uint64_t slice_ = 0;
    double height_mm_ = 0;
    std::string* out_ = nullptr;
    std::string data_;
    Keyhole keyhole_;
    std::vector<std::span<const Point>> points_;
};

}  // namespace lamella
