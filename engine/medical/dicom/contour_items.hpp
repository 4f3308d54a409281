// The contours of a slice as items of a Contour Sequence.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lamella/medical/structure_set.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/keyhole.hpp"
#include "medical/geometry/directions.hpp"

namespace lamella {

/// Those of one ROI. One a thread.
class ContourItems {
public:
    /// `image` and `roi` must outlive it.
    ContourItems(const ImageGeometry& image, const Roi& roi, HoleForm holes);

    /// Puts the items of slice k, which lies at `height_mm`; counts. Throws Refused (invalid_argument) where a contour is
    /// too long for its element.
    void put(std::uint64_t slice, double height_mm, DataSet& out, StructureSetSummary& counts);

private:
    struct Slice {
        std::uint64_t index;
        double height_mm;
        DataSet& out;
        StructureSetSummary& counts;
    };

    std::size_t region_end(std::span<const Contour> contours, std::size_t begin) const;
    void put_region(const Slice& slice, std::span<const Contour> region);
    void put_item(const Slice& slice, std::span<const RingPoint> ring);
    void write_point(const RingPoint& point, double height_mm);

    const ImageGeometry& image_;
    const Roi& roi_;
    HoleForm holes_;
    bool exclusive_or_;
    std::array<Direction, 3> axes_;  ///< of x, y and z of the slicing, in the patient
    int decimals_;
    std::string data_;  ///< of a contour
    Keyhole keyhole_;
    std::vector<std::span<const Point>> points_;  ///< of a region
};

}  // namespace lamella
