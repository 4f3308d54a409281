// Checks what SliceResult promises, by plain methods that share nothing with the slicing stages.
#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "audit/validate.hpp"
#include "base/guard.hpp"
#include "lamella/audit/validate.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

bool is_closed(const Contour& contour) {
    return contour.role != Role::open;
}

/// Contours of consecutive layers and points of consecutive contours follow each other without gap, to the end.
Complaint check_offsets(const SliceResult& result) {
    std::uint64_t next_contour = 0;
    std::uint64_t next_point = 0;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        if (layer.first_contour != next_contour) {
            return layer_place(l) + "does not begin where the layer before ends";
        }
        if (layer.contour_count > result.contours.size() - next_contour) {
            return layer_place(l) + "reaches past the last contour";
        }
        for (; next_contour < layer.first_contour + layer.contour_count; ++next_contour) {
            const Contour& contour = result.contours[next_contour];
            if (contour.first_point != next_point) {
                return layer_place(l, next_contour) + "does not begin where the contour before ends";
            }
            if (contour.point_count > result.points.size() - next_point) {
                return layer_place(l, next_contour) + "reaches past the last point";
            }
            next_point += contour.point_count;
        }
    }
    if (next_contour != result.contours.size() || next_point != result.points.size()) {
        return "contours or points are left over behind the last layer";
    }
    return {};
}

Complaint check_planes(const SliceResult& result) {
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        if (layer.plane.z() % 2 == 0) {
            return layer_place(l) + "the plane lies on an even height, where vertices are";
        }
        if (l > 0 && layer.plane <= result.layers[l - 1].plane) {
            return layer_place(l) + "the plane is not above the one before";
        }
        if (!(layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm)) {
            return layer_place(l) + "the plane is not between bottom and top";
        }
    }
    return {};
}

Complaint check_points(const Contour& contour, std::span<const Point> points) {
    if (points.empty()) {
        return "no points";
    }
    if (std::adjacent_find(points.begin(), points.end()) != points.end()) {
        return "equal consecutive points";
    }
    // A polyline has one point more than segments, and keeps it when it is joined to another.
    const std::uint64_t extra = (contour.flags & gap_closed) != 0 ? contour.segments : (is_closed(contour) ? 0 : 1);
    if (contour.point_count > std::uint64_t{contour.segments} + extra) {
        return "more points than its segments have";
    }
    if (!is_closed(contour)) {
        return {};
    }
    if (points.size() > 1 && points.front() == points.back()) {
        return "the first point is repeated at the end";
    }
    if (*std::min_element(points.begin(), points.end()) != points.front()) {
        return "does not start at its smallest point";
    }
    return {};
}

Int128 twice_area_of(std::span<const Point> points) {
    Int128 sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += cross(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
    }
    return sum;
}

Complaint check_area(const Contour& contour, std::span<const Point> points) {
    const Int128 twice_area = is_closed(contour) ? twice_area_of(points) : 0;
    if (twice_area != to_int128(contour.twice_area)) {
        return "the area is not that of its points";
    }
    if (has_area(contour) ? (twice_area > 0) != (contour.role == Role::outer) || twice_area == 0 : twice_area != 0) {
        return "the area's sign does not suit the role";
    }
    return {};
}

Complaint check_orientation(const Contour& contour) {
    if (!has_area(contour)) {
        if (contour.orientation != 0 || contour.parent != -1 || (contour.flags & orientation_overruled) != 0) {
            return "flat or open, yet with an orientation, a parent or an overruled orientation";
        }
        return {};
    }
    if (contour.orientation != 1 && contour.orientation != -1) {
        return "closed with an area, yet without an orientation";
    }
    const int direction = contour.role == Role::outer ? 1 : -1;
    if ((contour.flags & orientation_overruled) == 0 && contour.orientation != direction) {
        return "runs against its facets, yet is not marked as overruled";
    }
    return {};
}

Complaint check_contour(const Contour& contour, std::span<const Point> points) {
    constexpr unsigned known_flags = orientation_overruled | orientation_mixed | gap_closed | near_contour;
    if (contour.role > Role::open || (contour.flags & ~known_flags) != 0) {
        return "an unknown role or flag";
    }
    if (contour.segments == 0) {
        return "no segments";
    }
    Complaint complaint = check_points(contour, points);
    if (complaint.empty()) {
        complaint = check_area(contour, points);
    }
    return complaint.empty() ? check_orientation(contour) : complaint;
}

Complaint check_layer(const SliceResult& result, std::size_t index) {
    const Layer& layer = result.layers[index];
    std::uint64_t segments = 0;
    for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
        const Contour& contour = result.contours[c];
        Complaint complaint = check_contour(contour, result.points_of(contour));
        if (!complaint.empty()) {
            return layer_place(index, c) + complaint;
        }
        const std::int64_t first = static_cast<std::int64_t>(layer.first_contour);
        const std::int64_t last = first + static_cast<std::int64_t>(layer.contour_count);
        if (contour.parent != -1 && (contour.parent < first || contour.parent >= last)) {
            return layer_place(index, c) + "the parent lies in another layer";
        }
        segments += contour.segments;
    }
    // A fill rule drops some and cuts others in two.
    if (segments != layer.segments && result.region.rule_of(result.first_layer + index) == FillRule::contours) {
        return layer_place(index) + "contours do not use every segment once";
    }
    return complaint_about_nesting(result, index);
}

Complaint check_summary(const SliceResult& result) {
    SliceSummary counted;
    for (const Contour& contour : result.contours) {
        counted.segments += contour.segments;
        counted.holes += contour.role == Role::hole;
        counted.flat_contours += contour.role == Role::flat;
        counted.open_contours += contour.role == Role::open;
        counted.overruled_contours += (contour.flags & orientation_overruled) != 0;
        counted.near_contours += (contour.flags & near_contour) != 0;
    }
    for (const Layer& layer : result.layers) {
        counted.emptied_layers += layer.segments > 0 && layer.contour_count == 0;
    }
    const SliceSummary& summary = result.summary;
    const bool agrees = (counted.segments == summary.segments || !result.region.keeps_contours()) &&
                        counted.holes == summary.holes && counted.flat_contours == summary.flat_contours &&
                        counted.open_contours == summary.open_contours &&
                        counted.overruled_contours == summary.overruled_contours &&
                        counted.near_contours == summary.near_contours && counted.emptied_layers == summary.emptied_layers;
    return agrees ? Complaint{} : "the summary's counts are not those of the contours";
}

Status failed(Complaint complaint, std::size_t layer) {
    Error error;
    error.message = std::move(complaint);
    error.plane = static_cast<std::int64_t>(layer);
    return error;
}

Status check(const SliceResult& result) {
    for (const auto whole : {check_offsets, check_planes, complaint_about_origins}) {
        Complaint complaint = whole(result);
        if (!complaint.empty()) {
            return failed(std::move(complaint), static_cast<std::size_t>(-1));
        }
    }
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        Complaint complaint = check_layer(result, l);
        if (!complaint.empty()) {
            return failed(std::move(complaint), l);
        }
    }
    Complaint complaint = check_summary(result);
    return complaint.empty() ? Status{} : failed(std::move(complaint), static_cast<std::size_t>(-1));
}

}  // namespace

std::string layer_place(std::size_t layer) {
    return "layer " + std::to_string(layer) + ": ";
}

std::string layer_place(std::size_t layer, std::size_t contour) {
    return "layer " + std::to_string(layer) + ", contour " + std::to_string(contour) + ": ";
}

Status validate(const SliceResult& result) noexcept {
    return guarded([&] { return check(result); });
}

}  // namespace lamella
