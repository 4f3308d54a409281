#include "medical/raster/solid_contours.hpp"

#include <cmath>
#include <utility>

#include "base/guard.hpp"
#include "lamella/region.hpp"

namespace lamella {

std::span<const std::span<const Point>> SolidContours::of(const SliceResult& result, const Layer& layer) {
    if (layer_ == &layer) {
        return contours_;
    }
    layer_ = &layer;
    contours_.clear();
    for (const Contour& contour : result.contours_of(layer)) {
        if (contour.role == Role::outer || contour.role == Role::hole) {
            contours_.push_back(result.points_of(contour));
        }
    }
    const auto index = static_cast<std::uint64_t>(&layer - result.layers.data());
    const bool apart = result.part_count > 1 && result.part_regions == PartRegions::separate;
    if (!apart && result.region.rule_of(result.first_layer + index) != FillRule::contours) {
        return contours_;
    }
    RegionRules rules{.fill_rule = FillRule::non_zero, .fill_from = {}};
    Result<LayerContours> united = region_of(contours_, rules);
    if (!united) {
        throw Refused{united.error()};
    }
    united_ = std::move(united).value();
    contours_.clear();
    for (const Contour& contour : united_.contours) {
        contours_.emplace_back(united_.points.data() + contour.first_point, contour.point_count);
    }
    return contours_;
}

double perimeter_of(std::span<const Point> points) noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        const Point& q = points[i + 1 < points.size() ? i + 1 : 0];
        sum += std::sqrt(std::pow(static_cast<double>(std::int64_t{q.x} - p.x), 2) +
                         std::pow(static_cast<double>(std::int64_t{q.y} - p.y), 2));
    }
    return sum;
}

}  // namespace lamella
