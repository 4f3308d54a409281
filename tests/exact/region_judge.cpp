#include "exact/region_judge.hpp"

#include <algorithm>
#include <cmath>

#include "exact/arrangement.hpp"

namespace exact {

using lamella::FillRule;
using regions::Polygons;

namespace {

constexpr double band = 1;          // grid units, per axis
constexpr double tolerance = 1e-3;  // relative, for what is computed in doubles

struct Spot {
    double x, y;
};

/// The larger of the differences per axis between a spot and a point of an edge; the least along the edge.
double distance(Spot spot, regions::Point a, regions::Point b) {
    const double ax = a.x - spot.x;
    const double ay = a.y - spot.y;
    const double dx = static_cast<double>(b.x) - a.x;
    const double dy = static_cast<double>(b.y) - a.y;
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

double distance(Spot spot, const Polygons& polygons) {
    double least = HUGE_VAL;
    for (const regions::Polygon& polygon : polygons) {
        rings::each_edge(polygon,
                         [&](regions::Point a, regions::Point b) { least = std::min(least, distance(spot, a, b)); });
    }
    return least;
}

double length(double dx, double dy) {
    return std::abs(dx) + std::abs(dy);
}

double length(const Polygons& polygons) {
    double sum = 0;
    for (const regions::Polygon& polygon : polygons) {
        rings::each_edge(polygon, [&](regions::Point a, regions::Point b) {
            sum += length(static_cast<double>(b.x) - a.x, static_cast<double>(b.y) - a.y);
        });
    }
    return sum;
}

std::string text(Spot spot) {
    return std::to_string(spot.x) + ", " + std::to_string(spot.y);
}

/// A face where the found region differs from the exact one.
class DifferentFace {
public:
    DifferentFace(Face face, const Overlay& overlay) {
        around(face, [&](Halfedge halfedge) {
            const auto spot = [](const auto& point) { return Spot{to_double(point.x()), to_double(point.y())}; };
            sides_.push_back(
                {spot(halfedge->source()->point()), spot(halfedge->target()->point()), overlay.runs_along(halfedge, given)});
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
            sum += band * length(side.to.x - side.from.x, side.to.y - side.from.y) + 4 * band * band;
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
    struct Side {
        Spot from, to;
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

std::string fault_in_faces(const Polygons& polygons, FillRule rule, Overlay& overlay) {
    double area = 0;
    for (auto face = overlay.arrangement().faces_begin(); face != overlay.arrangement().faces_end(); ++face) {
        const FaceData& data = face->data();
        if (data.winding[found] != 0 && data.winding[found] != 1) {
            return "a place has the winding number " + std::to_string(data.winding[found]);
        }
        if (regions::fills(rule, data.winding[given]) == (data.winding[found] > 0)) {
            continue;
        }
        const DifferentFace different(face, overlay);
        const std::string what = data.winding[found] > 0 ? "filled in vain: " : "not filled: ";
        area += different.area();
        if (different.area() > different.largest_area()) {
            return what + std::to_string(different.area()) + " square units, where a band along them would have " +
                   std::to_string(different.largest_area());
        }
        for (const Spot& spot : different.middles()) {
            if (distance(spot, polygons) > band + tolerance) {
                return what + text(spot) + ", from all edges " + std::to_string(distance(spot, polygons));
            }
        }
    }
    return area > band * length(polygons) + tolerance ? "the region differs by " + std::to_string(area) + " square units"
                                                      : "";
}

std::string fault_in_rings(const Polygons& polygons, FillRule rule, const Polygons& rings, Overlay& overlay) {
    for (const regions::Polygon& ring : rings) {
        for (const regions::Point point : ring) {
            const Spot spot{static_cast<double>(point.x), static_cast<double>(point.y)};
            if (distance(spot, polygons) > band + tolerance) {
                return "a corner lies off all edges: " + text(spot);
            }
        }
    }
    return fault_in_faces(polygons, rule, overlay);
}

}  // namespace

regions::Region region_on_grid(const Polygons& polygons, FillRule rule) {
    Overlay overlay(polygons, {});
    regions::Region region = overlay.region([&](const FaceData& face) { return regions::fills(rule, face.winding[given]); });
    return rule == FillRule::outermost ? regions::canonical(regions::without_holes(region)) : region;
}

std::string fault_in_rings(const Polygons& polygons, FillRule rule, const Polygons& rings) {
    Overlay overlay(polygons, rings);
    return fault_in_rings(polygons, rule, rings, overlay);
}

std::string fault_in_region(const Polygons& polygons, FillRule rule, const lamella::SliceResult& contours) {
    const Polygons rings = regions::rings_of(contours);
    Overlay overlay(polygons, rings);
    if (std::string fault = fault_in_rings(polygons, rule, rings, overlay); !fault.empty()) {
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
