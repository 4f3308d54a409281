// What is open in a result, and the length that closes it.
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"

using lamella::describe;
using lamella::GapSense;
using lamella::OpenLayers;
using lamella::SliceOptions;
using lamella::SliceResult;
using shapes::Soup;

namespace {

OpenLayers open_of(const SliceResult& result, int threads = 1) {
    const lamella::Result<OpenLayers> open = find_open_layers(result, {.threads = threads});
    REQUIRE(open.ok());
    return *open;
}

Soup without_last_side(Soup box) {
    box.resize(box.size() - 18);
    return box;
}

}  // namespace

TEST_CASE("open layers: their area is not known, and their share of the height is", "[engine][open_layers]") {
    const Soup closed = shapes::box({0, 0, 0}, {10, 20, 30});
    const Soup open = shapes::moved(without_last_side(closed), {0, 0, 30});
    const SliceResult result = sliced(shapes::joined({closed, open}), uniform(1));
    const OpenLayers found = open_of(result);
    CHECK(found.layers == 30);
    CHECK(found.crossed == 60);
    CHECK(found.share() == Approx(0.5));
    CHECK(result.area_mm2(result.layers[3]) == Approx(200));
    CHECK(std::isnan(result.area_mm2(result.layers[40])));
    SliceOptions options = uniform(1);
    options.close_gaps_mm = found.reach_mm;
    const SliceResult joined = sliced(shapes::joined({closed, open}), options);
    CHECK(joined.area_mm2(joined.layers[40]) == Approx(200));
    CHECK(open_of(joined).layers == 0);
}

TEST_CASE("open layers: the length closes all, and a little less does not", "[engine][open_layers]") {
    const Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    Soup torn;
    for (std::size_t i = 0; i < ball.size(); i += 9) {  // but for every 13th triangle
        if (i % (13 * 9) != 0) {
            torn.insert(torn.end(), ball.begin() + static_cast<std::ptrdiff_t>(i),
                        ball.begin() + static_cast<std::ptrdiff_t>(i) + 9);
        }
    }
    for (const GapSense sense : {GapSense::kept, GapSense::any}) {
        SliceOptions options = uniform(0.3);
        options.gap_sense = sense;
        const SliceResult result = sliced(torn, options);
        const OpenLayers found = open_of(result);
        REQUIRE(found.layers > 10);
        CHECK(open_of(result, 3).height_mm == found.height_mm);
        options.close_gaps_mm = found.reach_mm * 0.999;
        const OpenLayers left = open_of(sliced(torn, options));
        CHECK(left.layers > 0);
        CHECK(left.reach_mm == found.reach_mm);
        options.close_gaps_mm = found.reach_mm;
        CHECK(open_of(sliced(torn, options)).layers == 0);
    }
}

TEST_CASE("open layers: ends of two meshes are not joined", "[engine][open_layers]") {
    const Soup one = without_last_side(shapes::box({0, 0, 0}, {10, 10, 10}));
    const Soup other = shapes::moved(one, {1, 0, 0});
    const std::vector<float> a = shapes::floats(one);
    const std::vector<float> b = shapes::floats(other);
    const std::vector<lamella::Part> parts = {{lamella::MeshView::soup(a), {}}, {lamella::MeshView::soup(b), {}}};
    const lamella::Result<SliceResult> both = lamella::slice_parts(parts, uniform(1));
    REQUIRE(both.ok());
    CHECK(open_of(*both).layers == 10);
    CHECK(open_of(*both).reach_mm == open_of(sliced(one, uniform(1))).reach_mm);
}

TEST_CASE("open layers: the words name the length, rounded up to two digits", "[engine][open_layers]") {
    CHECK(describe({37, 412, 0, 8.1, 100, 0.7213}, "--close-gaps ") ==
          "37 of 412 layers (8.1 % of the height) have open contours: their area is not known; --close-gaps 0.73 would "
          "close them");
    CHECK(describe({1, 1, 0, 1, 1, 20}, "close_gaps=") ==
          "1 of 1 layer (100 % of the height) has open contours: its area is not known; close_gaps=20 would close it");
    CHECK(describe({2, 9, 1, 0, 9, 0.00034001}, "")
              .ends_with("(less than 0.1 % of the height) have open contours: their "
                         "area is not known; 0.00035 would close all but 1"));
    CHECK(describe({2, 9, 2, 0, 0, 1231}, "--close-gaps ").ends_with("no length of --close-gaps would close them"));
    CHECK(describe({2, 9, 0, 1, 2, 1231}, "").ends_with("; 1300 would close them"));
}
