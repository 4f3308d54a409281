#include "audit/structure.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "audit/questions.hpp"
#include "base/guard.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

bool is_closed(const Contour& contour) {
    return contour.role != Role::open;
}

void check_planes(const SliceResult& result) {
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        const ResultPlace at{l};
        at.require(layer.plane.z() % 2 != 0, "the plane lies on an even height, where vertices are");
        at.require(layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm,
                   "the plane is not between bottom and top");
    }
}

void check_points(const Contour& contour, std::span<const Point> points, const ResultPlace& at) {
    at.require(!points.empty(), "no points");
    at.require(std::adjacent_find(points.begin(), points.end()) == points.end(), "equal consecutive points");
    // A polyline has one point more than segments, and keeps it when it is joined to another.
    const std::uint64_t extra = (contour.flags & stitched) != 0 ? contour.segments : (is_closed(contour) ? 0 : 1);
    at.require(contour.point_count <= std::uint64_t{contour.segments} + extra, "more points than its segments have");
    if (is_closed(contour)) {
        at.require(points.size() == 1 || points.front() != points.back(), "the first point is repeated at the end");
        at.require(*std::min_element(points.begin(), points.end()) == points.front(),
                   "does not start at its smallest point");
    }
}

Int128 twice_area_of(std::span<const Point> points) {
    Int128 sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += cross(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
    }
    return sum;
}

void check_area(const Contour& contour, std::span<const Point> points, const ResultPlace& at) {
    const Int128 twice_area = is_closed(contour) ? twice_area_of(points) : 0;
    const int sign = contour.role == Role::outer ? 1 : (contour.role == Role::hole ? -1 : 0);
    at.require(twice_area == to_int128(contour.twice_area), "the area is not that of its points");
    at.require(sign_of(twice_area) == sign, "the area's sign does not suit the role");
}

void check_orientation(const Contour& contour, const ResultPlace& at) {
    const bool overruled = (contour.flags & orientation_overruled) != 0;
    if (!has_area(contour)) {
        at.require(contour.orientation == 0 && contour.parent == -1 && !overruled,
                   "flat or open, yet with an orientation, a parent or an overruled orientation");
        return;
    }
    at.require(contour.orientation == 1 || contour.orientation == -1, "closed with an area, yet without an orientation");
    at.require(overruled || contour.orientation == (contour.role == Role::outer ? 1 : -1),
               "runs against its facets, yet is not marked as overruled");
}

void check_layer(const SliceResult& result, std::size_t index) {
    constexpr unsigned known_flags = orientation_overruled | orientation_mixed | stitched | would_close;
    const Layer& layer = result.layers[index];
    const auto first = static_cast<std::int64_t>(layer.first_contour);
    const auto end = first + static_cast<std::int64_t>(layer.contour_count);
    std::uint64_t segments = 0;
    for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
        const Contour& contour = result.contours[c];
        const std::span<const Point> points = result.points_of(contour);
        const ResultPlace at{index, c};
        at.require(contour.role <= Role::open && (contour.flags & ~known_flags) == 0, "an unknown role or flag");
        at.require(contour.segments > 0, "no segments");
        check_points(contour, points, at);
        check_area(contour, points, at);
        check_orientation(contour, at);
        at.require(contour.parent == -1 || (first <= contour.parent && contour.parent < end),
                   "the parent lies in another layer");
        segments += contour.segments;
    }
    // A fill rule drops some and cuts others in two.
    ResultPlace{index}.require(segments == layer.segments || !keeps_contours(result, index),
                               "contours do not use every segment once");
    check_nesting(result, index);
}

void check_summary(const SliceResult& result) {
    SliceInfo counted;
    for (const Contour& contour : result.contours) {
        counted.segments += contour.segments;
        counted.holes += contour.role == Role::hole;
        counted.flat_contours += contour.role == Role::flat;
        counted.open_contours += contour.role == Role::open;
        counted.overruled_contours += (contour.flags & orientation_overruled) != 0;
        counted.would_close_contours += (contour.flags & would_close) != 0;
    }
    bool all_kept = true;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        counted.emptied_layers += result.layers[l].segments > 0 && result.layers[l].contour_count == 0;
        all_kept = all_kept && keeps_contours(result, l);
    }
    const SliceInfo& info = result.info;
    ResultPlace{}.require((counted.segments == info.segments || !all_kept) && counted.holes == info.holes &&
                              counted.flat_contours == info.flat_contours && counted.open_contours == info.open_contours &&
                              counted.overruled_contours == info.overruled_contours &&
                              counted.would_close_contours == info.would_close_contours &&
                              counted.emptied_layers == info.emptied_layers,
                          "the summary's counts are not those of the contours");
}

}  // namespace

void ResultPlace::require(bool kept, std::string_view broken) const {
    if (kept) {
        return;
    }
    std::string text;
    const auto name = [&](const char* noun, const std::optional<std::size_t>& index) {
        if (index) {
            text += (text.empty() ? "" : ", ") + std::string(noun) + " " + std::to_string(*index);
        }
    };
    name("layer", layer);
    name("contour", contour);
    name("point", point);
    Error error;
    error.message = text + (text.empty() ? "" : ": ") + std::string(broken);
    error.plane = layer ? static_cast<std::int64_t>(*layer) : -1;
    throw Refused{std::move(error)};
}

void check_offsets(const SliceResult& result) {
    std::uint64_t next_contour = 0;
    std::uint64_t next_point = 0;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        const ResultPlace at_layer{l};
        at_layer.require(l == 0 || layer.plane > result.layers[l - 1].plane, "the plane is not above the one before");
        at_layer.require(layer.first_contour == next_contour, "does not begin where the layer before ends");
        at_layer.require(layer.contour_count <= result.contours.size() - next_contour, "reaches past the last contour");
        for (; next_contour < layer.first_contour + layer.contour_count; ++next_contour) {
            const Contour& contour = result.contours[next_contour];
            const ResultPlace at{l, next_contour};
            at.require(contour.first_point == next_point, "does not begin where the contour before ends");
            at.require(contour.point_count <= result.points.size() - next_point, "reaches past the last point");
            next_point += contour.point_count;
        }
    }
    ResultPlace{}.require(next_contour == result.contours.size() && next_point == result.points.size(),
                          "contours or points are left over behind the last layer");
}

void check_structure(const SliceResult& result, std::span<const Part> parts, const Parallel& parallel) {
    check_offsets(result);
    check_planes(result);
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        parallel.stop_if_asked();
        check_layer(result, l);
    }
    check_summary(result);
    check_origins(result, parts);
}

}  // namespace lamella
