// What every region promises, checked by plain methods, and how far two regions differ. For tests and for the fuzzer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lamella/assemble.hpp"
#include "lamella/audit/crossings.hpp"
#include "lamella/region.hpp"
#include "lamella/result.hpp"
#include "rings.hpp"

namespace regions {

using lamella::Contour;
using lamella::LayerContours;
using lamella::Point;
using lamella::RegionRules;
using rings::Int128;
using rings::twice_area;

/// Closed; the last point leads to the first.
using Polygon = std::vector<Point>;
using Polygons = std::vector<Polygon>;

inline lamella::Result<LayerContours> region(const Polygons& polygons, const RegionRules& rules,
                                             double unit_mm = lamella::default_unit_mm,
                                             const lamella::Control& control = {}) {
    const std::vector<std::span<const Point>> views(polygons.begin(), polygons.end());
    return lamella::region_of(views, rules, unit_mm, control);
}

inline std::span<const Point> points_of(const LayerContours& layer, const Contour& contour) {
    return {layer.points.data() + contour.first_point, contour.point_count};
}

inline Polygons rings_of(const LayerContours& layer) {
    Polygons polygons;
    for (const Contour& contour : layer.contours) {
        const auto points = points_of(layer, contour);
        polygons.emplace_back(points.begin(), points.end());
    }
    return polygons;
}

inline double twice_area(const Contour& contour) {
    return std::ldexp(static_cast<double>(contour.twice_area.high), 64) + static_cast<double>(contour.twice_area.low);
}

/// Net solid area in square units.
inline double area_of(const LayerContours& layer) {
    double sum = 0;
    for (const Contour& contour : layer.contours) {
        sum += twice_area(contour) / 2;
    }
    return sum;
}

inline double perimeter_of(const Polygons& polygons) {
    double sum = 0;
    for (const Polygon& polygon : polygons) {
        sum += static_cast<double>(rings::perimeter(polygon));
    }
    return sum;
}

/// Area of the symmetric difference in square units; negative where it could not be computed.
inline double difference_of(const LayerContours& a, const LayerContours& b) {
    Polygons both = rings_of(a);
    const Polygons others = rings_of(b);
    both.insert(both.end(), others.begin(), others.end());
    RegionRules rules;
    rules.fill_rule = lamella::FillRule::even_odd;
    const auto difference = region(both, rules);
    return difference ? area_of(*difference) : -1;
}

inline bool same(const LayerContours& a, const LayerContours& b) {
    return std::equal(a.contours.begin(), a.contours.end(), b.contours.begin(), b.contours.end(),
                      [](const Contour& x, const Contour& y) {
                          return x.first_point == y.first_point && x.twice_area == y.twice_area && x.parent == y.parent &&
                                 x.point_count == y.point_count && x.role == y.role && x.orientation == y.orientation &&
                                 x.flags == y.flags;
                      }) &&
           std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end());
}

/// The contours around a place of contour `c` that lies on no other, by brute force; false if there is none.
inline bool find_around(const LayerContours& layer, std::size_t c, std::vector<std::size_t>& around) {
    const auto own = points_of(layer, layer.contours[c]);
    for (std::size_t i = 0; i < own.size(); ++i) {
        const Point a = own[i];
        const Point b = own[(i + 1) % own.size()];
        const rings::Place middle{Int128{a.x} + b.x, Int128{a.y} + b.y, 2};
        bool on = false;
        around.clear();
        for (std::size_t o = 0; o < layer.contours.size() && !on; ++o) {
            const std::optional<int> winding =
                o == c ? std::optional(0) : rings::winding(points_of(layer, layer.contours[o]), middle);
            on = !winding;
            if (winding.value_or(0) != 0) {
                around.push_back(o);
            }
        }
        if (!on) {
            return true;
        }
    }
    return false;
}

inline std::string broken_parent(const LayerContours& layer, std::size_t c) {
    const Contour& contour = layer.contours[c];
    std::vector<std::size_t> around;
    if (!find_around(layer, c, around)) {
        return {};
    }
    const auto by_size = [&](std::size_t a, std::size_t b) {
        return std::abs(twice_area(layer.contours[a])) < std::abs(twice_area(layer.contours[b]));
    };
    const auto smallest = std::min_element(around.begin(), around.end(), by_size);
    const std::int64_t expected = smallest == around.end() ? -1 : static_cast<std::int64_t>(*smallest);
    if (contour.parent != expected) {
        return "the parent is " + std::to_string(contour.parent) + ", not " + std::to_string(expected);
    }
    if ((contour.role == lamella::Role::hole) != (around.size() % 2 == 1)) {
        return "outers and holes alternate";
    }
    return {};
}

inline bool turns_back(std::span<const Point> ring) {
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

inline std::string fault_in_ring(const Contour& contour, std::span<const Point> points) {
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
    const auto is_off_grid = [](Point p) {
        return std::abs(std::int64_t{p.x}) > lamella::grid_limit || std::abs(std::int64_t{p.y}) > lamella::grid_limit;
    };
    if (std::any_of(points.begin(), points.end(), is_off_grid)) {
        return "has a point beyond the grid";
    }
    const Int128 twice = twice_area(points);
    if (!(contour.twice_area ==
          lamella::Integer128{static_cast<std::uint64_t>(twice), static_cast<std::int64_t>(twice >> 64)})) {
        return "states a false area";
    }
    const bool outer = contour.role == lamella::Role::outer;
    if (!outer && contour.role != lamella::Role::hole) {
        return "is neither outer nor hole";
    }
    if (contour.orientation != (outer ? 1 : -1) || (twice > 0) != outer || twice == 0) {
        return "does not run as its role demands";
    }
    return "";
}

/// What a single look at the contours shows: areas, orientations, roles, starts, order. Empty if nothing is wrong.
inline std::string fault_in(const LayerContours& layer) {
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
        if (contour.parent < 0 ? contour.role == lamella::Role::hole
                               : layer.contours[static_cast<std::size_t>(contour.parent)].role == contour.role) {
            return fault("has no parent of the other role");
        }
        const bool hole = contour.role == lamella::Role::hole;
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

/// The broken promise of a region in words, or empty. O(contours times points).
inline std::string broken_promise(const LayerContours& layer) {
    if (std::string fault = fault_in(layer); !fault.empty()) {
        return fault;
    }
    for (std::size_t c = 0; c < layer.contours.size(); ++c) {
        if (const std::string broken = broken_parent(layer, c); !broken.empty()) {
            return "contour " + std::to_string(c) + ": " + broken;
        }
    }
    lamella::SliceResult result;
    result.layers.resize_discarding(1);
    result.layers[0] = {};
    result.layers[0].contour_count = layer.contours.size();
    result.contours.resize_discarding(layer.contours.size());
    std::copy(layer.contours.begin(), layer.contours.end(), result.contours.begin());
    result.points.resize_discarding(layer.points.size());
    std::copy(layer.points.begin(), layer.points.end(), result.points.begin());
    const auto crossings = lamella::find_crossings(result);
    if (!crossings) {
        return crossings.error().message;
    }
    return crossings->count == 0 ? std::string() : std::to_string(crossings->count) + " crossings";
}

/// The same contours in another order, each from another of its points on.
inline Polygons shuffled(Polygons rings, std::uint32_t seed) {
    for (std::size_t i = rings.size(); i > 0; --i) {
        seed = seed * 1664525U + 1013904223U;
        std::swap(rings[i - 1], rings[(seed >> 8) % i]);
        Polygon& ring = rings[i - 1];
        if (!ring.empty()) {
            std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>((seed >> 12) % ring.size()), ring.end());
        }
    }
    return rings;
}

/// Dilated and eroded with nothing left alone: what closing must agree with.
inline lamella::Result<LayerContours> closed_everywhere(const Polygons& polygons, RegionRules rules,
                                                        double unit_mm = lamella::default_unit_mm) {
    const double radius = rules.close_mm;
    rules.close_mm = 0;
    rules.offset_mm = radius;
    auto dilated = region(polygons, rules, unit_mm);
    if (!dilated) {
        return dilated;
    }
    rules.offset_mm = -radius;
    return region(rings_of(*dilated), rules, unit_mm);
}

}  // namespace regions
