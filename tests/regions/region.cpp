#include "regions/region.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace regions {

using lamella::Contour;
using lamella::FillRule;
using lamella::Role;
using lamella::SliceResult;

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

std::string place(const Ring& ring) {
    return (ring.hole ? "hole" : "outer ring") + (" " + text_of({ring.corners}));
}

}  // namespace

SliceResult region_of(const Polygons& polygons, const lamella::RegionRules& rules) {
    lamella::Result<SliceResult> made = region(polygons, rules);
    if (!made) {
        throw std::runtime_error("no region: " + made.error().message);
    }
    return std::move(made).value();
}

SliceResult region_of(const Polygons& polygons, FillRule rule) {
    return region_of(polygons, lamella::RegionRules{.fill_rule = rule});
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

Region region_in(const SliceResult& contours) {
    Region region;
    for (const Contour& contour : contours.contours) {
        const std::span<const Point> points = contours.points_of(contour);
        region.push_back({Polygon(points.begin(), points.end()), contour.role != Role::outer, contour.parent});
    }
    return canonical(std::move(region));
}

void find_parents(Region& region) {
    Polygons polygons;
    for (const Ring& ring : region) {
        polygons.push_back(ring.corners);
    }
    for (std::size_t r = 0; r < region.size(); ++r) {
        const std::optional<Around> found = around(polygons, r);
        if (!found) {
            throw std::logic_error("every edge of a ring lies on another ring");
        }
        region[r].hole = twice_area(polygons[r]) < 0;
        region[r].parent = found->smallest;
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

std::string dependence_on_order(const Polygons& polygons, const lamella::RegionRules& rules, const SliceResult& found,
                                std::mt19937& random) {
    Polygons other = shuffled(polygons, static_cast<std::uint32_t>(random()));
    if (!same(region_of(other, rules), found)) {
        return "other bytes for the contours in another order, from other starts: " + text_of(other);
    }
    if (rules.fill_rule != FillRule::positive) {
        for (Polygon& polygon : other) {
            std::reverse(polygon.begin(), polygon.end());
        }
        if (!same(region_of(other, rules), found)) {
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
