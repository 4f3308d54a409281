// Polylines clipped by regions, judged on lattices piece by piece by winding numbers, and by laws in general position.
#include <algorithm>
#include <functional>
#include <random>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "engine/counting_memory.hpp"
#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/overlay.hpp"
#include "regions/region.hpp"

using namespace lamella;
using regions::Polygon;
using regions::Polygons;

namespace {

/// Contours that a set, or polylines that a call refers to.
struct GivenPaths {
    explicit GivenPaths(const Polygons& paths, double grid_mm = 1) : views(paths.begin(), paths.end()) {
        set.grid_mm = grid_mm;
    }
    operator Layers() const noexcept { return set; }

    std::vector<std::span<const Point>> views;
    ContourSet set{.contours = views};
};

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
    return pieces_of(clipped(GivenPaths(lines), {.layers = GivenPaths(by)}, options), 1)[0];
}

Polygon square(std::int32_t low, std::int32_t high) {
    return polygons::box(low, low, high, high);
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

/// Points of a lattice on which all lines through two of them cross on the grid.
Polygon drawn(std::mt19937& random, int most) {
    constexpr std::int32_t cell = 360'360;
    Polygon points(static_cast<std::size_t>(1 + polygons::below(random, most)));
    for (Point& p : points) {
        p = {polygons::below(random, 4) * cell, polygons::below(random, 4) * cell};
    }
    return points;
}

Polygon reversed(Polygon line) {
    std::reverse(line.begin(), line.end());
    return line;
}

/// 0 to 7 discs side by side or one in the other, with holes: contours of many edges that do not turn.
Polygons discs(std::mt19937& random, double radius) {
    Polygons all;
    for (int i = polygons::below(random, 8); i > 0; --i) {
        const Point centre{polygons::rounded(polygons::between(random, -radius, radius)),
                           polygons::rounded(polygons::between(random, -radius, radius))};
        const double own = polygons::between(random, 0.05, 0.4) * radius;
        all.push_back({});
        all.push_back({});
        for (int corner = 0; corner < 200; ++corner) {
            all[all.size() - 2].push_back(polygons::at_angle(centre, own, corner * 0.031415926));
            all.back().push_back(polygons::at_angle(centre, own / 2, corner * -0.031415926));
        }
    }
    return all;
}

/// Requires that pieces inside and outside, one after the other, are the line, but for points where it is cut.
void require_line(const Polygon& line, const Polygons& inside, const Polygons& outside) {
    std::size_t in = 0;
    std::size_t out = 0;
    std::size_t given = 1;  // of the line, found
    Point at = line[0];
    while (in < inside.size() || out < outside.size()) {
        const bool from_inside = in < inside.size() && inside[in][0] == at;
        const Polygon& piece = from_inside ? inside[in++] : outside.at(out++);
        REQUIRE(piece[0] == at);
        REQUIRE(piece.size() > 1);
        for (std::size_t i = 1; i < piece.size(); ++i) {
            at = piece[i];
            if (given < line.size() && at == line[given]) {
                ++given;
            } else {
                REQUIRE(i + 1 == piece.size());
                const Int128 off = rings::cross(line[given - 1], line.at(given), at);
                const Int128 length = std::abs(std::int64_t{line[given].x} - line[given - 1].x) +
                                      std::abs(std::int64_t{line[given].y} - line[given - 1].y);
                REQUIRE((off <= length && -off <= length));
            }
        }
    }
    REQUIRE(given == line.size());
}

}  // namespace

TEST_CASE("lines across, beside and along a square have the known pieces", "[regions][clip]") {
    const Polygons four = {square(0, 4)};
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
    CHECK(clipped({{-1, 0}, {1, 0}}, {}).empty());
    CHECK(clipped({{-1, 0}, {1, 0}}, {}, outside) == Polygons{{{-1, 0}, {1, 0}}});
    // Between two that share an edge; and from the shared edge into the one.
    const Polygons pair = {polygons::box(0, 0, 2, 2), polygons::box(2, 0, 4, 2)};
    CHECK(clipped({{2, -1}, {2, 1}, {3, 1}}, pair, open) == Polygons{{{2, 0}, {2, 1}, {3, 1}}});
    // Pieces that rounding makes a point; and one that it does not.
    const Polygons sliver = {{{0, 0}, {100, 0}, {100, 1}}};
    CHECK(clipped({{20, -7}, {20, 8}}, sliver).empty());
    CHECK(clipped({{80, -7}, {80, 8}}, sliver) == Polygons{{{80, 0}, {80, 1}}});
    constexpr std::int32_t far = grid_limit;
    const Polygons everything = {square(-far, far)};
    CHECK(clipped({{-far, -far}, {far, far}}, everything) == Polygons{{{-far, -far}, {far, far}}});
    CHECK(clipped({{-far, far - 1}, {far, 1 - far}}, {{{-far, -far}, {far, -far}, {far, far}}}) ==
          Polygons{{{0, 0}, {far, 1 - far}}});
}

TEST_CASE("on a lattice each piece between crossings is kept if winding numbers beside it say so", "[regions][clip]") {
    std::mt19937 random(3);
    for (int round = 0; round < 5000; ++round) {
        Polygons region(1 + random() % 3);
        std::generate(region.begin(), region.end(), [&] { return drawn(random, 9); });
        const FillRule rule = random() % 2 == 0 ? FillRule::even_odd : FillRule::non_zero;
        const ClipOptions options{random() % 2 == 0, random() % 2 == 0};
        Polygons lines(1 + random() % 4);
        std::generate(lines.begin(), lines.end(), [&] { return drawn(random, 6); });
        const GivenPaths raw(region);
        const SliceResult filled = value_of(regions::region(region, {.fill_rule = rule}, 1));
        const LayerSet by = random() % 2 == 0 ? LayerSet{.layers = raw.set, .fill_rule = rule} : LayerSet{.layers = filled};
        INFO("round " << round << ": " << regions::text_of(region) << " clips " << regions::text_of(lines));
        const auto found = pieces_of(clipped(GivenPaths(lines), by, options), lines.size());
        std::for_each(lines.begin(), lines.end(), [](Polygon& line) { line = reversed(line); });
        const auto backwards = pieces_of(clipped(GivenPaths(lines), by, options), lines.size());
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
        const auto around =
            pieces_of(clipped(filled, {.layers = GivenPaths(lines), .fill_rule = rule}, options), own.size());
        for (std::size_t i = 0; i < own.size(); ++i) {
            REQUIRE(around[i] == expected_pieces(own[i], true, lines, rule, options));
        }
    }
}

TEST_CASE("in general position pieces are the line, and lie where they should", "[regions][clip]") {
    std::mt19937 random(5);
    for (int round = 0; round < 300; ++round) {
        const double radius = std::array<double, 3>{20000, 1 << 20, grid_limit}[std::size_t(round % 3)];
        const auto any = [&] { return polygons::rounded(polygons::between(random, -radius, radius)); };
        Polygons region = discs(random, radius / 2);
        for (int i = polygons::below(random, 3); i > 0; --i) {
            region.push_back({});
            std::generate_n(std::back_inserter(region.back()), 12, [&] { return Point{any(), any()}; });
        }
        Polygons lines(8);
        for (Polygon& line : lines) {
            std::generate_n(std::back_inserter(line), 2 + random() % 9, [&] { return Point{any(), any()}; });
            line.erase(std::unique(line.begin(), line.end()), line.end());
        }
        const SliceResult filled = value_of(regions::region(region, {.fill_rule = FillRule::non_zero}, 1));
        const Polygons rings = regions::rings_of(filled);
        const Polygons shuffled = regions::shuffled(region, static_cast<std::uint32_t>(round));
        const SliceResult result = clipped(GivenPaths(lines), {.layers = filled});
        CHECK(clipped(GivenPaths(lines), {.layers = GivenPaths(region)}).hash() ==
              clipped(GivenPaths(lines), {.layers = GivenPaths(shuffled)}).hash());
        const auto inside = pieces_of(result, lines.size());
        const auto outside = pieces_of(clipped(GivenPaths(lines), {.layers = filled}, {.inside = false}), lines.size());
        for (std::size_t i = 0; i < lines.size(); ++i) {
            require_line(lines[i], inside[i], outside[i]);
            for (const auto* const pieces : {&inside[i], &outside[i]}) {
                for (const Polygon& piece : *pieces) {
                    for (std::size_t p = 1; p < piece.size(); ++p) {
                        const bool is_long = std::abs(std::int64_t{piece[p].x} - piece[p - 1].x) > 1000;
                        REQUIRE((!is_long || is_filled_beside(piece[p - 1], piece[p], true, rings, FillRule::non_zero) ==
                                                 (pieces == &inside[i])));
                    }
                }
            }
        }
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
    CHECK(one.info.open_contours > one.size());
    // A closed polyline that lies inside comes back to where it starts.
    const Polygons wide = {square(-(1 << 26), 1 << 26)};
    const SliceResult whole = clipped(bar, {.layers = GivenPaths(wide, default_grid_mm)});
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
    const Polygons four = {square(0, 4)};
    const Polygons far = {{{0, 0}, {grid_limit + 1, 0}}};
    const GivenPaths lines(line);
    const GivenPaths by(four);
    CHECK(message(lines, {.layers = GivenPaths(four, 0.5)}) ==
          "set 1: its grid unit is 0.5 mm, and another set's 1 mm: slice both on one grid");
    CHECK(message(GivenPaths(far), {.layers = by.set}).find("set 0: a point with the coordinate 1073741825 lies") == 0);
    CHECK(message(lines, {.layers = by.set, .from = 1}) == "set 1: layers from 1 to 0 are none");
    CHECK(message(lines, {.layers = by.set, .fill_rule = FillRule::contours}).find("set 1: the fill rule of a set") == 0);
    const SliceResult low = sliced(shapes::box({0, 0, 0}, {4, 4, 4}), uniform(1));
    const SliceResult high = sliced(shapes::box({0, 0, 1}, {4, 4, 5}), uniform(1));
    CHECK(message(low, {.layers = high}).find("set 1: its layer 0 lies at 1.") == 0);
    constexpr std::uint64_t bytes = 2 * sizeof(Point) + sizeof(Contour);
    CHECK(overlay.clip(result, lines, {.layers = by.set}, {}, {.memory_limit_bytes = bytes}).ok());
    CHECK(overlay.clip(result, lines, {.layers = by.set}, {}, {.memory_limit_bytes = bytes - 1}).error().code ==
          ErrorCode::result_too_large);
    CHECK(message(result, {.layers = by.set}) == "the answer cannot take the place of one of the sets");
}
