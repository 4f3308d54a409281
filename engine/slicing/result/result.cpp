#include "lamella/result.hpp"

#include <cmath>
#include <limits>

#include "base/numbers.hpp"
#include "lamella/assemble.hpp"
#include "lamella/sink.hpp"
#include "slicing/result/hash.hpp"

namespace lamella {

namespace {

/// Areas carry their sign, so outers minus holes is a plain sum; rounding happens once, at its end. What lies beside an
/// open polyline is solid on one side: how far is not known.
double areas_of(std::span<const Contour> contours, double unit_mm) noexcept {
    Int128 twice_area = 0;
    for (const Contour& contour : contours) {
        if (contour.role == Role::open) {
            return std::numeric_limits<double>::quiet_NaN();
        }
        twice_area += to_int128(contour.twice_area);
    }
    return static_cast<double>(twice_area) / 2 * unit_mm * unit_mm;
}

double area_of(const Contour& contour, double unit_mm) noexcept {
    return contour.twice_area.to_double() / 2 * unit_mm * unit_mm;
}

// The hashed layout is documented with hash_result(). It is made of values, not of memory, so padding and byte order play no
// part.

std::uint64_t kind_word(const Contour& contour) noexcept {
    const auto orientation = static_cast<std::uint8_t>(contour.orientation);
    return static_cast<std::uint64_t>(contour.role) | std::uint64_t{orientation} << 8 | std::uint64_t{contour.flags} << 16 |
           std::uint64_t{contour.part} << 32;
}

std::uint64_t point_word(Point point) noexcept {
    return static_cast<std::uint32_t>(point.x) | std::uint64_t{static_cast<std::uint32_t>(point.y)} << 32;
}

}  // namespace

double SliceResult::area_mm2(const Layer& layer) const noexcept {
    return areas_of(contours_of(layer), unit_mm);
}

double LayerView::area_mm2() const noexcept {
    return areas_of(contours, unit_mm);
}

double LayerContours::area_mm2() const noexcept {
    return areas_of(contours.span(), unit_mm);
}

double SliceResult::area_mm2(const Contour& contour) const noexcept {
    return area_of(contour, unit_mm);
}

double LayerContours::area_mm2(const Contour& contour) const noexcept {
    return area_of(contour, unit_mm);
}

double SliceResult::length_mm(const ClosedGap& gap) const noexcept {
    const double dx = static_cast<double>(gap.to.x) - gap.from.x;
    const double dy = static_cast<double>(gap.to.y) - gap.from.y;
    return std::sqrt(dx * dx + dy * dy) * unit_mm;
}

void ResultHash::add_contour(const Layer& layer, const Contour& contour, const Point* points) noexcept {
    add(kind_word(contour));
    add(contour.segments);
    add(contour.point_count);
    add_signed(contour.parent < 0 ? -1 : contour.parent - static_cast<std::int64_t>(layer.first_contour));
    add(contour.twice_area.low);
    add_signed(contour.twice_area.high);
    for (const Point point : std::span(points + contour.first_point, contour.point_count)) {
        add(point_word(point));
    }
}

void ResultHash::add_layer(const Layer& layer, std::span<const Contour> contours, const Point* points) noexcept {
    add_signed(layer.plane.z());
    add(layer.contour_count);
    for (const Contour& contour : contours) {
        add_contour(layer, contour, points);
    }
}

void ResultHash::add_layers(const SliceResult& result) noexcept {
    for (const Layer& layer : result.layers) {
        add_layer(layer, result.contours_of(layer), result.points.data());
    }
}

std::uint64_t hash_result(const SliceResult& result) noexcept {
    ResultHash hash(result.layers.size());
    hash.add_layers(result);
    return hash.value();
}

}  // namespace lamella
