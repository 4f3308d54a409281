// Gaps in slices: closed by a length that is given or that the mesh gives, in either sense, and what is left open.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/everywhere.hpp"

using lamella::describe;
using lamella::OpenLayers;
using lamella::Point;
using lamella::Role;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::Stitch;
using lamella::StitchDirection;
using shapes::Soup;
using shapes::wall;

namespace {

using Lines = std::vector<std::string>;

SliceResult cut(const Soup& soup, double reach_mm, StitchDirection sense = StitchDirection::oriented) {
    SliceOptions options = at_heights({5});
    options.stitch_mm = reach_mm;
    options.stitch_direction = sense;
    return sliced(soup, options);
}

double length_mm(const SliceResult& result, const Stitch& stitch) {
    return std::hypot(double(stitch.to.x) - stitch.from.x, double(stitch.to.y) - stitch.from.y) * result.info.grid_mm;
}

Soup without_last_side(const Soup& box) {
    return shapes::without(box, 10, 2);
}

OpenLayers open_of(const SliceResult& result, int threads = 1) {
    return value_of(audits::open_layers_of(result, {.threads = threads}));
}

/// A square tube of a metre whose lower wall lacks what lies between x = 495 and 505.
Soup cracked_tube() {
    return shapes::joined({wall({0, 0}, {495, 0}), wall({505, 0}, {1000, 0}), wall({1000, 0}, {1000, 1000}),
                           wall({1000, 1000}, {0, 1000}), wall({0, 1000}, {0, 0})});
}

SliceOptions by_mesh() {
    SliceOptions options = at_heights({3, 5});
    options.stitch_mm = lamella::stitch_by_mesh;
    return options;
}

}  // namespace

TEST_CASE("gaps up to the requested length are closed, and each is reported", "[engine][gaps]") {
    constexpr auto oriented = StitchDirection::oriented;
    constexpr auto any = StitchDirection::any;
    const Soup open = shapes::without(shapes::box({0, 0, 0}, {10, 10, 10}), 4, 2);
    const Soup alike = shapes::joined({wall({0, 0}, {20, 0}), wall({0, 10}, {20, 10})});  // run the same way
    const Soup agreeing = shapes::joined({wall({0, 0}, {10, 0}), wall({14, 0}, {24, 0}), wall({24, 8}, {0, 8})});
    const Lines left_open = {"open 0 x6 in -: 20,0 20,9 20,20 11,20 0,20 0,11 0,0"};
    const Lines apart = {"open 0 x2 in -: 0,0 18,0 40,0", "open 0 x2 in -: 0,20 18,20 40,20"};
    const Lines joined = {"outer + x6 in -: 0,0 9,0 20,0 28,0 37,0 48,0 48,16 26,16 0,16"};
    struct Case {
        Soup soup;
        double reach_mm;
        StitchDirection direction;
        Lines contours;
        std::string stitches;
    };
    const Case cases[] = {
        {open, 0, oriented, left_open, ""},
        {open, 9.9, oriented, left_open, ""},
        // The solid is on the left, so along the missing side the contour runs towards larger x.
        {open, 10, oriented, {"outer + x6 in -: 0,0 20,0 20,9 20,20 11,20 0,20 0,11"}, "0,0 20,0; "},
        {alike, 10, oriented, apart, ""},
        {alike, 9.9, any, apart, ""},
        {alike, 10, any, {"outer + x4 in - mixed: 0,0 18,0 40,0 40,20 18,20 0,20"}, "0,0 0,20; 40,0 40,20; "},
        {agreeing, 8, oriented, joined, "0,16 0,0; 20,0 28,0; 48,0 48,16; "},
        {agreeing, 8, any, joined, "0,16 0,0; 20,0 28,0; 48,0 48,16; "},
    };
    for (const auto& [soup, reach_mm, direction, contours, stitches] : cases) {
        INFO("case of " << reach_mm << " mm, any direction " << (direction == any));
        const SliceResult result = cut(soup, reach_mm, direction);
        CHECK(contours_at(result, 0) == contours);
        std::ostringstream text;
        for (const auto& [layer, from, to] : result.stitches) {
            text << from.x << ',' << from.y << ' ' << to.x << ',' << to.y << "; ";
        }
        CHECK(text.str() == stitches);
        CHECK(((result.contours[0].flags & lamella::stitched) != 0) == !stitches.empty());
        CHECK(result.info.options.stitch_direction == direction);
    }
}

TEST_CASE("the mesh's length is a hundredth of its box's diagonal, and closes a crack", "[engine][gaps]") {
    const Soup tube = cracked_tube();
    const SliceResult closed = sliced(tube, by_mesh());
    CHECK(closed.info.options.stitch_mm == std::sqrt(1000.0 * 1000 + 1000 * 1000 + 10 * 10) / 100);
    CHECK(closed.info.open_contours == 0);
    REQUIRE(closed.stitches.size() == 2);
    CHECK(length_mm(closed, closed.stitches[0]) == 10);
    CHECK(closed[0].area_mm2() == 1e6);
}

TEST_CASE("a gap with a wall in it stays open by the mesh's length, and not by one that is given", "[engine][gaps]") {
    const Soup tube = shapes::joined({cracked_tube(), wall({500, -5}, {500, 5}), wall({500, 5}, {500, -5})});
    const SliceResult open = sliced(tube, by_mesh());
    CHECK(open.info.open_contours > 0);
    SliceOptions given = by_mesh();
    given.stitch_mm = 10;
    const SliceResult closed = sliced(tube, given);
    CHECK(std::any_of(closed.stitches.begin(), closed.stitches.end(),
                      [&](const Stitch& gap) { return length_mm(closed, gap) == 10; }));
    CHECK(std::none_of(open.stitches.begin(), open.stitches.end(),
                       [&](const Stitch& gap) { return length_mm(open, gap) == 10; }));
}

TEST_CASE("the length that closes what is left is no shorter than what was closed", "[engine][gaps][open_layers]") {
    const Soup walled =
        shapes::joined({wall({0, 2000}, {495, 2000}), wall({501, 2000}, {1000, 2000}), wall({1000, 2000}, {0, 2100}),
                        wall({0, 2100}, {0, 2000}), wall({498, 1990}, {498, 2010}), wall({498, 2010}, {498, 1990})});
    const SliceResult result = sliced(shapes::joined({cracked_tube(), walled}), by_mesh());
    const auto open = open_of(result);
    CHECK(open.layers == 2);
    CHECK(open.reach_mm == Approx(10));
}

TEST_CASE("a mesh is stitched by its own box, each of several parts too", "[engine][gaps]") {
    const Soup tube = cracked_tube();
    const SliceResult whole = sliced(tube, by_mesh());
    CHECK(whole.stitches.size() == 2);
    lamella::Transform far;
    far.m[3] = 5000;
    const std::vector<lamella::Part> parts = {{.mesh = view_of(tube)}, {.mesh = view_of(tube), .placement = far}};
    const SliceResult together = sliced(parts, by_mesh());
    CHECK(together.info.options.stitch_mm == whole.info.options.stitch_mm);
    CHECK(together.stitches.size() == 4);
    require_at_every_destination(together, parts, by_mesh());
}

TEST_CASE("open layers: their area is not known, and their share of the height is", "[engine][open_layers]") {
    const Soup closed = shapes::box({0, 0, 0}, {10, 20, 30});
    const Soup open = shapes::moved(without_last_side(closed), {0, 0, 30});
    const SliceResult result = sliced(shapes::joined({closed, open}), uniform(1));
    const OpenLayers found = open_of(result);
    CHECK(found.layers == 30);
    CHECK(found.crossed == 60);
    CHECK(found.share() == Approx(0.5));
    CHECK(result[3].area_mm2() == Approx(200));
    CHECK(std::isnan(result[40].area_mm2()));
    SliceOptions options = uniform(1);
    options.stitch_mm = found.reach_mm;
    const SliceResult joined = sliced(shapes::joined({closed, open}), options);
    CHECK(joined[40].area_mm2() == Approx(200));
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
    for (const StitchDirection sense : {StitchDirection::oriented, StitchDirection::any}) {
        SliceOptions options = uniform(0.3);
        options.stitch_direction = sense;
        const SliceResult result = sliced(torn, options);
        const OpenLayers found = open_of(result);
        REQUIRE(found.layers > 10);
        CHECK(open_of(result, 3).height_mm == found.height_mm);
        options.stitch_mm = found.reach_mm * 0.999;
        const OpenLayers left = open_of(sliced(torn, options));
        CHECK(left.layers > 0);
        CHECK(left.reach_mm == found.reach_mm);
        options.stitch_mm = found.reach_mm;
        CHECK(open_of(sliced(torn, options)).layers == 0);
    }
}

TEST_CASE("open layers: ends of two meshes are not joined", "[engine][open_layers]") {
    const Soup one = without_last_side(shapes::box({0, 0, 0}, {10, 10, 10}));
    const Soup other = shapes::moved(one, {1, 0, 0});
    const std::vector<lamella::Part> parts = {{.mesh = view_of(one)}, {.mesh = view_of(other)}};
    const SliceResult both = sliced(parts, uniform(1));
    CHECK(open_of(both).layers == 10);
    CHECK(open_of(both).reach_mm == open_of(sliced(one, uniform(1))).reach_mm);
}

TEST_CASE("open layers: the words name the length, rounded up to two digits", "[engine][open_layers]") {
    CHECK(describe({37, 412, 0, 8.1, 100, 0.7213}, "--stitch ") ==
          "37 of 412 layers (8.1 % of the height) have open contours: their area is not known; --stitch 0.73 would "
          "close them");
    CHECK(describe({1, 1, 0, 1, 1, 20}, "stitch=") ==
          "1 of 1 layer (100 % of the height) has open contours: its area is not known; stitch=20 would close it");
    CHECK(describe({2, 9, 1, 0, 9, 0.00034001}, "")
              .ends_with("(less than 0.1 % of the height) have open contours: their "
                         "area is not known; 0.00035 would close all but 1"));
    CHECK(describe({2, 9, 2, 0, 0, 1231}, "--stitch ").ends_with("no length of --stitch would close them"));
    CHECK(describe({2, 9, 0, 1, 2, 1231}, "").ends_with("; 1300 would close them"));
}
