#include "lamella/result.hpp"

#include <algorithm>
#include <limits>

#include "base/guard.hpp"
#include "base/numbers.hpp"

namespace lamella {

namespace {

/// Areas carry their sign, so outers minus holes is a plain sum; rounding happens once, at its end. What lies beside an
/// open polyline is solid on one side: how far is not known.
double areas_of(std::span<const Contour> contours, double grid_mm) noexcept {
    Int128 twice_area = 0;
    for (const Contour& contour : contours) {
        if (contour.role == Role::open) {
            return std::numeric_limits<double>::quiet_NaN();
        }
        twice_area += to_int128(contour.twice_area);
    }
    return static_cast<double>(twice_area) / 2 * grid_mm * grid_mm;
}

// The hashed layout is documented with SliceResult::hash(). It is made of values, not of memory, so padding and byte order
// play no part.

std::uint64_t kind_word(const Contour& contour) noexcept {
    const auto orientation = static_cast<std::uint8_t>(contour.orientation);
    return static_cast<std::uint64_t>(contour.role) | std::uint64_t{orientation} << 8 | std::uint64_t{contour.flags} << 16 |
           std::uint64_t{contour.part} << 32;
}

std::uint64_t point_word(Point point) noexcept {
    return static_cast<std::uint32_t>(point.x) | std::uint64_t{static_cast<std::uint32_t>(point.y)} << 32;
}

}  // namespace

double LayerView::area_mm2() const noexcept {
    return areas_of(contours, grid_mm);
}

double LayerView::area_mm2(const Contour& contour) const noexcept {
    return contour.twice_area.to_double() / 2 * grid_mm * grid_mm;
}

LayerView SliceResult::operator[](std::size_t index) const noexcept {
    LayerView view;
    static_cast<Layer&>(view) = layers[index];
    view.index = index;
    view.contours = contours_of(view);
    view.grid_mm = info.grid_mm;
    if (!view.contours.empty()) {
        const Contour& last = view.contours.back();
        view.first_point = view.contours.front().first_point;
        const std::uint64_t count = last.first_point + last.point_count - view.first_point;
        view.points = detail::span_of(points.data() + view.first_point, count);
        if (!origins.empty()) {
            view.origins = detail::span_of(origins.data() + view.first_point, count);
        }
    }
    if (!stitches.empty()) {
        const auto before = [](const Stitch& stitch, std::uint64_t layer) { return stitch.layer < layer; };
        const Stitch* const first = std::lower_bound(stitches.begin(), stitches.end(), index, before);
        view.stitches = {first, std::lower_bound(first, stitches.end(), index + 1, before)};
    }
    return view;
}

Result<SliceResult> SliceResult::copy(const Memory* memory) const noexcept {
    return guarded([&]() -> Result<SliceResult> {
        SliceResult same(memory);
        const auto copy_array = [](const auto& from, auto& to) {
            to.resize_discarding(from.size());
            std::copy(from.begin(), from.end(), to.data());
        };
        copy_array(layers, same.layers);
        copy_array(contours, same.contours);
        copy_array(points, same.points);
        copy_array(origins, same.origins);
        copy_array(stitches, same.stitches);
        same.info = info;
        return same;
    });
}

namespace {

/// FNV-1a with a whole 64-bit word where the original takes a byte: one multiplication a point.
std::uint64_t hashed(std::uint64_t hash, std::uint64_t word) noexcept {
    return (hash ^ word) * 0x100000001b3U;
}

std::uint64_t hash_of(std::uint64_t hash, const LayerView& layer, const Contour& contour) noexcept {
    const std::int64_t parent = contour.parent < 0 ? -1 : contour.parent - static_cast<std::int64_t>(layer.first_contour);
    for (const std::uint64_t word : {kind_word(contour), std::uint64_t{contour.segments}, std::uint64_t{contour.point_count},
                                     static_cast<std::uint64_t>(parent), static_cast<std::uint64_t>(contour.twice_area.low),
                                     static_cast<std::uint64_t>(contour.twice_area.high)}) {
        hash = hashed(hash, word);
    }
    for (const Point point : layer.points_of(contour)) {
        hash = hashed(hash, point_word(point));
    }
    return hash;
}

}  // namespace

LayerHash::LayerHash(std::uint64_t layers) noexcept : hash_(hashed(0xcbf29ce484222325U, layers)) {}

void LayerHash::add(const LayerView& layer) noexcept {
    hash_ = hashed(hash_, static_cast<std::uint64_t>(std::int64_t{layer.plane.z()}));
    hash_ = hashed(hash_, layer.contour_count);
    for (const Contour& contour : layer.contours) {
        hash_ = hash_of(hash_, layer, contour);
    }
}

std::uint64_t SliceResult::hash() const noexcept {
    LayerHash hash(layers.size());
    for (const LayerView layer : *this) {
        hash.add(layer);
    }
    return hash.value();
}

}  // namespace lamella
