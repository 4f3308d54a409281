// Areas by fill rules, compared with a simple method: the area between edges, summed from one height to the next.
#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "regions/region.hpp"

using lamella::FillRule;
using lamella::SliceResult;

namespace {

constexpr int size = 12;

int draw(std::mt19937& random, int low, int high) {
    return low + static_cast<int>(random() % static_cast<unsigned>(high - low));
}

using Polygon = std::vector<std::array<double, 2>>;

/// Walls over closed polygons that may cross themselves and one another. There are no floors and ceilings.
shapes::Soup walls(const std::vector<Polygon>& polygons) {
    shapes::Soup soup;
    for (const Polygon& polygon : polygons) {
        shapes::append(soup, shapes::walls(polygon));
    }
    return soup;
}

struct Edge {
    double x0, y0, x1, y1;  // from the lower end to the upper
    int winding;            // winding number on its right minus that on its left

    double x_at(double y) const { return x0 + (x1 - x0) * (y - y0) / (y1 - y0); }
};

std::vector<Edge> slanted_edges(const std::vector<Polygon>& polygons) {
    std::vector<Edge> edges;
    for (const Polygon& polygon : polygons) {
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const auto [ax, ay] = polygon[i];
            const auto [bx, by] = polygon[(i + 1) % polygon.size()];
            if (ay != by) {
                edges.push_back(ay < by ? Edge{ax, ay, bx, by, -1} : Edge{bx, by, ax, ay, 1});
            }
        }
    }
    return edges;
}

/// The heights of all ends and crossings.
std::vector<double> heights_of(const std::vector<Edge>& edges) {
    std::vector<double> heights;
    for (const Edge& a : edges) {
        heights.insert(heights.end(), {a.y0, a.y1});
        for (const Edge& b : edges) {
            const double low = std::max(a.y0, b.y0);
            const double high = std::min(a.y1, b.y1);
            const double before = low < high ? a.x_at(low) - b.x_at(low) : 0;
            const double after = low < high ? a.x_at(high) - b.x_at(high) : 0;
            if (before * after < 0) {
                heights.push_back(low + (high - low) * before / (before - after));
            }
        }
    }
    std::sort(heights.begin(), heights.end());
    return heights;
}

double area_between_edges(const std::vector<Polygon>& polygons, FillRule rule) {
    const std::vector<Edge> edges = slanted_edges(polygons);
    const std::vector<double> heights = heights_of(edges);
    double area = 0;
    for (std::size_t i = 1; i < heights.size(); ++i) {
        const double middle = (heights[i - 1] + heights[i]) / 2;
        std::vector<std::pair<double, int>> steps;
        for (const Edge& edge : edges) {
            if (edge.y0 < middle && middle < edge.y1) {
                steps.emplace_back(edge.x_at(middle), edge.winding);
            }
        }
        std::sort(steps.begin(), steps.end());
        int winding = 0;
        for (std::size_t s = 0; s < steps.size(); ++s) {
            area +=
                regions::fills(rule, winding) ? (steps[s].first - steps[s - 1].first) * (heights[i] - heights[i - 1]) : 0;
            winding += steps[s].second;
        }
    }
    return area;
}

double filled_area(const shapes::Soup& soup, FillRule rule) {
    lamella::SliceOptions options = at_heights({5}, lamella::default_grid_mm);
    options.region.fill_rule = rule;
    const SliceResult result = sliced(soup, options);
    CHECK(result.info.overruled_contours == 0);
    return result[0].area_mm2();
}

constexpr std::array rules{FillRule::even_odd, FillRule::non_zero, FillRule::positive};

}  // namespace

TEST_CASE("fill rules fill the area between edges of contours that cross themselves and share corners and lines",
          "[engine][fill]") {
    const unsigned seed = GENERATE(range(1U, 1 + rounds(400)));
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::vector<Polygon> polygons(1 + random() % 4);
    for (Polygon& polygon : polygons) {
        polygon.resize(3 + random() % 8);
        for (auto& [x, y] : polygon) {
            x = draw(random, 0, size);
            y = draw(random, 0, size);
        }
    }
    for (const FillRule rule : rules) {
        CAPTURE(static_cast<int>(rule));
        CHECK(filled_area(walls(polygons), rule) == Approx(area_between_edges(polygons, rule)).margin(1e-3));
    }
}

TEST_CASE("fill rules: a body exported a thousand times is filled by its winding number", "[engine][fill]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    const shapes::Soup other = shapes::box({5, 5, 0}, {15, 15, 10});
    for (const std::size_t times : {1000U, 1001U}) {
        shapes::Soup soup = other;
        for (std::size_t copy = 0; copy < times; ++copy) {
            shapes::append(soup, cube);
        }
        CHECK(filled_area(soup, FillRule::even_odd) == Approx(times % 2 == 0 ? 100 : 150));
        CHECK(filled_area(soup, FillRule::non_zero) == Approx(175));
        CHECK(filled_area(soup, FillRule::positive) == Approx(175));
    }
}
