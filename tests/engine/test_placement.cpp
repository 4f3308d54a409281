// Where bands put what they yield, whichever of them is done first.
#include <functional>
#include <vector>

#include <catch2/catch.hpp>

#include "8_result/placement.hpp"
#include "base/parallel.hpp"

using lamella::BandOutput;
using lamella::Point;

namespace {

/// A layer of `contours` contours, each one point (band, contour), each in the one before it.
void fill(BandOutput& output, std::int32_t band, std::uint32_t contours) {
    for (std::uint32_t c = 0; c < contours; ++c) {
        *output.reserve_points(1) = {band, static_cast<std::int32_t>(c)};
        lamella::Contour& contour = output.contours.emplace_back();
        contour.first_point = output.point_count++;
        contour.point_count = 1;
        contour.parent = static_cast<std::int64_t>(c) - 1;
    }
    output.layer_contours.push_back(contours);
    output.closed_gaps.push_back({0, {band, 0}, {band, 1}});
}

}  // namespace

TEST_CASE("bands are placed in order, in whatever order they are done", "[engine][placement]") {
    const std::vector<lamella::Band> bands{{0, 1, 2, false}, {1, 2, 3, false}, {2, 3, 4, false}};
    const std::function<void(double)> no_progress;
    for (const std::vector<std::size_t>& done : {std::vector<std::size_t>{0, 1, 2}, {2, 1, 0}, {1, 2, 0}, {1, 0, 2}}) {
        std::vector<Point> points(9);
        lamella::Placement placement(nullptr);
        placement.begin(bands, 2, 9, points, no_progress);
        std::vector<BandOutput*> outputs;
        for (std::size_t band = 0; band < bands.size(); ++band) {
            outputs.push_back(placement.acquire(band));
            REQUIRE(outputs.back() != nullptr);
            fill(*outputs.back(), static_cast<std::int32_t>(band), static_cast<std::uint32_t>(band + 2));
        }
        for (const std::size_t band : done) {
            placement.submit(band, outputs[band]);
        }
        CHECK(points == std::vector<Point>{{0, 0}, {0, 1}, {1, 0}, {1, 1}, {1, 2}, {2, 0}, {2, 1}, {2, 2}, {2, 3}});

        REQUIRE(placement.contour_count() == 9);
        std::vector<lamella::Contour> contours(9);
        std::vector<lamella::Layer> layers(3);
        placement.write_contours(lamella::Parallel(1), contours, layers);
        std::vector<std::int64_t> parents;
        for (std::size_t c = 0; c < contours.size(); ++c) {
            CHECK(contours[c].first_point == c);
            parents.push_back(contours[c].parent);
        }
        CHECK(parents == std::vector<std::int64_t>{-1, 0, -1, 2, 3, -1, 5, 6, 7});
        CHECK(layers[2].first_contour == 5);
        CHECK(layers[2].contour_count == 4);

        REQUIRE(placement.closed_gap_count() == 3);
        std::vector<lamella::ClosedGap> gaps(3);
        placement.write_closed_gaps(gaps);
        for (std::size_t g = 0; g < gaps.size(); ++g) {
            CHECK(gaps[g].layer == g);
            CHECK(gaps[g].from == Point{static_cast<std::int32_t>(g), 0});
        }
    }
}
