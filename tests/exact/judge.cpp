// CGAL intersects every triangle with the plane. Exact segments are not linked: what must hold of them and of the engine's
// layer is seen in the arrangement of both, so that the judge has another algorithm and another code base than the engine.
#include "exact/judge.hpp"

#include <cmath>
#include <random>
#include <set>

#include "exact/arrangement.hpp"
#include "oracle/compare.hpp"

namespace exact {

using lamella::FillRule;
using lamella::GridVertex;
using lamella::Point;
using regions::Polygons;

namespace {

constexpr double band = 1;          // grid units, per axis
constexpr double tolerance = 1e-3;  // relative, for what is computed in doubles

struct Spot {
    double x, y;
};

struct Line {
    Spot from, to;
};

Spot spot_at(const Corner& corner) {
    return {to_double(corner.x()), to_double(corner.y())};
}

/// The larger of the differences per axis between a spot and a point of a line; the least along the line.
double distance(Spot spot, const Line& line) {
    const double ax = line.from.x - spot.x;
    const double ay = line.from.y - spot.y;
    const double dx = line.to.x - line.from.x;
    const double dy = line.to.y - line.from.y;
    const auto at = [&](double along) {
        const double t = std::clamp(along, 0.0, 1.0);
        return std::max(std::abs(ax + t * dx), std::abs(ay + t * dy));
    };
    double least = std::min(at(0), at(1));
    const auto where = [&](double value, double slope) { least = slope == 0 ? least : std::min(least, at(-value / slope)); };
    where(ax, dx);
    where(ay, dy);
    where(ax - ay, dx - dy);
    where(ax + ay, dx + dy);
    return least;
}

double distance(Spot spot, const std::vector<Line>& lines) {
    double least = HUGE_VAL;
    for (const Line& line : lines) {
        least = std::min(least, distance(spot, line));
    }
    return least;
}

double length(const Line& line) {
    return std::abs(line.to.x - line.from.x) + std::abs(line.to.y - line.from.y);
}

std::vector<Line> lines_of(const Edges& edges) {
    std::vector<Line> lines(edges.size());
    std::transform(edges.begin(), edges.end(), lines.begin(), [](const auto& edge) {
        return Line{spot_at(edge.first), spot_at(edge.second)};
    });
    return lines;
}

std::string text(Spot spot) {
    return std::to_string(spot.x) + ", " + std::to_string(spot.y);
}

/// A face where the found region differs from the exact one.
class DifferentFace {
public:
    DifferentFace(Face face, const Overlay& overlay) {
        around(face, [&](Halfedge halfedge) {
            const Line line{spot_at(halfedge->source()->point()), spot_at(halfedge->target()->point())};
            sides_.push_back({line, overlay.runs_along(halfedge, given)});
        });
    }

    double area() const {
        const Spot origin = sides_[0].from;
        double twice = 0;
        for (const Side& side : sides_) {
            twice += (side.from.x - origin.x) * (side.to.y - origin.y) - (side.from.y - origin.y) * (side.to.x - origin.x);
        }
        return twice / 2;
    }

    /// The area of a band along its boundary: what the sides sweep, and the corners between them.
    double largest_area() const {
        double sum = tolerance;
        for (const Side& side : sides_) {
            sum += band * length(side) + 4 * band * band;
        }
        return sum;
    }

    /// Points midway between sides, at heights between corners: those that may lie far from all given edges.
    std::vector<Spot> middles() const {
        std::vector<Spot> found;
        for (const double y : heights()) {
            std::vector<Crossing> crossings;
            for (const Side& side : sides_) {
                if ((side.from.y > y) != (side.to.y > y)) {
                    const double along = (y - side.from.y) / (side.to.y - side.from.y);
                    crossings.push_back({side.from.x + along * (side.to.x - side.from.x), side.given});
                }
            }
            std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
            for (std::size_t i = 1; i < crossings.size(); i += 2) {
                const double half = (crossings[i].x - crossings[i - 1].x) / 2;
                if (half > band || (!crossings[i].given && !crossings[i - 1].given)) {
                    found.push_back({crossings[i - 1].x + half, y});
                }
            }
        }
        return found;
    }

private:
    struct Side : Line {
        bool given;
    };
    struct Crossing {
        double x;
        bool given;
    };

    /// The middles of the largest differences of height between corners.
    std::vector<double> heights() const {
        constexpr std::size_t most = 5;
        std::vector<double> ys;
        for (const Side& side : sides_) {
            ys.push_back(side.from.y);
        }
        std::sort(ys.begin(), ys.end());
        std::vector<std::pair<double, double>> gaps;
        for (std::size_t i = 1; i < ys.size(); ++i) {
            gaps.emplace_back(ys[i - 1] - ys[i], (ys[i - 1] + ys[i]) / 2);
        }
        std::sort(gaps.begin(), gaps.end());
        std::vector<double> heights;
        for (std::size_t i = 0; i < std::min(most, gaps.size()); ++i) {
            heights.push_back(gaps[i].second);
        }
        return heights;
    }

    std::vector<Side> sides_;
};

using Differs = std::function<bool(const FaceData&)>;

/// The fault in the faces that differ: none may lie outside a band of a unit around the given edges.
std::string fault_in_faces(const Edges& edges, Overlay& overlay, const Differs& differs) {
    const std::vector<Line> lines = lines_of(edges);
    double area = 0;
    for (auto face = overlay.arrangement().faces_begin(); face != overlay.arrangement().faces_end(); ++face) {
        const FaceData& data = face->data();
        if (!differs(data)) {
            continue;
        }
        const DifferentFace different(face, overlay);
        const std::string what = data.winding[found] > data.winding[given] ? "filled in vain: " : "not filled: ";
        area += different.area();
        if (different.area() > different.largest_area()) {
            return what + std::to_string(different.area()) + " square units, where a band along them would have " +
                   std::to_string(different.largest_area());
        }
        for (const Spot& spot : different.middles()) {
            if (distance(spot, lines) > band + tolerance) {
                return what + text(spot) + ", from all edges " + std::to_string(distance(spot, lines));
            }
        }
    }
    double most = tolerance;
    for (const Line& line : lines) {
        most += band * length(line);
    }
    return area > most ? "the region differs by " + std::to_string(area) + " square units" : "";
}

/// The fault in contours that should run around each place as often as the edges do; where no edge is near.
std::string fault_in_windings(const Edges& edges, const Polygons& contours) {
    Overlay overlay(edges, edges_of(contours));
    return fault_in_faces(edges, overlay, [](const FaceData& data) { return data.winding[given] != data.winding[found]; });
}

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
    std::vector<double> heights = oracle::vertex_heights(soup, grid_mm);
    const double low = heights.front();
    const double high = heights.back();
    std::shuffle(heights.begin(), heights.end(), random);
    heights.resize(std::min(heights.size(), most));
    for (std::size_t between = heights.size(); between > 0; --between) {
        heights.push_back(low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53));
    }
    return {.heights_mm = oracle::distinct(heights, grid_mm),  // planes must still differ after rounding
            .planes = {.side = seed % 2 == 0 ? lamella::PlaneSide::below : lamella::PlaneSide::above},
            .frame = {.grid_mm = grid_mm}};
}

regions::Region region_on_grid(const Polygons& polygons, FillRule rule) {
    Overlay overlay(edges_of(polygons), {});
    regions::Region region = overlay.region([&](const FaceData& face) { return regions::fills(rule, face.winding[given]); });
    return rule == FillRule::outermost ? regions::canonical(regions::without_holes(region)) : region;
}

std::string fault_in_rings(const Polygons& polygons, FillRule rule, const Polygons& rings) {
    const Edges edges = edges_of(polygons);
    const std::vector<Line> lines = lines_of(edges);
    const Edges found_edges = edges_of(rings);
    for (const Line& line : lines_of(found_edges)) {
        if (distance(line.from, lines) > band + tolerance) {
            return "a corner lies off all edges: " + text(line.from);
        }
    }
    Overlay overlay(edges, found_edges);
    for (auto face = overlay.arrangement().faces_begin(); face != overlay.arrangement().faces_end(); ++face) {
        if (const std::int64_t winding = face->data().winding[found]; winding != 0 && winding != 1) {
            return "a place has the winding number " + std::to_string(winding);
        }
    }
    return fault_in_faces(edges, overlay, [&](const FaceData& data) {
        return regions::fills(rule, data.winding[given]) != (data.winding[found] > 0);
    });
}

std::string fault_in_region(const Polygons& polygons, FillRule rule, const lamella::SliceResult& contours) {
    const Polygons rings = regions::rings_of(contours);
    if (std::string fault = fault_in_rings(polygons, rule, rings); !fault.empty()) {
        return fault;
    }
    try {
        Overlay overlay({}, edges_of(rings));
        const regions::Region own = overlay.region([](const FaceData& face) { return face.winding[found] > 0; });
        return regions::difference(own, regions::region_in(contours));
    } catch (const std::logic_error& crossing) {
        return crossing.what();
    }
}

}  // namespace exact
