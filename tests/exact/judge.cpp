// CGAL intersects every triangle with the plane. What must hold of these segments and the engine's layer needs no links
// among them, so that the judge has another algorithm and another code base than the engine. The oracle links, nests and
// turns contours.
#include "exact/judge.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <stdexcept>

#include "exact/region_judge.hpp"
#include "oracle/compare.hpp"

namespace exact {

using lamella::GridVertex;
using lamella::Point;

namespace {

using Number = ArrangementKernel::FT;
using Plane = ArrangementKernel::Plane_3;
using Place = ArrangementKernel::Point_3;

Corner crossing(const Plane& plane, GridVertex u, GridVertex v) {
    const auto met = CGAL::intersection(plane, ArrangementKernel::Segment_3(Place(u.x, u.y, u.z), Place(v.x, v.y, v.z)));
    const auto* point = met ? boost::get<Place>(&*met) : nullptr;
    if (point == nullptr) {
        throw std::logic_error("an edge that crosses the plane does not meet it in a point");
    }
    return {point->x(), point->y()};
}

/// The segments have the solid on the left: faces are counter-clockwise, and a segment starts at the edge that its face
/// runs down.
Edges segments_at(std::span<const oracle::Triangle> triangles, std::int32_t z) {
    const Plane plane(0, 0, 1, -z);
    Edges segments;
    for (const oracle::Triangle& t : triangles) {
        Corner ends[2];
        bool crossed = false;
        for (std::size_t i = 0; i < 3; ++i) {
            const GridVertex u = t[i];
            const GridVertex v = t[(i + 1) % 3];
            if ((u.z < z) != (v.z < z)) {
                ends[v.z < z ? 0 : 1] = crossing(plane, u, v);
                crossed = true;
            }
        }
        if (crossed) {
            segments.emplace_back(ends[0], ends[1]);
        }
    }
    return segments;
}

/// Upper bound for the error of the engine's doubles (grid.hpp), in grid units.
constexpr double tie_width = 0x1p-20;

struct Rounded {
    std::int32_t nearest = 0;
    std::int32_t other = 0;  ///< differs from `nearest` if the exact number is so close to a tie that both are correct
};

Rounded rounded(const Number& number) {
    CGAL::exact(number);  // makes to_interval() tight
    const auto [low, high] = CGAL::to_interval(number);
    const double base = std::nearbyint(low / 2 + high / 2);
    const Number rest = number - Number(base);
    Rounded result;
    result.nearest = result.other = static_cast<std::int32_t>(base);
    if (CGAL::abs(rest) > Number(0.5 - tie_width)) {
        result.other += CGAL::is_positive(rest) ? 1 : -1;
        const bool odd = (result.nearest & 1) != 0;
        if (CGAL::abs(rest) > Number(0.5) || (odd && CGAL::abs(rest) == Number(0.5))) {
            std::swap(result.nearest, result.other);
        }
    }
    return result;
}

/// Every crossing rounded to the grid is a point of the engine's, and there is no other.
std::string fault_in_points(const Edges& segments, std::set<Point> engine) {
    std::set<Point> crossed;
    for (const auto& [from, to] : segments) {
        for (const Corner& corner : {from, to}) {
            const Rounded x = rounded(corner.x());
            const Rounded y = rounded(corner.y());
            bool found = false;
            for (const Point p :
                 {Point{x.nearest, y.nearest}, {x.other, y.nearest}, {x.nearest, y.other}, {x.other, y.other}}) {
                found = found || engine.count(p) != 0;
                crossed.insert(p);
            }
            if (!found) {
                return "no point at " + std::to_string(x.nearest) + "," + std::to_string(y.nearest);
            }
        }
    }
    for (const Point p : engine) {
        if (crossed.count(p) == 0) {
            return "no crossing at " + std::to_string(p.x) + "," + std::to_string(p.y);
        }
    }
    return {};
}

std::string fault_at(const lamella::SliceResult& result, const lamella::Layer& at,
                     std::span<const oracle::Triangle> triangles) {
    const Edges segments = segments_at(triangles, at.plane.z());
    std::set<Point> points;
    regions::Polygons rings;  // as the facets turn them
    bool open = false;
    for (const lamella::Contour& contour : result.contours_of(at)) {
        const std::span<const Point> own = result.points_of(contour);
        points.insert(own.begin(), own.end());
        rings.emplace_back(own.begin(), own.end());
        open = open || contour.role == lamella::Role::open;
        if ((contour.role == lamella::Role::outer ? 1 : -1) != contour.orientation) {
            std::reverse(rings.back().begin(), rings.back().end());
        }
    }
    const std::string fault = fault_in_points(segments, std::move(points));
    return !fault.empty() || open ? fault : fault_in_windings(segments, rings);
}

}  // namespace

std::string difference(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles) {
    for (const lamella::Layer& layer : result.layers) {
        const std::string found = fault_at(result, layer, triangles);
        if (!found.empty()) {
            return std::string("plane ").append(std::to_string(layer.plane.z())).append(", ").append(found);
        }
    }
    return oracle::difference(result, triangles);
}

lamella::SliceOptions through_vertices(const shapes::Soup& soup, double grid_mm, std::uint64_t seed, std::size_t most) {
    std::mt19937_64 random(seed);
    std::vector<double> heights;
    for (std::size_t i = 2; i < soup.size(); i += 3) {
        heights.push_back(soup[i]);
    }
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    const double low = heights.front();
    const double high = heights.back();
    std::shuffle(heights.begin(), heights.end(), random);
    heights.resize(std::min(heights.size(), most));
    for (std::size_t between = heights.size(); between > 0; --between) {
        heights.push_back(low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53));
    }
    std::sort(heights.begin(), heights.end());
    // Planes must still differ after rounding.
    const auto on_grid = [&](double mm) { return std::nearbyint(mm / (2 * grid_mm)); };
    const auto equal = [&](double a, double b) { return on_grid(a) == on_grid(b); };
    heights.erase(std::unique(heights.begin(), heights.end(), equal), heights.end());
    lamella::SliceOptions options;
    options.heights_mm = heights;
    options.planes.side = seed % 2 == 0 ? lamella::PlaneSide::below : lamella::PlaneSide::above;
    options.frame.grid_mm = grid_mm;
    return options;
}

}  // namespace exact
