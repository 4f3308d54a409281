#include "exact/region_judge.hpp"

#include <algorithm>
#include <cmath>

namespace exact {

using lamella::FillRule;
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

std::string fault_in_rings(const Edges& edges, FillRule rule, const Polygons& rings, Overlay& overlay) {
    const std::vector<Line> lines = lines_of(edges);
    for (const regions::Polygon& ring : rings) {
        for (const regions::Point point : ring) {
            const Spot spot{static_cast<double>(point.x), static_cast<double>(point.y)};
            if (distance(spot, lines) > band + tolerance) {
                return "a corner lies off all edges: " + text(spot);
            }
        }
    }
    for (auto face = overlay.arrangement().faces_begin(); face != overlay.arrangement().faces_end(); ++face) {
        if (const std::int64_t winding = face->data().winding[found]; winding != 0 && winding != 1) {
            return "a place has the winding number " + std::to_string(winding);
        }
    }
    return fault_in_faces(edges, overlay, [&](const FaceData& data) {
        return regions::fills(rule, data.winding[given]) != (data.winding[found] > 0);
    });
}

}  // namespace

std::string fault_in_windings(const Edges& edges, const Polygons& contours) {
    Overlay overlay(edges, edges_of(contours));
    return fault_in_faces(edges, overlay, [](const FaceData& data) { return data.winding[given] != data.winding[found]; });
}

regions::Region region_on_grid(const Polygons& polygons, FillRule rule) {
    Overlay overlay(edges_of(polygons), {});
    regions::Region region = overlay.region([&](const FaceData& face) { return regions::fills(rule, face.winding[given]); });
    return rule == FillRule::outermost ? regions::canonical(regions::without_holes(region)) : region;
}

std::string fault_in_rings(const Polygons& polygons, FillRule rule, const Polygons& rings) {
    const Edges edges = edges_of(polygons);
    Overlay overlay(edges, edges_of(rings));
    return fault_in_rings(edges, rule, rings, overlay);
}

std::string fault_in_region(const Polygons& polygons, FillRule rule, const lamella::SliceResult& contours) {
    const Polygons rings = regions::rings_of(contours);
    const Edges edges = edges_of(polygons);
    Overlay overlay(edges, edges_of(rings));
    if (std::string fault = fault_in_rings(edges, rule, rings, overlay); !fault.empty()) {
        return fault;
    }
    try {
        const regions::Region own = overlay.region([](const FaceData& face) { return face.winding[found] > 0; });
        return regions::difference(own, regions::region_in(contours));
    } catch (const std::logic_error& crossing) {
        return crossing.what();
    }
}

}  // namespace exact
