// Areas by fill rules, compared with two simple methods. For boxes with whole corners, some inverted, the winding number
// decides cell by cell. For polygons, the area between edges is summed from one height to the next.
#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/rounds.hpp"
#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "regions/region.hpp"

using lamella::FillRule;
using lamella::SliceResult;

namespace {

constexpr int size = 12;

struct Box {
    int x0, y0, x1, y1;
    bool inside_out;
};

int draw(std::mt19937& random, int low, int high) {
    return low + static_cast<int>(random() % static_cast<unsigned>(high - low));
}

Box random_box(std::mt19937& random) {
    const int x0 = draw(random, 0, size - 1);
    const int y0 = draw(random, 0, size - 1);
    const int x1 = draw(random, x0 + 1, size);
    const int y1 = draw(random, y0 + 1, size);
    return {x0, y0, x1, y1, draw(random, 0, 3) == 0};
}

shapes::Soup solid(const Box& box) {
    const shapes::Soup soup = shapes::box({double(box.x0), double(box.y0), 0}, {double(box.x1), double(box.y1), 10});
    return box.inside_out ? shapes::flipped(soup) : soup;
}

using Polygon = std::vector<std::array<double, 2>>;

/// A prism over a convex polygon, counter-clockwise, 10 mm high.
shapes::Soup prism(const Polygon& corners) {
    shapes::Soup soup = shapes::walls(corners);
    const auto at = [&](std::size_t i, double z) { return shapes::Xyz{corners[i][0], corners[i][1], z}; };
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        soup = shapes::joined({soup, shapes::triangle(at(0, 0), at(i + 1, 0), at(i, 0)),
                               shapes::triangle(at(0, 10), at(i, 10), at(i + 1, 10))});
    }
    return soup;
}

int cells_filled(const std::vector<Box>& boxes, FillRule rule) {
    int cells = 0;
    for (int x = 0; x < size; ++x) {
        for (int y = 0; y < size; ++y) {
            int winding = 0;
            for (const Box& box : boxes) {
                const bool inside = box.x0 <= x && x < box.x1 && box.y0 <= y && y < box.y1;
                winding += inside ? (box.inside_out ? -1 : 1) : 0;
            }
            cells += regions::fills(rule, winding) ? 1 : 0;
        }
    }
    return cells;
}

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
    lamella::SliceOptions options = at_heights({5});
    options.unit_mm = lamella::default_unit_mm;
    options.region.fill_rule = rule;
    const SliceResult result = sliced(soup, options);
    CHECK(result.summary.overruled_contours == 0);
    return result.area_mm2(result.layers[0]);
}

constexpr std::array rules{FillRule::even_odd, FillRule::non_zero, FillRule::positive};

}  // namespace

TEST_CASE("fill rules fill the cells with the right winding numbers", "[engine][fill]") {
    const unsigned seed = GENERATE(range(1U, 1 + rounds(400)));
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::vector<Box> boxes;
    for (std::size_t count = 2 + random() % 6; count > 0; --count) {
        boxes.push_back(random_box(random));
    }
    shapes::Soup soup;
    for (const Box& box : boxes) {
        shapes::append(soup, solid(box));
    }
    for (const FillRule rule : rules) {
        CAPTURE(static_cast<int>(rule));
        CHECK(filled_area(soup, rule) == Approx(cells_filled(boxes, rule)).margin(1e-9));
    }
}

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

TEST_CASE("fill rules: a spike without area is removed", "[engine][fill]") {
    const Polygon polygon{{-10, -10}, {0, -10}, {0, 0}, {10, 0}, {4, 0}, {4, 10}, {-10, 10}};
    for (const FillRule rule : rules) {
        lamella::SliceOptions options = at_heights({5});
        options.region.fill_rule = rule;
        options.region.drop_collinear = true;
        CHECK(contours_at(sliced(shapes::walls(polygon), options), 0) ==
              std::vector<std::string>{"outer + x6 in -: -20,-20 0,-20 0,0 8,0 8,20 -20,20"});
    }
}

TEST_CASE("fill rules: an insert may touch its surroundings at its leftmost point", "[engine][fill]") {
    const shapes::Soup around = shapes::box({0, 0, 0}, {30, 30, 10});
    const shapes::Soup diamond = prism({{15, 5}, {25, 15}, {15, 25}, {0, 15}});
    for (const auto& [insert, expected] :
         {std::pair{diamond, std::array{650.0, 900.0, 900.0}}, {shapes::flipped(diamond), {650.0, 650.0, 650.0}}}) {
        const shapes::Soup soup = shapes::joined({around, insert});
        for (std::size_t r = 0; r < rules.size(); ++r) {
            CHECK(filled_area(soup, rules[r]) == Approx(expected[r]));
        }
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
