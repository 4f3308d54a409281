#include "regions/region.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>

#include "base/int128.hpp"

namespace regions {

using lamella::Contour;
using lamella::FillRule;
using lamella::LayerContours;
using lamella::Role;

namespace {

Polygon corners_of(std::span<const Point> ring) {
    Polygon corners;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point before = ring[(i + ring.size() - 1) % ring.size()];
        const Point after = ring[(i + 1) % ring.size()];
        if (rings::cross(before, ring[i], after) != 0) {
            corners.push_back(ring[i]);
        }
    }
    return corners;
}

std::span<const Point> points_of(const LayerContours& layer, const Contour& contour) {
    return layer.points.span().subspan(contour.first_point, contour.point_count);
}

/// A point of the segment between two corners, times `parts`.
struct Fraction {
    Int128 x, y;
    std::int64_t parts;
};

Fraction part_of(Point from, Point to, std::int64_t parts) {
    return {Int128{from.x} * (parts - 1) + to.x, Int128{from.y} * (parts - 1) + to.y, parts};
}

/// Winding number; none for a point on the ring.
std::optional<int> winding(std::span<const Point> ring, const Fraction& q) {
    int number = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point& from = ring[i];
        const Point& to = ring[(i + 1) % ring.size()];
        const Int128 ax = Int128{from.x} * q.parts - q.x;
        const Int128 ay = Int128{from.y} * q.parts - q.y;
        const Int128 bx = Int128{to.x} * q.parts - q.x;
        const Int128 by = Int128{to.y} * q.parts - q.y;
        const Int128 turn = ax * by - ay * bx;
        const bool within = std::min(ax, bx) <= 0 && std::max(ax, bx) >= 0 && std::min(ay, by) <= 0 && std::max(ay, by) >= 0;
        if (turn == 0 && within) {
            return std::nullopt;
        }
        if ((ay > 0) != (by > 0)) {
            number += (by > 0 && turn > 0 ? 1 : 0) - (ay > 0 && turn < 0 ? 1 : 0);
        }
    }
    return number;
}

struct Box {
    Point low, high;
    explicit Box(std::span<const Point> ring) : low(ring[0]), high(ring[0]) {
        for (const Point& p : ring) {
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
    }
    bool holds(const Box& other) const {
        return low.x <= other.low.x && low.y <= other.low.y && other.high.x <= high.x && other.high.y <= high.y;
    }
};

/// Whether a hole lies around the ring of another solid. They touch in points at most, so that some point of the ring's
/// first edge lies off the hole.
bool lies_around(const Polygon& hole, const Polygon& ring) {
    for (std::int64_t parts = 2; parts < 1'000'000; ++parts) {
        if (const std::optional<int> number = winding(hole, part_of(ring[0], ring[1], parts))) {
            return *number != 0;
        }
    }
    throw std::logic_error("a hole and the ring of another solid share an edge");
}

std::string place(const Ring& ring) {
    return (ring.hole ? "hole" : "outer ring") + (" " + text_of({ring.corners}));
}

bool same_contour(const Contour& a, const Contour& b) {
    return a.first_point == b.first_point && a.twice_area == b.twice_area && a.parent == b.parent &&
           a.point_count == b.point_count && a.segments == b.segments && a.role == b.role &&
           a.orientation == b.orientation && a.flags == b.flags;
}

bool same_bytes(const LayerContours& a, const LayerContours& b) {
    return std::equal(a.contours.begin(), a.contours.end(), b.contours.begin(), b.contours.end(), same_contour) &&
           std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end());
}

bool turns_back(std::span<const Point> ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point& before = ring[(i + ring.size() - 1) % ring.size()];
        const Point& at = ring[i];
        const Point& after = ring[(i + 1) % ring.size()];
        const Int128 along =
            (Int128{at.x} - before.x) * (Int128{after.x} - at.x) + (Int128{at.y} - before.y) * (Int128{after.y} - at.y);
        if (along < 0 && rings::cross(before, at, after) == 0) {
            return true;
        }
    }
    return false;
}

std::string fault_in_ring(const Contour& contour, std::span<const Point> points) {
    if (points.size() < 3) {
        return "has fewer than three points";
    }
    if (std::adjacent_find(points.begin(), points.end()) != points.end() || points.front() == points.back()) {
        return "has equal consecutive points";
    }
    if (turns_back(points)) {
        return "turns back along itself";
    }
    if (*std::min_element(points.begin(), points.end()) != points.front()) {
        return "does not start at its smallest point";
    }
    if (lamella::to_int128(contour.twice_area) != twice_area(points)) {
        return "states a false area";
    }
    const bool outer = contour.role == Role::outer;
    if (!outer && contour.role != Role::hole) {
        return "is neither outer nor hole";
    }
    if (contour.orientation != (outer ? 1 : -1) || (twice_area(points) > 0) != outer || twice_area(points) == 0) {
        return "does not run as its role demands";
    }
    return "";
}

}  // namespace

LayerContours region_of(const Polygons& polygons, const lamella::RegionRules& rules) {
    const std::vector<std::span<const Point>> spans(polygons.begin(), polygons.end());
    lamella::Result<LayerContours> region = lamella::region_of(spans, rules);
    if (!region) {
        throw std::runtime_error("no region: " + region.error().message);
    }
    return std::move(region).value();
}

LayerContours region_of(const Polygons& polygons, FillRule rule) {
    lamella::RegionRules rules;
    rules.fill_rule = rule;
    return region_of(polygons, rules);
}

Region canonical(Region region) {
    std::vector<std::size_t> order(region.size());
    for (std::size_t r = 0; r < region.size(); ++r) {
        order[r] = r;
        region[r].corners = rings::from_smallest(corners_of(region[r].corners));
    }
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return region[a].corners < region[b].corners; });
    std::vector<std::int64_t> place_of(region.size());
    for (std::size_t place = 0; place < order.size(); ++place) {
        place_of[order[place]] = static_cast<std::int64_t>(place);
    }
    Region sorted;
    for (const std::size_t r : order) {
        Ring& ring = sorted.emplace_back(std::move(region[r]));
        ring.parent = ring.parent < 0 ? -1 : place_of.at(static_cast<std::size_t>(ring.parent));
    }
    return sorted;
}

Region region_in(const LayerContours& contours) {
    Region region;
    for (const Contour& contour : contours.contours) {
        const std::span<const Point> points = points_of(contours, contour);
        region.push_back({Polygon(points.begin(), points.end()), contour.role != Role::outer, contour.parent});
    }
    return canonical(std::move(region));
}

void find_parents(Region& region, std::span<const std::size_t> solid_of) {
    std::map<std::size_t, std::int64_t> outer_of;
    std::vector<Box> boxes;
    std::vector<Int128> areas;
    for (std::size_t r = 0; r < region.size(); ++r) {
        boxes.emplace_back(region[r].corners);
        areas.push_back(-twice_area(region[r].corners));
        region[r].hole = areas[r] > 0;
        if (!region[r].hole && !outer_of.emplace(solid_of[r], r).second) {
            throw std::logic_error("a solid has two outer rings");
        }
    }
    for (std::size_t r = 0; r < region.size(); ++r) {
        if (region[r].hole) {
            region[r].parent = outer_of.at(solid_of[r]);
            continue;
        }
        region[r].parent = -1;
        for (std::size_t h = 0; h < region.size(); ++h) {
            const auto smallest = static_cast<std::size_t>(region[r].parent);
            if (areas[h] > 0 && solid_of[h] != solid_of[r] && boxes[h].holds(boxes[r]) &&
                (region[r].parent < 0 || areas[h] < areas[smallest]) && lies_around(region[h].corners, region[r].corners)) {
                region[r].parent = static_cast<std::int64_t>(h);
            }
        }
    }
}

bool fills(FillRule rule, std::int64_t winding) {
    switch (rule) {
        case FillRule::even_odd:
            return winding % 2 != 0;
        case FillRule::positive:
            return winding > 0;
        case FillRule::non_zero:
        case FillRule::outermost:
            return winding != 0;
        case FillRule::contours:
            break;
    }
    throw std::logic_error("this rule does not look at winding numbers");
}

Region without_holes(const Region& region) {
    Region outermost;
    std::copy_if(region.begin(), region.end(), std::back_inserter(outermost),
                 [](const Ring& ring) { return !ring.hole && ring.parent < 0; });
    return outermost;
}

Int128 twice_area(const Region& region) {
    Int128 sum = 0;
    for (const Ring& ring : region) {
        sum += twice_area(ring.corners);
    }
    return sum;
}

std::string difference(const Region& expected, const Region& found) {
    if (twice_area(expected) != twice_area(found)) {
        return "twice the area is " + std::to_string(static_cast<double>(twice_area(found))) + ", expected " +
               std::to_string(static_cast<double>(twice_area(expected)));
    }
    if (expected.size() != found.size()) {
        return std::to_string(found.size()) + " contours, expected " + std::to_string(expected.size());
    }
    for (std::size_t r = 0; r < expected.size(); ++r) {
        if (expected[r].corners != found[r].corners) {
            return "found " + place(found[r]) + ", expected " + place(expected[r]);
        }
        if (expected[r].hole != found[r].hole) {
            return "this is not a hole but an outer ring, or the reverse: " + place(found[r]);
        }
        if (expected[r].parent != found[r].parent) {
            return "parent " + std::to_string(found[r].parent) + ", expected " + std::to_string(expected[r].parent) +
                   ", of " + place(found[r]);
        }
    }
    return "";
}

std::string fault_in(const LayerContours& layer) {
    const auto start_of = [&](std::size_t c) { return layer.points[layer.contours[c].first_point]; };
    std::uint64_t points = 0;
    std::size_t outer = 0;  // the last one
    for (std::size_t c = 0; c < layer.contours.size(); ++c) {
        const Contour& contour = layer.contours[c];
        const auto fault = [&](const std::string& what) { return "contour " + std::to_string(c) + " " + what; };
        if (contour.first_point != points || contour.point_count > layer.points.size() - points) {
            return fault("does not begin where the one before it ends");
        }
        points += contour.point_count;
        if (std::string found = fault_in_ring(contour, points_of(layer, contour)); !found.empty()) {
            return fault(found);
        }
        if (contour.parent < -1 || contour.parent >= static_cast<std::int64_t>(layer.contours.size())) {
            return fault("has a parent that is no contour");
        }
        if (contour.parent < 0 ? contour.role == Role::hole
                               : layer.contours[static_cast<std::size_t>(contour.parent)].role == contour.role) {
            return fault("has no parent of the other role");
        }
        const bool hole = contour.role == Role::hole;
        const std::size_t before = hole ? c - 1 : outer;  // an outer one follows the last outer one and its holes
        if (hole && contour.parent != static_cast<std::int64_t>(outer)) {
            return fault("is a hole that does not follow its outer contour");
        }
        if (c > 0 && start_of(c) < start_of(before)) {
            return fault("starts before the one that it follows");
        }
        outer = hole ? outer : c;
    }
    return points == layer.points.size() ? "" : "points that belong to no contour";
}

std::string dependence_on_order(const Polygons& polygons, const lamella::RegionRules& rules, const LayerContours& found,
                                std::mt19937& random) {
    Polygons other = polygons;
    std::shuffle(other.begin(), other.end(), random);
    for (Polygon& polygon : other) {
        const auto first = static_cast<std::ptrdiff_t>(random() % std::max<std::size_t>(1, polygon.size()));
        std::rotate(polygon.begin(), polygon.begin() + first, polygon.end());
    }
    if (!same_bytes(region_of(other, rules), found)) {
        return "other bytes for the contours in another order, from other starts: " + text_of(other);
    }
    if (rules.fill_rule != FillRule::positive) {
        for (Polygon& polygon : other) {
            std::reverse(polygon.begin(), polygon.end());
        }
        if (!same_bytes(region_of(other, rules), found)) {
            return "other bytes for the contours reversed: " + text_of(other);
        }
    }
    return "";
}

std::string text_of(const Polygons& polygons) {
    std::string text;
    for (const Polygon& polygon : polygons) {
        text += text.empty() ? "{" : ", {";
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            text += (i > 0 ? ", {" : "{") + std::to_string(polygon[i].x) + ", " + std::to_string(polygon[i].y) + "}";
        }
        text += "}";
    }
    return text;
}

}  // namespace regions
