// Gaps in slices: closed by a length that is given or that the mesh gives, in either sense, and what is left open.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/audit/open_layers.hpp"
#include "lamella/prepare.hpp"
#include "lamella/sink.hpp"

using lamella::describe;
using lamella::GapSense;
using lamella::OpenLayers;
using lamella::Point;
using lamella::Role;
using lamella::SliceOptions;
using lamella::SliceResult;
using shapes::Soup;
using shapes::wall;

namespace {

SliceResult cut(const Soup& soup, double reach_mm, GapSense sense = GapSense::kept) {
    SliceOptions options = at_heights({5});
    options.close_gaps_mm = reach_mm;
    options.gap_sense = sense;
    return sliced(soup, options);
}

Soup without_last_side(const Soup& box) {
    return shapes::without(box, 10, 2);
}

OpenLayers open_of(const SliceResult& result, int threads = 1) {
    return value_of(find_open_layers(result, {.threads = threads}));
}

/// A square tube of a metre whose lower wall lacks what lies between x = 495 and 505.
Soup cracked_tube() {
    return shapes::joined({wall({0, 0}, {495, 0}), wall({505, 0}, {1000, 0}), wall({1000, 0}, {1000, 1000}),
                           wall({1000, 1000}, {0, 1000}), wall({0, 1000}, {0, 0})});
}

SliceOptions by_mesh() {
    SliceOptions options = at_heights({3, 5});
    options.close_gaps_mm = lamella::gaps_by_mesh;
    return options;
}

}  // namespace

TEST_CASE("gaps up to the requested length are closed, and each is reported", "[engine][gaps]") {
    const Soup soup = shapes::without(shapes::box({0, 0, 0}, {10, 10, 10}), 4, 2);
    const SliceResult open = cut(soup, 0);
    REQUIRE(open.contours.size() == 1);
    CHECK(open.contours[0].role == Role::open);
    CHECK(open.closed_gaps.empty());
    const SliceResult short_reach = cut(soup, 9.9);
    CHECK(hash_result(short_reach) == hash_result(open));
    CHECK(short_reach.closed_gaps.empty());

    const SliceResult closed = cut(soup, 10);
    REQUIRE(closed.contours.size() == 1);
    CHECK(closed.contours[0].role == Role::outer);
    CHECK((closed.contours[0].flags & lamella::gap_closed) != 0);
    CHECK(closed.area_mm2(closed.layers[0]) == 100);
    REQUIRE(closed.closed_gaps.size() == 1);
    CHECK(closed.closed_gaps[0].layer == 0);
    CHECK(closed.length_mm(closed.closed_gaps[0]) == 10);
    // The solid is on the left, so along the missing side the contour runs towards larger x.
    CHECK(closed.closed_gaps[0].from == lamella::Point{0, 0});
    CHECK(closed.closed_gaps[0].to == lamella::Point{20, 0});
}

TEST_CASE("the nearest ends are joined first", "[engine][gaps]") {
    // Two walls of a channel. One has a gap of 4 in its middle; the walls are 8 apart.
    const Soup soup = shapes::joined({wall({0, 0}, {10, 0}), wall({14, 0}, {24, 0}), wall({24, 8}, {0, 8})});
    const SliceResult near = cut(soup, 5);
    REQUIRE(near.closed_gaps.size() == 1);
    CHECK(near.length_mm(near.closed_gaps[0]) == 4);
    CHECK(near.summary.open_contours == 2);
    const SliceResult all = cut(soup, 8);
    REQUIRE(all.closed_gaps.size() == 3);
    CHECK(all.summary.open_contours == 0);
    CHECK(all.contours.size() == 1);
    CHECK(all.area_mm2(all.layers[0]) == 24 * 8);
    CHECK(std::accumulate(all.closed_gaps.begin(), all.closed_gaps.end(), 0.0,
                          [&](double sum, const auto& gap) { return sum + all.length_mm(gap); }) == 4 + 8 + 8);
}

TEST_CASE("a length of gaps that is none is refused", "[engine][gaps]") {
    SliceOptions options = at_heights({5});
    for (const double reach : {-0.5, std::nan(""), HUGE_VAL}) {
        options.close_gaps_mm = reach;
        CHECK(failure_of(view_of(shapes::box({0, 0, 0}, {10, 10, 10})), options).code ==
              lamella::ErrorCode::invalid_argument);
    }
}

TEST_CASE("two walls that run the same way close in any sense only", "[engine][gaps]") {
    const Soup soup = shapes::joined({wall({0, 0}, {20, 0}), wall({0, 10}, {20, 10})});
    const SliceResult kept = cut(soup, 10, GapSense::kept);
    CHECK(kept.summary.open_contours == 2);
    CHECK(kept.closed_gaps.empty());
    const SliceResult any = cut(soup, 10, GapSense::any);
    REQUIRE(any.contours.size() == 1);
    CHECK(any.contours[0].role == Role::outer);
    CHECK(any.contours[0].flags == (lamella::gap_closed | lamella::orientation_mixed));
    CHECK(any.contours[0].segments == 4);
    CHECK(any.area_mm2(any.layers[0]) == 200);
    CHECK(any.gap_sense == GapSense::any);
    REQUIRE(any.closed_gaps.size() == 2);
    CHECK(any.closed_gaps[0].from == Point{0, 0});
    CHECK(any.closed_gaps[0].to == Point{0, 20});
    CHECK(any.closed_gaps[1].from == Point{40, 0});
    CHECK(any.closed_gaps[1].to == Point{40, 20});
    CHECK(cut(soup, 9.9, GapSense::any).closed_gaps.empty());
}

TEST_CASE("a wall against two others is the one that is turned", "[engine][gaps]") {
    const Soup soup = shapes::joined({wall({0, 0}, {20, 0}), wall({40, 0}, {21, 0}), wall({41, 0}, {60, 0})});
    const SliceResult any = cut(soup, 1, GapSense::any);
    REQUIRE(any.contours.size() == 1);
    CHECK(any.contours[0].role == Role::open);
    CHECK((any.contours[0].flags & lamella::orientation_mixed) != 0);
    const auto points = any.points_of(any.contours[0]);
    CHECK(points.front() == Point{0, 0});
    CHECK(points.back() == Point{120, 0});
    const SliceResult mirrored =
        cut(shapes::joined({wall({20, 0}, {0, 0}), wall({21, 0}, {40, 0}), wall({60, 0}, {41, 0})}), 1, GapSense::any);
    REQUIRE(mirrored.contours.size() == 1);
    CHECK(mirrored.points_of(mirrored.contours[0]).front() == Point{120, 0});
}

TEST_CASE("walls that agree are joined alike in both senses", "[engine][gaps]") {
    const Soup soup = shapes::joined({wall({0, 0}, {10, 0}), wall({14, 0}, {24, 0}), wall({24, 8}, {0, 8})});
    const SliceResult any = cut(soup, 8, GapSense::any);
    CHECK(hash_result(any) == hash_result(cut(soup, 8, GapSense::kept)));
    CHECK(any.contours[0].flags == lamella::gap_closed);
}

TEST_CASE("the mesh's length is a hundredth of its box's diagonal, and closes a crack", "[engine][gaps]") {
    const Soup tube = cracked_tube();
    const SliceResult closed = sliced(tube, by_mesh());
    CHECK(closed.close_gaps_mm == std::sqrt(1000.0 * 1000 + 1000 * 1000 + 10 * 10) / 100);
    CHECK(closed.summary.open_contours == 0);
    REQUIRE(closed.closed_gaps.size() == 2);
    CHECK(closed.length_mm(closed.closed_gaps[0]) == 10);
    CHECK(closed.area_mm2(closed.layers[0]) == 1e6);
}

TEST_CASE("a gap with a wall in it stays open by the mesh's length, and not by one that is given", "[engine][gaps]") {
    const Soup tube = shapes::joined({cracked_tube(), wall({500, -5}, {500, 5}), wall({500, 5}, {500, -5})});
    const SliceResult open = sliced(tube, by_mesh());
    CHECK(open.summary.open_contours > 0);
    SliceOptions given = by_mesh();
    given.close_gaps_mm = 10;
    const SliceResult closed = sliced(tube, given);
    CHECK(std::any_of(closed.closed_gaps.begin(), closed.closed_gaps.end(),
                      [&](const lamella::ClosedGap& gap) { return closed.length_mm(gap) == 10; }));
    CHECK(std::none_of(open.closed_gaps.begin(), open.closed_gaps.end(),
                       [&](const lamella::ClosedGap& gap) { return open.length_mm(gap) == 10; }));
}

TEST_CASE("the length that closes what is left is no shorter than what was closed", "[engine][gaps][open_layers]") {
    const Soup walled =
        shapes::joined({wall({0, 2000}, {495, 2000}), wall({501, 2000}, {1000, 2000}), wall({1000, 2000}, {0, 2100}),
                        wall({0, 2100}, {0, 2000}), wall({498, 1990}, {498, 2010}), wall({498, 2010}, {498, 1990})});
    const SliceResult result = sliced(shapes::joined({cracked_tube(), walled}), by_mesh());
    const auto open = value_of(lamella::find_open_layers(result));
    CHECK(open.layers == 2);
    CHECK(open.reach_mm == Approx(10));
}

TEST_CASE("parts close gaps by their own boxes; a prepared mesh and a sink by the mesh's", "[engine][gaps]") {
    const Soup tube = cracked_tube();
    const SliceResult whole = sliced(tube, by_mesh());
    const lamella::MeshView mesh = lamella::MeshView::soup(tube);

    lamella::Transform far;
    far.m[3] = 5000;
    const lamella::Part parts[] = {{mesh, {}}, {mesh, far}};
    const auto together = value_of(lamella::slice_parts(parts, by_mesh()));
    CHECK(together.close_gaps_mm == whole.close_gaps_mm);
    CHECK(together.closed_gaps.size() == 4);

    const auto prepared = value_of(lamella::prepare(mesh, {.unit_mm = by_mesh().unit_mm}));
    const auto again = value_of(lamella::slice(prepared, by_mesh()));
    CHECK(lamella::hash_result(again) == lamella::hash_result(whole));
    CHECK(again.close_gaps_mm == whole.close_gaps_mm);

    std::uint64_t gaps = 0;
    const auto count = [&](const lamella::LayerView& view) noexcept { gaps += view.closed_gaps.size(); };
    const auto totals =
        value_of(lamella::slice_to(lamella::LayerSink::to(count, lamella::SinkOrder::ascending), mesh, by_mesh()));
    CHECK(gaps == 2);
    CHECK(totals.close_gaps_mm == whole.close_gaps_mm);
}

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
    const SliceResult both = value_of(lamella::slice_parts(parts, uniform(1)));
    CHECK(open_of(both).layers == 10);
    CHECK(open_of(both).reach_mm == open_of(sliced(one, uniform(1))).reach_mm);
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
