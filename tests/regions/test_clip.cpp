// Polylines clipped by regions, judged on lattices piece by piece by winding numbers, and by laws in general position.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/overlay.hpp"
#include "regions/given.hpp"
#include "regions/region.hpp"

using namespace lamella;
using polygons::reversed;
using regions::Given;
using regions::Polygon;
using regions::Polygons;

namespace {

SliceResult clipped(const Layers& lines, const LayerSet& by, const ClipOptions& options = {}, const Context& context = {}) {
    SliceResult result;
    const SliceInfo info = value_of(Overlay().clip(result, lines, by, options, context));
    CHECK(info.open_contours == result.contours.size());
    require_ok(audits::structure_of(result));
    return result;
}

/// Of the first layer, by polyline.
std::vector<Polygons> pieces_of(const SliceResult& result, std::size_t polylines) {
    std::vector<Polygons> pieces(polylines);
    for (const Contour& contour : result[0].contours) {
        REQUIRE(contour.role == Role::open);
        const auto points = result.points_of(contour);
        pieces.at(contour.part).emplace_back(points.begin(), points.end());
    }
    return pieces;
}

Polygons clipped(const Polygon& line, const Polygons& by, const ClipOptions& options = {}) {
    const Polygons lines = {line};
    return pieces_of(clipped(Given(lines).set, {.layers = Given(by).set}, options), 1)[0];
}

/// What is filled just beside the middle between two points, by half a unit at most: on the left, or on the right.
bool is_filled_beside(Point from, Point to, bool left, const Polygons& region, FillRule rule) {
    constexpr std::int64_t finer = std::int64_t{1} << 31;
    const std::int64_t sign = left ? 1 : -1;
    const rings::Place beside{Int128{std::int64_t{from.x} + to.x} * finer - sign * (std::int64_t{to.y} - from.y),
                              Int128{std::int64_t{from.y} + to.y} * finer + sign * (std::int64_t{to.x} - from.x), 2 * finer};
    int winding = 0;
    for (const Polygon& ring : region) {
        winding += rings::winding(ring, beside).value();
    }
    return regions::fills(rule, winding);
}

/// The ends of an edge and all points where lines along edges of the region cross it, which are grid points; in order.
Polygon stops_along(Point a, Point b, const Polygons& region) {
    const auto along = [=](Point p) {
        return (std::int64_t{p.x} - a.x) * (std::int64_t{b.x} - a.x) + (std::int64_t{p.y} - a.y) * (std::int64_t{b.y} - a.y);
    };
    Polygon stops = {a, b};
    for (const Polygon& ring : region) {
        rings::each_edge(ring, [&](Point p, Point q) {
            const Int128 of_a = rings::cross(p, q, a);
            const Int128 whole = of_a - rings::cross(p, q, b);
            if (whole == 0 || (whole > 0 ? of_a < 0 || of_a > whole : of_a > 0 || of_a < whole)) {
                return;
            }
            const Int128 x = of_a * (b.x - a.x);
            const Int128 y = of_a * (b.y - a.y);
            REQUIRE((x % whole == 0 && y % whole == 0));
            stops.push_back({static_cast<std::int32_t>(a.x + x / whole), static_cast<std::int32_t>(a.y + y / whole)});
        });
    }
    std::sort(stops.begin(), stops.end(), [&](Point p, Point q) { return along(p) < along(q); });
    stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
    return stops;
}

/// Of a polyline, between two stops.
struct Stretch {
    Point from;
    Point to;
    bool wanted;
    bool to_corner;
};

/// By looking beside each stretch.
Polygons expected_pieces(const Polygon& line, bool closed, const Polygons& region, FillRule rule, ClipOptions options) {
    std::vector<Stretch> stretches;
    for (std::size_t i = 0; i + (closed ? 0 : 1) < line.size(); ++i) {
        const Polygon stops = stops_along(line[i], line[(i + 1) % line.size()], region);
        for (std::size_t s = 0; s + 1 < stops.size(); ++s) {
            const bool left = is_filled_beside(stops[s], stops[s + 1], true, region, rule);
            const bool right = is_filled_beside(stops[s], stops[s + 1], false, region, rule);
            const bool inside = left == right ? left : options.boundary_is_inside;
            stretches.push_back({stops[s], stops[s + 1], inside == options.inside, s + 2 == stops.size()});
        }
    }
    Polygons pieces;
    for (std::size_t k = 0; k < stretches.size(); ++k) {
        const auto [from, to, wanted, to_corner] = stretches[k];
        if (wanted && (k == 0 || !stretches[k - 1].wanted)) {
            pieces.push_back({from});
        }
        if (wanted && (to_corner || !stretches[k + 1].wanted)) {
            pieces.back().push_back(to);
        }
    }
    if (closed && pieces.size() > 1 && stretches.front().wanted && stretches.back().wanted) {
        pieces.back().insert(pieces.back().end(), pieces[0].begin() + 1, pieces[0].end());
        pieces.erase(pieces.begin());
    }
    return pieces;
}

double length_of(const Polygons& lines) {
    double sum = 0;
    for (const Polygon& line : lines) {
        for (std::size_t i = 1; i < line.size(); ++i) {
            sum += std::hypot(double(line[i].x) - line[i - 1].x, double(line[i].y) - line[i - 1].y);
        }
    }
    return sum;
}

}  // namespace

TEST_CASE("lines across, beside and along a square have the known pieces", "[regions][clip]") {
    const Polygons four = {polygons::box(0, 0, 4, 4)};
    const ClipOptions outside{.inside = false};
    const ClipOptions open{.boundary_is_inside = false};
    CHECK(clipped({{-2, 2}, {6, 2}}, four) == Polygons{{{0, 2}, {4, 2}}});
    CHECK(clipped({{-2, 2}, {6, 2}}, four, outside) == Polygons{{{-2, 2}, {0, 2}}, {{4, 2}, {6, 2}}});
    CHECK(clipped({{-4, 4}, {4, -4}}, four).empty());  // touches a corner
    CHECK(clipped({{-4, 4}, {4, -4}}, four, outside) == Polygons{{{-4, 4}, {4, -4}}});
    CHECK(clipped({{0, 0}, {4, 0}}, four) == Polygons{{{0, 0}, {4, 0}}});
    CHECK(clipped({{0, 0}, {4, 0}}, four, open).empty());
    CHECK(clipped({{-1, 0}, {5, 0}}, four, {.inside = false, .boundary_is_inside = false}) == Polygons{{{-1, 0}, {5, 0}}});
    CHECK(clipped({{1, 1}, {3, 3}, {3, 1}, {1, 3}}, four) == Polygons{{{1, 1}, {3, 3}, {3, 1}, {1, 3}}});
    CHECK(clipped({{1, 1}, {1, 1}, {3, 3}, {3, 3}}, four) == Polygons{{{1, 1}, {3, 3}}});
    CHECK(clipped({{1, 1}, {1, 1}}, four).empty());
    CHECK(clipped({}, four).empty());
    CHECK(clipped({{-1, 0}, {1, 0}}, {}, outside) == Polygons{{{-1, 0}, {1, 0}}});
    // Between two that share an edge; and from the shared edge into the one.
    const Polygons pair = {polygons::box(0, 0, 2, 2), polygons::box(2, 0, 4, 2)};
    CHECK(clipped({{2, -1}, {2, 1}, {3, 1}}, pair, open) == Polygons{{{2, 0}, {2, 1}, {3, 1}}});
    // Pieces that rounding makes a point; and one that it does not.
    const Polygons sliver = {{{0, 0}, {100, 0}, {100, 1}}};
    CHECK(clipped({{20, -7}, {20, 8}}, sliver).empty());
    CHECK(clipped({{80, -7}, {80, 8}}, sliver) == Polygons{{{80, 0}, {80, 1}}});
    constexpr std::int32_t far = grid_limit;
    const Polygons everything = {polygons::box(-far, -far, far, far)};
    CHECK(clipped({{-far, -far}, {far, far}}, everything) == Polygons{{{-far, -far}, {far, far}}});
    CHECK(clipped({{-far, far - 1}, {far, 1 - far}}, {{{-far, -far}, {far, -far}, {far, far}}}) ==
          Polygons{{{0, 0}, {far, 1 - far}}});
}

TEST_CASE("on a lattice each piece between crossings is kept if winding numbers beside it say so", "[regions][clip]") {
    std::mt19937 random(3);
    for (int round = 0; round < 5000; ++round) {
        const Polygons region = polygons::lattice_points(random, 1 + random() % 3, 1 + random() % 9, 4, 360'360);
        const FillRule rule = random() % 2 == 0 ? FillRule::even_odd : FillRule::non_zero;
        const ClipOptions options{random() % 2 == 0, random() % 2 == 0};
        Polygons lines = polygons::lattice_points(random, 1 + random() % 4, 1 + random() % 6, 4, 360'360);
        const Given raw(region);
        const SliceResult filled = value_of(regions::region(region, {.fill_rule = rule}, 1));
        const LayerSet by = random() % 2 == 0 ? LayerSet{.layers = raw.set, .fill_rule = rule} : LayerSet{.layers = filled};
        INFO("round " << round << ": " << regions::text_of(region) << " clips " << regions::text_of(lines));
        const auto found = pieces_of(clipped(Given(lines).set, by, options), lines.size());
        std::transform(lines.begin(), lines.end(), lines.begin(), reversed);
        const auto backwards = pieces_of(clipped(Given(lines).set, by, options), lines.size());
        for (std::size_t i = 0; i < lines.size(); ++i) {
            Polygon line = reversed(lines[i]);
            line.erase(std::unique(line.begin(), line.end()), line.end());
            REQUIRE(found[i] == expected_pieces(line, false, region, rule, options));
            Polygons turned(backwards[i].rbegin(), backwards[i].rend());
            std::transform(turned.begin(), turned.end(), turned.begin(), reversed);
            REQUIRE(found[i] == turned);
        }
        // Closed ones: the region's, clipped by what the lines bound.
        const Polygons own = regions::rings_of(filled);
        const auto around = pieces_of(clipped(filled, {.layers = Given(lines).set, .fill_rule = rule}, options), own.size());
        for (std::size_t i = 0; i < own.size(); ++i) {
            REQUIRE(around[i] == expected_pieces(own[i], true, lines, rule, options));
        }
    }
}

TEST_CASE("in general position pieces add up to the lines, and lie where they should", "[regions][clip]") {
    std::mt19937 random(5);
    for (int round = 0; round < 300; ++round) {
        const double radius = std::array<double, 3>{20000, 1 << 20, grid_limit}[std::size_t(round % 3)];
        const auto any = [&] { return polygons::rounded(polygons::between(random, -radius, radius)); };
        Polygons region = {polygons::star(random, 40, radius / 4, radius)};  // and discs with holes, of long runs
        for (int i = polygons::below(random, 8); i > 0; --i) {
            const Polygon disc = polygons::round({any() / 2, any() / 2}, radius / (2 + random() % 9), 200);
            region.push_back(disc);
            region.push_back(reversed(disc));
            for (Point& p : region.back()) {
                p = {p.x / 2 + disc[0].x / 4, p.y / 2 + disc[0].y / 4};
            }
        }
        Polygons lines(8);
        for (Polygon& line : lines) {
            std::generate_n(std::back_inserter(line), 2 + random() % 9, [&] { return Point{any(), any()}; });
            line.erase(std::unique(line.begin(), line.end()), line.end());
        }
        const SliceResult filled = value_of(regions::region(region, {.fill_rule = FillRule::non_zero}, 1));
        const Polygons rings = regions::rings_of(filled);
        const Polygons shuffled = regions::shuffled(region, static_cast<std::uint32_t>(round));
        CHECK(clipped(Given(lines).set, {.layers = Given(region).set}).hash() ==
              clipped(Given(lines).set, {.layers = Given(shuffled).set}).hash());
        Polygons all;
        for (const bool inside : {true, false}) {
            for (const Polygon& piece : regions::rings_of(clipped(Given(lines).set, {.layers = filled}, {inside}))) {
                for (std::size_t p = 1; p < piece.size(); ++p) {
                    const bool is_long = std::abs(std::int64_t{piece[p].x} - piece[p - 1].x) > 1000;
                    REQUIRE(
                        (!is_long || inside == is_filled_beside(piece[p - 1], piece[p], true, rings, FillRule::positive)));
                }
                all.push_back(piece);
            }
        }
        REQUIRE(length_of(all) == Approx(length_of(lines)).epsilon(1e-9).margin(2 * double(all.size())));
    }
}

TEST_CASE("a stack is clipped layer by layer, by any threads and to any destination", "[regions][clip][threads]") {
    const SliceResult ball = sliced(shapes::octasphere({0, 0, 10}, 10, 4), uniform(0.5));
    const SliceResult bar = sliced(shapes::box({-20, -2, 0}, {20, 3, 20}), uniform(0.5));
    const LayerSet by{.layers = bar, .grow_mm = 0.5};
    const SliceResult one = clipped(ball, by, {}, {.threads = 1});
    REQUIRE(one.size() == ball.size());
    CHECK(one.hash() == clipped(ball, by, {}, {.threads = 5}).hash());
    for (std::size_t n = 0; n < one.size(); ++n) {
        CHECK(one[n].plane == ball[n].plane);
        const LayerView line = ball[n];
        const LayerView region = bar[n];
        const SliceResult alone = clipped(line, {.layers = region, .grow_mm = 0.5});
        CHECK(regions::rings_of(alone) == regions::rings_of(one[n]));
    }
    const Polygons wide = {polygons::box(-(1 << 26), -(1 << 26), 1 << 26, 1 << 26)};
    const SliceResult whole = clipped(bar, {.layers = Given(wide, default_grid_mm).set});
    CHECK(whole.points.size() == bar.points.size() + bar.size());
    CHECK(clipped(bar, {.layers = bar}).hash() == whole.hash());
    CHECK(clipped(bar, {.layers = bar, .from = 1, .to = 1})[bar.size() - 1].contours.empty());
    // An answer is input again: it has polylines, and bounds nothing.
    CHECK(clipped(one, by).points.size() == one.points.size());
    CHECK(clipped(ball, {.layers = one}).contours.empty());
    std::size_t taken = 0;
    auto take = [&](const LayerView& layer) noexcept { taken += layer.contours.size(); };
    REQUIRE(Overlay().clip(LayerSink{.take = take}, ball, by).ok());
    CHECK(taken == one.contours.size());
}

TEST_CASE("what cannot be clipped is one clear error", "[regions][clip]") {
    Overlay overlay;
    SliceResult result;
    const auto message = [&](const Layers& lines, const LayerSet& by) {
        return error_of(overlay.clip(result, lines, by)).message;
    };
    const Polygons line = {{{-1, 1}, {5, 1}}};
    const Polygons four = {polygons::box(0, 0, 4, 4)};
    const Polygons far = {{{0, 0}, {grid_limit + 1, 0}}};
    const Given lines(line);
    const Given by(four);
    CHECK(message(lines.set, {.layers = Given(four, 0.5).set}) ==
          "set 1: its grid unit is 0.5 mm, and another set's 1 mm: slice both on one grid");
    CHECK(message(Given(far).set, {.layers = by.set}).find("set 0: a point with the coordinate 1073741825 lies") == 0);
    CHECK(message(lines.set, {.layers = by.set, .from = 1}) == "set 1: layers from 1 to 0 are none");
    CHECK(message(lines.set, {.layers = by.set, .fill_rule = FillRule::contours}).find("set 1: the fill rule of a set") ==
          0);
    const SliceResult low = sliced(shapes::box({0, 0, 0}, {4, 4, 4}), uniform(1));
    const SliceResult high = sliced(shapes::box({0, 0, 1}, {4, 4, 5}), uniform(1));
    CHECK(message(low, {.layers = high}).find("set 1: its layer 0 lies at 1.") == 0);
    constexpr std::uint64_t bytes = 2 * sizeof(Point) + sizeof(Contour);
    CHECK(overlay.clip(result, lines.set, {.layers = by.set}, {}, {.memory_limit_bytes = bytes}).ok());
    CHECK(overlay.clip(result, lines.set, {.layers = by.set}, {}, {.memory_limit_bytes = bytes - 1}).error().code ==
          ErrorCode::result_too_large);
    CHECK(message(result, {.layers = by.set}) == "the answer cannot take the place of one of the sets");
}
