// The layout that is hashed is documented with hash_result(). It is made of values, not of memory, so padding and byte
// order play no part.
#include "slicing/result/hash.hpp"

namespace lamella {

namespace {

std::uint64_t kind_word(const Contour& contour) noexcept {
    const auto orientation = static_cast<std::uint8_t>(contour.orientation);
    return static_cast<std::uint64_t>(contour.role) | std::uint64_t{orientation} << 8 | std::uint64_t{contour.flags} << 16 |
           std::uint64_t{contour.part} << 32;
}

std::uint64_t point_word(Point point) noexcept {
    return static_cast<std::uint32_t>(point.x) | std::uint64_t{static_cast<std::uint32_t>(point.y)} << 32;
}

}  // namespace

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
