#include "medical/dicom/contour_items.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/guard.hpp"
#include "medical/dicom/put_elements.hpp"

namespace lamella {

namespace {

/// So many that a number lies nearer to its point of the grid than to any other.
int decimals_for(double unit_mm) {
    return std::clamp(static_cast<int>(std::ceil(-std::log10(unit_mm / 4))), 0, 14);
}

bool is_outer(const Contour& contour) {
    return contour.role == Role::outer;
}

}  // namespace

SlicePlacement::SlicePlacement(const ImageGeometry& image, double unit_mm)
    : axes_{image.axes[0], image.axes[1], cross(image.axes[0], image.axes[1])},
      origin_mm_(image.origin_mm),
      unit_mm_(unit_mm),
      decimals_(decimals_for(unit_mm)) {}

void SlicePlacement::put_point(std::string& out, const RingPoint& point, double height_mm) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double at =
            origin_mm_[axis] + unit_mm_ * (axes_[0][axis] * point.x + axes_[1][axis] * point.y) + axes_[2][axis] * height_mm;
        put_decimal(out, at, decimals_);
        out += '\\';
    }
}

bool has_holes(const SliceResult& result) {
    return std::any_of(result.contours.begin(), result.contours.end(),
                       [](const Contour& contour) { return contour.role == Role::hole; });
}

ContourItems::ContourItems(const ImageGeometry& image, const Roi& roi, const SlicePlacement& placement, HoleForm holes)
    : image_(image),
      roi_(roi),
      placement_(placement),
      holes_(holes),
      exclusive_or_(holes == HoleForm::exclusive_or && has_holes(*roi.result)) {}

void ContourItems::append(std::uint64_t slice, double height_mm, std::string& out, StructureSetSummary& counts) {
    slice_ = slice;
    height_mm_ = height_mm;
    out_ = &out;
    const SliceResult& result = *roi_.result;
    const Layer& layer = result.layers[result.layer_of[slice]];
    const std::span<const Contour> contours = result.contours_of(layer);
    counts.open_contours += static_cast<std::uint64_t>(
        std::count_if(contours.begin(), contours.end(), [](const Contour& contour) { return contour.role == Role::open; }));
    for (std::size_t begin = 0; begin < contours.size();) {
        if (!is_outer(contours[begin]) && contours[begin].role != Role::hole) {
            ++begin;
            continue;
        }
        const std::size_t end = region_end(contours, begin);
        if (is_outer(contours[begin]) && contours[begin].parent >= 0 &&
            is_outer(result.contours[static_cast<std::size_t>(contours[begin].parent)])) {
            ++counts.nested_contours;
        }
        append_region(contours.subspan(begin, end - begin), counts);
        begin = end;
    }
}

/// Where the holes end that follow their outer contour.
std::size_t ContourItems::region_end(std::span<const Contour> contours, std::size_t begin) const {
    const auto own = &contours[begin] - roi_.result->contours.data();
    std::size_t end = begin + 1;
    while (is_outer(contours[begin]) && end < contours.size() && contours[end].role == Role::hole &&
           contours[end].parent == own) {
        ++end;
    }
    return end;
}

void ContourItems::append_region(std::span<const Contour> region, StructureSetSummary& counts) {
    points_.clear();
    for (const Contour& contour : region) {
        points_.push_back(roi_.result->points_of(contour));
        counts.holes += contour.role == Role::hole ? 1 : 0;
    }
    if (holes_ == HoleForm::keyhole) {
        return append_item(keyhole_.join(points_), counts);
    }
    for (const std::span<const Point>& contour : points_) {
        append_item(keyhole_.join({&contour, 1}), counts);
    }
}

void ContourItems::append_item(std::span<const RingPoint> ring, StructureSetSummary& counts) {
    constexpr std::size_t most_bytes = 0xfffffff0;
    if (ring.size() > most_bytes / placement_.most_bytes(1)) {
        throw Refused{{ErrorCode::invalid_argument, "'" + roi_.name + "': a contour of " + std::to_string(ring.size()) +
                                                        " points is too long for DICOM; --tolerance MM leaves fewer"}};
    }
    data_.clear();
    for (const RingPoint& point : ring) {
        placement_.put_point(data_, point, height_mm_);
    }
    data_.pop_back();
    std::string& out = *out_;
    begin_item(out);
    if (image_.series) {
        const DicomSeries::Instance& instance = image_.series->slices[slice_];
        begin_sequence(out, dicom::contour_image_sequence);
        put_uid(out, dicom::referenced_sop_class_uid, instance.sop_class_uid);
        put_uid(out, dicom::referenced_sop_instance_uid, instance.sop_instance_uid);
        end_sequence(out);
    }
    put_element(out, dicom::contour_geometric_type, exclusive_or_ ? "CLOSEDPLANAR_XOR" : "CLOSED_PLANAR");
    put_number(out, dicom::number_of_contour_points, ring.size());
    put_element(out, dicom::contour_data, data_);
    end_item(out);
    ++counts.contours;
    counts.points += ring.size();
}

}  // namespace lamella
