#include "medical/dicom/contour_items.hpp"

#include <algorithm>
#include <cmath>

#include "base/guard.hpp"

namespace lamella {

namespace {

bool is_outer(const Contour& contour) {
    return contour.role == Role::outer;
}

bool is_hole(const Contour& contour) {
    return contour.role == Role::hole;
}

}  // namespace

ContourItems::ContourItems(const ImageGeometry& image, const Roi& roi, HoleForm holes)
    : image_(image),
      roi_(roi),
      holes_(holes),
      exclusive_or_(holes == HoleForm::exclusive_or &&
                    std::any_of(roi.result->contours.begin(), roi.result->contours.end(), is_hole)),
      axes_{image.axes[0], image.axes[1], cross(image.axes[0], image.axes[1])},
      // So many that a number lies nearer to its point of the grid than to any other.
      decimals_(std::clamp(static_cast<int>(std::ceil(-std::log10(roi.result->unit_mm / 4))), 0, 14)) {}

void ContourItems::put(std::uint64_t slice, double height_mm, DataSet& out, StructureSetSummary& counts) {
    const SliceResult& result = *roi_.result;
    const std::span<const Contour> contours = result.contours_of(result.layers[result.layer_of[slice]]);
    for (std::size_t begin = 0; begin < contours.size();) {
        const Contour& first = contours[begin];
        if (!is_outer(first) && !is_hole(first)) {
            counts.open_contours += first.role == Role::open ? 1 : 0;
            ++begin;
            continue;
        }
        const std::size_t end = region_end(contours, begin);
        if (is_outer(first) && first.parent >= 0 && is_outer(result.contours[static_cast<std::size_t>(first.parent)])) {
            ++counts.nested_contours;
        }
        put_region({slice, height_mm, out, counts}, contours.subspan(begin, end - begin));
        begin = end;
    }
}

/// Where the holes end that follow their outer contour.
std::size_t ContourItems::region_end(std::span<const Contour> contours, std::size_t begin) const {
    const auto own = &contours[begin] - roi_.result->contours.data();
    std::size_t end = begin + 1;
    while (is_outer(contours[begin]) && end < contours.size() && is_hole(contours[end]) && contours[end].parent == own) {
        ++end;
    }
    return end;
}

void ContourItems::put_region(const Slice& slice, std::span<const Contour> region) {
    points_.clear();
    for (const Contour& contour : region) {
        points_.push_back(roi_.result->points_of(contour));
        slice.counts.holes += is_hole(contour) ? 1 : 0;
    }
    if (holes_ == HoleForm::keyhole) {
        return put_item(slice, keyhole_.join(points_));
    }
    for (const std::span<const Point>& contour : points_) {
        put_item(slice, keyhole_.join({&contour, 1}));
    }
}

void ContourItems::put_item(const Slice& slice, std::span<const RingPoint> ring) {
    constexpr std::size_t most_bytes = 0xfffffff0;
    constexpr std::size_t most_bytes_a_point = 3 * 17;
    if (ring.size() > most_bytes / most_bytes_a_point) {
        throw Refused{{ErrorCode::invalid_argument, "'" + roi_.name + "': a contour of " + std::to_string(ring.size()) +
                                                        " points is too long for DICOM; --tolerance MM leaves fewer"}};
    }
    data_.clear();
    for (const RingPoint& point : ring) {
        write_point(point, slice.height_mm);
    }
    data_.pop_back();
    DataSet& out = slice.out;
    out.put_item([&] {
        if (image_.series) {
            out.put_sequence_of_one(dicom::contour_image_sequence, [&] {
                out.put_uid(dicom::referenced_sop_class_uid, image_.series->slices[slice.index].sop_class_uid);
                out.put_uid(dicom::referenced_sop_instance_uid, image_.series->slices[slice.index].sop_instance_uid);
            });
        }
        out.put(dicom::contour_geometric_type, exclusive_or_ ? "CLOSEDPLANAR_XOR" : "CLOSED_PLANAR");
        out.put_number(dicom::number_of_contour_points, ring.size());
        out.put(dicom::contour_data, data_);
    });
    ++slice.counts.contours;
    slice.counts.points += ring.size();
}

void ContourItems::write_point(const RingPoint& point, double height_mm) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double in_slice = roi_.result->unit_mm * (axes_[0][axis] * point.x + axes_[1][axis] * point.y);
        put_decimal(data_, image_.origin_mm[axis] + in_slice + axes_[2][axis] * height_mm, decimals_);
        data_ += '\\';
    }
}

}  // namespace lamella
