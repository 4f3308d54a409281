#include "lamella/result.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "base/numbers.hpp"
#include "lamella/assemble.hpp"
#include "lamella/sink.hpp"

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

}  // namespace lamella
