// Shared by the tests of the baselines: the engine's planes as a baseline's problem, and a canonical form of contours
// that does not depend on their start.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "method.hpp"
#include "models/models.hpp"
#include "rings.hpp"
#include "slicing/tuning.hpp"

namespace agreement {

namespace baselines = lamella::baselines;
using lamella::Point;

/// The engine's result, and the problem with the same planes.
struct Case {
    Case(std::vector<float> triangles, const lamella::SliceOptions& options, const lamella::Tuning& tuning = {})
        : soup(std::move(triangles)),
          result(sliced(lamella::MeshView::soup(std::span<const float>(soup)), options, {}, tuning)) {
        const lamella::SliceOptions& done = result.info.options;
        problem.soup = soup;
        problem.unit_mm = result.info.grid_mm;
        for (const lamella::Layer& layer : result.layers) {
            problem.planes.push_back(layer.plane.z());
        }
        if (!done.heights_mm && !problem.planes.empty()) {
            problem.uniform = true;
            problem.step = done.layer_height_mm / result.info.grid_mm;
            problem.first = result.layers[0].plane_mm / result.info.grid_mm - 1;
        }
    }
    Case(const Case&) = delete;
    Case& operator=(const Case&) = delete;

    std::vector<float> soup;
    lamella::SliceResult result;
    baselines::Problem problem;
};

inline std::vector<float> from_recipe(lamella::models::Shape shape, std::uint64_t triangles) {
    lamella::models::Recipe recipe;
    recipe.shape = shape;
    recipe.triangles = triangles;
    recipe.height_mm = 20;
    recipe.order = lamella::models::Order::random;
    return make_soup(recipe);
}

/// Random layers.
inline lamella::Tuning irregular(double least_mm, double most_mm) {
    return {.random_heights = lamella::RandomHeights{least_mm, most_mm, 7}};
}

/// A ball, an inverted ball inside it, and a ball inside that: an outer contour, its hole, and an outer contour in the
/// hole.
inline shapes::Soup nested_balls() {
    return shapes::joined({shapes::octasphere({0, 0, 0}, 10, 3), shapes::flipped(shapes::octasphere({1, 0, 0}, 8, 3)),
                           shapes::octasphere({2, 0, 1}, 5, 3)});
}

/// Removes every `nth` triangle.
inline std::vector<float> with_gaps(const std::vector<float>& soup, std::size_t nth) {
    std::vector<float> rest;
    for (std::size_t t = 0; t < soup.size() / 9; ++t) {
        if (t % nth != 0) {
            rest.insert(rest.end(), soup.data() + 9 * t, soup.data() + 9 * (t + 1));
        }
    }
    return rest;
}

using Line = std::pair<bool, std::vector<Point>>;  ///< whether it is closed, and its points

/// Without equal successive points. A closed contour starts at its smallest point. If it passes there twice, it starts with
/// the rotation that compares smallest. If not `directed`, the smaller of the two directions is taken.
inline Line canonical(std::vector<Point> points, bool closed, bool directed) {
    points.erase(std::unique(points.begin(), points.end()), points.end());
    while (closed && points.size() > 1 && points.front() == points.back()) {
        points.pop_back();
    }
    std::vector<Point> back(points.rbegin(), points.rend());
    if (closed) {
        points = rings::from_smallest(points);
        back = rings::from_smallest(back);
    }
    return {closed, directed ? points : std::min(points, back)};
}

inline std::vector<Line> lines_of(const std::vector<baselines::Polyline>& plane, bool directed) {
    std::vector<Line> lines;
    lines.reserve(plane.size());
    for (const baselines::Polyline& polyline : plane) {
        lines.push_back(canonical(polyline.points, polyline.closed, directed));
    }
    std::sort(lines.begin(), lines.end());
    return lines;
}

/// The engine's contours, with the orientation of the facets.
inline std::vector<baselines::Polyline> as_sliced(const lamella::SliceResult& result, const lamella::Layer& layer) {
    std::vector<baselines::Polyline> contours;
    for (const lamella::Contour& contour : result.contours_of(layer)) {
        const auto points = result.points_of(contour);
        contours.push_back({{points.begin(), points.end()}, contour.role != lamella::Role::open});
        if (contour.orientation == (contour.role == lamella::Role::outer ? -1 : 1)) {  // reversed to fit its role
            std::reverse(contours.back().points.begin(), contours.back().points.end());
        }
    }
    return contours;
}

/// Requires that the contours of every plane equal the engine's.
inline void require_same(const baselines::Contours& contours, const lamella::SliceResult& result, bool directed) {
    REQUIRE(contours.size() == result.layers.size());
    for (std::size_t i = 0; i < contours.size(); ++i) {
        INFO("plane " << i);
        REQUIRE((lines_of(contours[i], directed) == lines_of(as_sliced(result, result.layers[i]), directed)));
    }
}

}  // namespace agreement
