// What every region promises, checked by plain methods, and how far two regions differ. For tests and for the fuzzer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
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
using Ring = std::vector<Point>;
using Rings = std::vector<Ring>;

using Wide = ::rings::Int128;

inline lamella::Result<LayerContours> region(const Rings& rings, const RegionRules& rules,
                                             double unit_mm = lamella::default_unit_mm,
                                             const lamella::Control& control = {}) {
    const std::vector<std::span<const Point>> views(rings.begin(), rings.end());
    return lamella::region_of(views, rules, unit_mm, control);
}

inline std::span<const Point> points_of(const LayerContours& layer, const Contour& contour) {
    return {layer.points.data() + contour.first_point, contour.point_count};
}

inline Rings rings_of(const LayerContours& layer) {
    Rings rings;
    for (const Contour& contour : layer.contours) {
        const auto points = points_of(layer, contour);
        rings.emplace_back(points.begin(), points.end());
    }
    return rings;
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

inline double perimeter_of(const Rings& rings) {
    double sum = 0;
    for (const Ring& ring : rings) {
        sum += static_cast<double>(::rings::perimeter(ring));
    }
    return sum;
}

/// Area of the symmetric difference in square units; negative where it could not be computed.
inline double difference_of(const LayerContours& a, const LayerContours& b) {
    Rings both = rings_of(a);
    const Rings others = rings_of(b);
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

/// Twice a point's coordinates, to hold the middles of edges.
struct HalfPoint {
    std::int64_t x;
    std::int64_t y;
};

/// The winding number of the ring around `p`; `on` if p lies on it.
struct Turns {
    int winding = 0;
    bool on = false;
};

inline Turns turns_around(std::span<const Point> ring, HalfPoint p) {
    Turns turns;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i];
        const Point b = ring[i + 1 < ring.size() ? i + 1 : 0];
        const std::int64_t ay = 2 * std::int64_t{a.y} - p.y;
        const std::int64_t by = 2 * std::int64_t{b.y} - p.y;
        const std::int64_t ax = 2 * std::int64_t{a.x} - p.x;
        const std::int64_t bx = 2 * std::int64_t{b.x} - p.x;
        const Wide side = Wide{ax} * by - Wide{ay} * bx;
        turns.on = turns.on || (side == 0 && std::min(ax, bx) <= 0 && std::max(ax, bx) >= 0 && std::min(ay, by) <= 0 &&
                                std::max(ay, by) >= 0);
        if ((ay <= 0) != (by <= 0)) {
            turns.winding += by > 0 ? (side > 0 ? 1 : 0) : (side < 0 ? -1 : 0);
        }
    }
    return turns;
}

/// The contours around a place of contour `c` that lies on no other, by brute force; false if there is none.
inline bool find_around(const LayerContours& layer, std::size_t c, std::vector<std::size_t>& around) {
    const auto own = points_of(layer, layer.contours[c]);
    for (std::size_t i = 0; i < own.size(); ++i) {
        const Point a = own[i];
        const Point b = own[(i + 1) % own.size()];
        const HalfPoint middle{std::int64_t{a.x} + b.x, std::int64_t{a.y} + b.y};
        bool on = false;
        around.clear();
        for (std::size_t o = 0; o < layer.contours.size() && !on; ++o) {
            const Turns turns = o == c ? Turns{} : turns_around(points_of(layer, layer.contours[o]), middle);
            on = turns.on;
            if (turns.winding != 0) {
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

inline std::string broken_contour(const LayerContours& layer, std::size_t c) {
    const Contour& contour = layer.contours[c];
    const auto points = points_of(layer, contour);
    const bool outer = contour.role == lamella::Role::outer;
    if (!outer && contour.role != lamella::Role::hole) {
        return "neither outer nor hole";
    }
    if (points.size() < 3) {
        return "fewer than three points";
    }
    const Wide twice = ::rings::twice_area(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point a = points[i];
        const Point b = points[(i + 1) % points.size()];
        if (a == b) {
            return "equal consecutive points";
        }
        if (std::abs(std::int64_t{a.x}) > lamella::grid_limit || std::abs(std::int64_t{a.y}) > lamella::grid_limit) {
            return "a point beyond the grid";
        }
    }
    const lamella::Integer128 stored{static_cast<std::uint64_t>(twice), static_cast<std::int64_t>(twice >> 64)};
    if (!(stored == contour.twice_area)) {
        return "the area is not that of its points";
    }
    if (twice == 0 || (twice > 0) != outer || contour.orientation != (outer ? 1 : -1)) {
        return "outers run counter-clockwise, holes clockwise";
    }
    if (*std::min_element(points.begin(), points.end()) != points.front()) {
        return "starts at its smallest point";
    }
    return broken_parent(layer, c);
}

/// The broken promise of a region in words, or empty. O(contours times points).
inline std::string broken_promise(const LayerContours& layer) {
    for (std::size_t c = 0; c < layer.contours.size(); ++c) {
        const std::string broken = broken_contour(layer, c);
        if (!broken.empty()) {
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
inline Rings shuffled(Rings rings, std::uint32_t seed) {
    for (std::size_t i = rings.size(); i > 0; --i) {
        seed = seed * 1664525U + 1013904223U;
        std::swap(rings[i - 1], rings[(seed >> 8) % i]);
        Ring& ring = rings[i - 1];
        if (!ring.empty()) {
            std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>((seed >> 12) % ring.size()), ring.end());
        }
    }
    return rings;
}

/// Dilated and eroded with nothing left alone: what closing must agree with.
inline lamella::Result<LayerContours> closed_everywhere(const Rings& rings, RegionRules rules,
                                                        double unit_mm = lamella::default_unit_mm) {
    const double radius = rules.close_mm;
    rules.close_mm = 0;
    rules.offset_mm = radius;
    auto dilated = region(rings, rules, unit_mm);
    if (!dilated) {
        return dilated;
    }
    rules.offset_mm = -radius;
    return region(rings_of(*dilated), rules, unit_mm);
}

}  // namespace regions
