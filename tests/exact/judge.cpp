// A slicer in exact arithmetic, with another algorithm and another code base than the engine, and the comparison with it.
// CGAL intersects every triangle with the plane. Segments follow each other where their exact end points are equal, whatever
// mesh edges those lie on. Nothing is rounded until the contours are complete.
#include "exact/judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include "oracle/compare.hpp"

namespace exact {

using lamella::GridVertex;
using lamella::Point;
using lamella::Role;

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using Point2 = Kernel::Point_2;

/// A contour. Each crossing appears once. The solid is on the left according to the facets.
struct Chain {
    std::vector<Point2> points;
    bool closed = true;
};

constexpr std::size_t none = static_cast<std::size_t>(-1);

struct Segment {
    Point2 from;
    Point2 to;
};

/// A segment's end, listed at the point where segments meet.
struct End {
    std::size_t segment;
    bool leaves;
};

using Meetings = std::map<Point2, std::vector<End>, Kernel::Less_xy_2>;

Point2 crossing(const Kernel::Plane_3& plane, GridVertex u, GridVertex v) {
    const auto space = [](GridVertex g) { return Kernel::Point_3(g.x, g.y, g.z); };
    const auto met = CGAL::intersection(plane, Kernel::Segment_3(space(u), space(v)));
    const auto* point = met ? boost::get<Kernel::Point_3>(&*met) : nullptr;
    if (point == nullptr) {
        throw std::logic_error("an edge that crosses the plane does not meet it in a point");
    }
    return {point->x(), point->y()};
}

/// The segments have the solid on the left: faces are counter-clockwise, and a segment starts at the edge that its face
/// runs down.
std::vector<Segment> segments_at(std::span<const oracle::Triangle> triangles, std::int32_t z) {
    const Kernel::Plane_3 plane(0, 0, 1, -z);
    std::vector<Segment> segments;
    for (const oracle::Triangle& t : triangles) {
        std::array<Point2, 2> ends;
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
            segments.push_back({ends[0], ends[1]});
        }
    }
    return segments;
}

void sort_counter_clockwise(std::vector<End>& ends, const std::vector<Segment>& segments) {
    const auto direction = [&](const End& end) {
        const Segment& s = segments[end.segment];
        return end.leaves ? Kernel::Direction_2(s.to - s.from) : Kernel::Direction_2(s.from - s.to);
    };
    std::sort(ends.begin(), ends.end(), [&](const End& a, const End& b) { return direction(a) < direction(b); });
    for (std::size_t i = 1; i < ends.size(); ++i) {
        if (direction(ends[i - 1]) == direction(ends[i])) {
            throw std::logic_error("more than two segments meet, and two of them in the same direction");
        }
    }
}

/// By segment: the segment that starts where it ends, or none.
std::vector<std::size_t> successors(const std::vector<Segment>& segments) {
    Meetings meetings;
    for (std::size_t s = 0; s < segments.size(); ++s) {
        meetings[segments[s].from].push_back({s, true});
        meetings[segments[s].to].push_back({s, false});
    }
    std::vector<std::size_t> next(segments.size(), none);
    for (auto& [point, ends] : meetings) {
        if (ends.size() > 2) {
            sort_counter_clockwise(ends, segments);
        }
        for (std::size_t i = 0; i < ends.size() && ends.size() > 1; ++i) {
            const End& clockwise = ends[(i + ends.size() - 1) % ends.size()];
            if (ends[i].leaves == clockwise.leaves) {
                throw std::logic_error("two segments that meet both start or both end there");
            }
            if (!ends[i].leaves) {
                next[ends[i].segment] = clockwise.segment;
            }
        }
    }
    return next;
}

/// The contours of the plane at odd height `z`. Where more than two segments meet, each that enters continues with the
/// next one clockwise, so that the solid lies between them. Throws std::logic_error if that one does not leave, or if two
/// have the same direction. Solids overlap there, and exact arithmetic alone cannot assign the contours.
std::vector<Chain> chains_at(std::span<const oracle::Triangle> triangles, std::int32_t z) {
    const std::vector<Segment> segments = segments_at(triangles, z);
    const std::vector<std::size_t> next = successors(segments);
    std::vector<char> used(segments.size(), 0);
    std::vector<char> follows(segments.size(), 0);
    for (const std::size_t s : next) {
        if (s != none) {
            follows[s] = 1;
        }
    }
    std::vector<Chain> chains;
    const auto follow = [&](std::size_t first, bool closed) {
        Chain chain{{}, closed};
        std::size_t last = first;
        for (std::size_t s = first; s != none && used[s] == 0; s = next[s]) {
            used[s] = 1;
            chain.points.push_back(segments[s].from);
            last = s;
        }
        if (!closed) {
            chain.points.push_back(segments[last].to);
        }
        chains.push_back(std::move(chain));
    };
    for (const bool closed : {false, true}) {
        for (std::size_t s = 0; s < segments.size(); ++s) {
            if (used[s] == 0 && (closed || follows[s] == 0)) {
                follow(s, closed);
            }
        }
    }
    return chains;
}

/// Non-zero winding; the boundary is not inside.
bool strictly_around(const Chain& chain, const Point2& p) {
    int winding = 0;
    for (std::size_t i = 0; i < chain.points.size(); ++i) {
        const Point2& a = chain.points[i];
        const Point2& b = chain.points[(i + 1) % chain.points.size()];
        const bool a_below = CGAL::compare_y(a, p) != CGAL::LARGER;
        const bool b_below = CGAL::compare_y(b, p) != CGAL::LARGER;
        if (a_below != b_below) {
            const CGAL::Orientation side = CGAL::orientation(a, b, p);
            if (side == CGAL::COLLINEAR) {
                return false;
            }
            winding +=
                static_cast<int>(a_below && side == CGAL::LEFT_TURN) - static_cast<int>(b_below && side == CGAL::RIGHT_TURN);
        } else if (a == p || (CGAL::compare_y(a, p) == CGAL::EQUAL && CGAL::compare_y(b, p) == CGAL::EQUAL &&
                              CGAL::collinear_are_ordered_along_line(a, p, b))) {
            return false;
        }
    }
    return winding != 0;
}

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
