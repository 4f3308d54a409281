#include <algorithm>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "write/samples.hpp"

namespace lamella::write_test {

namespace {

template <class T>
void fill(Array<T>& array, const std::vector<T>& values) {
    array.resize_discarding(values.size());
    std::ranges::copy(values, array.begin());
}

std::int64_t twice_area(const std::vector<Point>& ring) {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point& a = ring[i];
        const Point& b = ring[(i + 1) % ring.size()];
        sum += std::int64_t{a.x} * b.y - std::int64_t{b.x} * a.y;
    }
    return sum;
}

Contour contour_of(const Ring& ring, std::size_t first_point) {
    const std::int64_t area = ring.role == Role::open || ring.role == Role::flat ? 0 : twice_area(ring.points);
    Contour contour;
    contour.first_point = first_point;
    contour.point_count = static_cast<std::uint32_t>(ring.points.size());
    contour.segments = contour.point_count;
    contour.role = ring.role;
    contour.orientation = static_cast<std::int8_t>((area > 0) - (area < 0));
    contour.twice_area = {static_cast<std::uint64_t>(area), area < 0 ? -1 : 0};
    return contour;
}

}  // namespace

SliceResult result_of(const std::vector<std::vector<Ring>>& layers, double grid_mm) {
    std::vector<Layer> slabs;
    std::vector<Contour> contours;
    std::vector<Point> points;
    SliceResult result;
    for (const std::vector<Ring>& rings : layers) {
        const double bottom = 0.5 * static_cast<double>(slabs.size());
        Layer layer;
        layer.bottom_mm = bottom;
        layer.plane_mm = bottom + 0.25;
        layer.top_mm = bottom + 0.5;
        layer.plane = PlaneHeight(2 * static_cast<std::int32_t>(slabs.size()) + 1);
        layer.first_contour = contours.size();
        layer.contour_count = rings.size();
        for (const Ring& ring : rings) {
            contours.push_back(contour_of(ring, points.size()));
            if (ring.role == Role::hole) {
                contours.back().parent = static_cast<std::int64_t>(contours.size()) - 2;  // the ring before it
            }
            layer.segments += ring.points.size();
            points.insert(points.end(), ring.points.begin(), ring.points.end());
            result.info.holes += static_cast<std::uint64_t>(ring.role == Role::hole);
            result.info.open_contours += static_cast<std::uint64_t>(ring.role == Role::open);
            result.info.flat_contours += static_cast<std::uint64_t>(ring.role == Role::flat);
        }
        result.info.segments += layer.segments;
        slabs.push_back(layer);
    }
    fill(result.layers, slabs);
    fill(result.contours, contours);
    fill(result.points, points);
    result.info.grid_mm = grid_mm;
    result.info.layers = layers.size();
    result.info.contours = contours.size();
    result.info.points = points.size();
    return result;
}

SliceResult square_with_hole() {
    SliceResult result =
        result_of({{{Role::outer, {{0, 0}, {20, 0}, {20, 20}, {0, 20}}}, {Role::hole, {{6, 6}, {6, 14}, {14, 14}, {14, 6}}}},
                   {},
                   {{Role::open, {{1, -3}, {5, 5}}}}},
                  0.5);
    result.info.box.max_mm = {10, 10, 10};
    return result;
}

}  // namespace lamella::write_test

TEST_CASE("samples: what the writers are tested with is a valid result", "[write]") {
    const lamella::SliceResult result = lamella::write_test::square_with_hole();
    require_ok(audits::structure_of(result));
}
