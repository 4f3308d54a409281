#include "exact/judge.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "exact/exact_slice.hpp"
#include "oracle/compare.hpp"

namespace exact {

using lamella::Point;
using lamella::Role;

namespace {

/// Upper bound for the error of the engine's doubles (grid.hpp), in grid units.
constexpr double tie_width = 0x1p-20;

struct Rounded {
    std::int32_t nearest = 0;
    std::int32_t other = 0;  ///< differs from `nearest` if the exact number is so close to a tie that both are correct
    long double value = 0;   ///< the exact number to 2^-34 units
};

Rounded rounded(const Number& number) {
    CGAL::exact(number);  // makes to_interval() tight
    const auto [low, high] = CGAL::to_interval(number);
    const double base = std::nearbyint(low / 2 + high / 2);
    const Number rest = number - Number(base);
    const auto [rest_low, rest_high] = CGAL::to_interval(rest);
    Rounded result;
    result.nearest = result.other = static_cast<std::int32_t>(base);
    result.value = static_cast<long double>(base) + static_cast<long double>(rest_low / 2 + rest_high / 2);
    if (CGAL::abs(rest) > Number(0.5 - tie_width)) {
        result.other += CGAL::is_positive(rest) ? 1 : -1;
        const bool odd = (result.nearest & 1) != 0;
        if (CGAL::abs(rest) > Number(0.5) || (odd && CGAL::abs(rest) == Number(0.5))) {
            std::swap(result.nearest, result.other);
        }
    }
    return result;
}

/// An exact contour and the same contour on the grid.
struct Judged {
    Chain chain;
    oracle::Contour contour;
    std::size_t start = 0;  ///< index into chain.points
    long double twice_area = 0;
    long double perimeter = 0;
};

struct Place {
    long double x = 0;
    long double y = 0;
};

void measure(Judged& judged, const std::vector<Place>& places) {
    for (std::size_t i = 0; i + (judged.chain.closed ? 0 : 1) < places.size(); ++i) {
        const Place a = places[i];
        const Place b = places[(i + 1) % places.size()];
        const Place origin = places.front();
        judged.perimeter += std::hypot(b.x - a.x, b.y - a.y);
        judged.twice_area += (a.x - origin.x) * (b.y - origin.y) - (a.y - origin.y) * (b.x - origin.x);
    }
}

/// The nearest grid point. If several are equally correct, the one that the engine has.
Point on_grid(const Rounded& x, const Rounded& y, const std::set<Point>& engine) {
    const Point nearest{x.nearest, y.nearest};
    for (const Point p : {nearest, Point{x.other, y.nearest}, Point{x.nearest, y.other}, Point{x.other, y.other}}) {
        if (engine.count(p) != 0) {
            return p;
        }
    }
    return nearest;
}

void drop_repeated(std::vector<Point>& points, bool closed) {
    points.erase(std::unique(points.begin(), points.end()), points.end());
    while (closed && points.size() > 1 && points.back() == points.front()) {
        points.pop_back();
    }
}

Judged judged(Chain chain, const std::set<Point>& engine) {
    Judged result;
    result.chain = std::move(chain);
    oracle::Contour& contour = result.contour;
    std::vector<Place> places;
    for (const Point2& p : result.chain.points) {
        const Rounded x = rounded(p.x());
        const Rounded y = rounded(p.y());
        places.push_back({x.value, y.value});
        contour.points.push_back(on_grid(x, y, engine));
    }
    measure(result, places);
    const auto first = std::min_element(contour.points.begin(), contour.points.end());
    result.start = static_cast<std::size_t>(first - contour.points.begin());
    contour.segments = static_cast<std::uint32_t>(contour.points.size() - (result.chain.closed ? 0 : 1));
    contour.start_is_unique = false;  // the judge knows no mesh edges, so contours are compared from any start
    drop_repeated(contour.points, result.chain.closed);
    contour.role = result.chain.closed ? Role::flat : Role::open;
    if (result.chain.closed) {
        contour.twice_area = rings::twice_area(contour.points);
        contour.orientation = static_cast<int>(contour.twice_area > 0) - static_cast<int>(contour.twice_area < 0);
    }
    return result;
}

/// Finds parents by locating each contour's start exactly.
void find_parents(std::vector<Judged>& layer) {
    for (Judged& child : layer) {
        for (std::size_t i = 0; i < layer.size() && child.contour.orientation != 0; ++i) {
            const Judged& around = layer[i];
            const int parent = child.contour.parent;
            const bool closer =
                parent < 0 || std::abs(around.twice_area) < std::abs(layer[static_cast<std::size_t>(parent)].twice_area);
            if (&around != &child && around.contour.orientation != 0 && closer &&
                strictly_around(around.chain, child.chain.points[child.start])) {
                child.contour.parent = static_cast<int>(i);
            }
        }
    }
}

/// Differences beyond what rounding explains: the area by a unit along the perimeter, the perimeter by two units a point.
std::string beyond_rounding(const Judged& judged, const oracle::Contour& contour) {
    const long double exact_area = std::abs(judged.twice_area) / 2;
    const long double area = std::abs(static_cast<long double>(contour.twice_area)) / 2;
    const Point ends[] = {contour.points.back(), contour.points.front()};  // an open one does not lead back
    const long double perimeter = rings::perimeter(contour.points) - (judged.chain.closed ? 0 : rings::perimeter(ends) / 2);
    const long double reach = std::max(perimeter, judged.perimeter) + 2;
    std::ostringstream out;
    if (judged.chain.closed && std::abs(area - exact_area) > reach) {
        out << "area " << area << " instead of " << exact_area << " square units";
    } else if (std::abs(perimeter - judged.perimeter) > 2 * static_cast<long double>(judged.chain.points.size())) {
        out << "perimeter " << perimeter << " instead of " << judged.perimeter << " units";
    }
    return out.str();
}

std::string difference_at(const lamella::SliceResult& result, const lamella::Layer& at,
                          std::span<const oracle::Triangle> triangles) {
    std::set<Point> engine;
    for (const lamella::Contour& contour : result.contours_of(at)) {
        const std::span<const Point> points = result.points_of(contour);
        engine.insert(points.begin(), points.end());
    }
    std::vector<Judged> layer;
    for (Chain& chain : chains_at(triangles, at.plane.z())) {
        layer.push_back(judged(std::move(chain), engine));
    }
    find_parents(layer);
    oracle::Layer expected;
    for (const Judged& judged : layer) {
        expected.push_back(judged.contour);
    }
    oracle::decide_roles(expected);
    std::string found = oracle::difference(result, at, expected);
    for (std::size_t i = 0; i < layer.size() && found.empty(); ++i) {
        found = beyond_rounding(layer[i], expected[i]);
    }
    return found;
}

}  // namespace

std::string difference(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles) {
    for (const lamella::Layer& layer : result.layers) {
        const std::string found = difference_at(result, layer, triangles);
        if (!found.empty()) {
            return std::string("plane ").append(std::to_string(layer.plane.z())).append(", ").append(found);
        }
    }
    return {};
}

}  // namespace exact
