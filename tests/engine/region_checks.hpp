// The promises of every region, checked by the audit and by plain methods, and how far two regions differ. For tests and for
// the fuzzer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/audits.hpp"
#include "lamella/layers.hpp"
#include "lamella/result.hpp"
#include "rings.hpp"

namespace regions {

using lamella::Contour;
using lamella::Point;
using lamella::RegionRules;
using lamella::SliceResult;
using rings::Int128;
using rings::twice_area;

/// Closed; the last point leads to the first.
using Polygon = std::vector<Point>;
using Polygons = std::vector<Polygon>;

inline lamella::Result<SliceResult> region(const Polygons& polygons, const RegionRules& rules,
                                           double grid_mm = lamella::default_grid_mm, const lamella::Context& context = {}) {
    const std::vector<std::span<const Point>> views(polygons.begin(), polygons.end());
    return lamella::region_of(views, rules, grid_mm, context);
}

inline Polygons rings_of(const SliceResult& layer) {
    Polygons polygons;
    for (const Contour& contour : layer.contours) {
        const auto points = layer.points_of(contour);
        polygons.emplace_back(points.begin(), points.end());
    }
    return polygons;
}

/// Net solid area in square units.
inline double area_of(const SliceResult& layer) {
    double sum = 0;
    for (const Contour& contour : layer.contours) {
        sum += contour.twice_area.to_double() / 2;
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
inline double difference_of(const SliceResult& a, const SliceResult& b) {
    Polygons both = rings_of(a);
    const Polygons others = rings_of(b);
    both.insert(both.end(), others.begin(), others.end());
    RegionRules rules;
    rules.fill_rule = lamella::FillRule::even_odd;
    const auto difference = region(both, rules);
    return difference ? area_of(*difference) : -1;
}

inline bool same(const SliceResult& a, const SliceResult& b) {
    static_assert(sizeof(Contour) == 48, "no byte between its members");
    return a.contours.size() == b.contours.size() &&
           (a.contours.empty() ||  // and its place may be null
            std::memcmp(a.contours.data(), b.contours.data(), a.contours.size() * sizeof(Contour)) == 0) &&
           std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end());
}

/// The contours around a place of contour `c` that lies on no other, by brute force; false if there is none.
inline bool find_around(const SliceResult& layer, std::size_t c, std::vector<std::size_t>& around) {
    const auto own = layer.points_of(layer.contours[c]);
    for (std::size_t i = 0; i < own.size(); ++i) {
        const Point a = own[i];
        const Point b = own[(i + 1) % own.size()];
        const rings::Place middle{Int128{a.x} + b.x, Int128{a.y} + b.y, 2};
        bool on = false;
        around.clear();
        for (std::size_t o = 0; o < layer.contours.size() && !on; ++o) {
            const std::optional<int> winding =
                o == c ? std::optional(0) : rings::winding(layer.points_of(layer.contours[o]), middle);
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

inline std::string broken_parent(const SliceResult& layer, std::size_t c) {
    const Contour& contour = layer.contours[c];
    std::vector<std::size_t> around;
    if (!find_around(layer, c, around)) {
        return {};
    }
    const auto by_size = [&](std::size_t a, std::size_t b) {
        return std::abs(layer.contours[a].twice_area.to_double()) < std::abs(layer.contours[b].twice_area.to_double());
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

/// Looks for the faults that the structure of results leaves open.
inline std::string fault_in_ring(const Contour& contour, std::span<const Point> points) {
    const auto is_off_grid = [](Point p) {
        return std::abs(std::int64_t{p.x}) > lamella::grid_limit || std::abs(std::int64_t{p.y}) > lamella::grid_limit;
    };
    return turns_back(points)                                                            ? "turns back along itself"
           : std::any_of(points.begin(), points.end(), is_off_grid)                      ? "has a point beyond the grid"
           : contour.role != lamella::Role::outer && contour.role != lamella::Role::hole ? "is neither outer nor hole"
                                                                                         : "";
}

/// The first fault that a single look at the contours shows: areas, orientations, roles, starts, order. Empty if there is
/// none.
inline std::string fault_in(const SliceResult& layer) {
    if (const lamella::Status status = audits::structure_of(layer, lamella::MeshView{}, {.threads = 1}); !status) {
        return status.error().message;
    }
    for (std::size_t c = 0; c < layer.contours.size(); ++c) {
        if (std::string fault = fault_in_ring(layer.contours[c], layer.points_of(layer.contours[c])); !fault.empty()) {
            return "contour " + std::to_string(c) + " " + fault;
        }
    }
    return {};
}

/// The broken promise of a region in words, or empty. O(contours times points).
inline std::string broken_promise(const SliceResult& layer) {
    if (std::string fault = fault_in(layer); !fault.empty()) {
        return fault;
    }
    for (std::size_t c = 0; c < layer.contours.size(); ++c) {
        if (const std::string broken = broken_parent(layer, c); !broken.empty()) {
            return "contour " + std::to_string(c) + ": " + broken;
        }
    }
    const auto crossings = audits::crossings_of(layer, {.threads = 1});
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
inline lamella::Result<SliceResult> closed_everywhere(const Polygons& polygons, RegionRules rules,
                                                      double grid_mm = lamella::default_grid_mm) {
    const double radius = rules.closing_mm;
    rules.closing_mm = 0;
    rules.offset_mm = radius;
    auto dilated = region(polygons, rules, grid_mm);
    if (!dilated) {
        return dilated;
    }
    rules.offset_mm = -radius;
    return region(rings_of(*dilated), rules, grid_mm);
}

}  // namespace regions
