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

void add_contour(WordHash& hash, const SliceResult& result, const Layer& layer, const Contour& contour) noexcept {
    hash.add(kind_word(contour));
    hash.add(contour.segments);
    hash.add(contour.point_count);
    hash.add_signed(contour.parent < 0 ? -1 : contour.parent - static_cast<std::int64_t>(layer.first_contour));
    hash.add(contour.twice_area.low);
    hash.add_signed(contour.twice_area.high);
    for (const Point point : result.points_of(contour)) {
        hash.add(point_word(point));
    }
}

}  // namespace

void ResultHash::add_layers(const SliceResult& result) noexcept {
    for (const Layer& layer : result.layers) {
        words_.add_signed(layer.plane.z());
        words_.add(layer.contour_count);
        for (const Contour& contour : result.contours_of(layer)) {
            add_contour(words_, result, layer, contour);
        }
    }
}

std::uint64_t hash_result(const SliceResult& result) noexcept {
    ResultHash hash(result.layers.size());
    hash.add_layers(result);
    return hash.value();
}

}  // namespace lamella
