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

/// Of a layer or of a result of one; the ends of open polylines are joined.
template <class Layer>
Polygons rings_of(const Layer& layer) {
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
    const auto difference = region(both, {.fill_rule = lamella::FillRule::even_odd});
    return difference ? area_of(*difference) : -1;
}

inline bool same(const SliceResult& a, const SliceResult& b) {
    static_assert(sizeof(Contour) == 48, "no byte between its members");
    return a.contours.size() == b.contours.size() &&
           (a.contours.empty() ||  // and its place may be null
            std::memcmp(a.contours.data(), b.contours.data(), a.contours.size() * sizeof(Contour)) == 0) &&
           std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end());
}

/// The polygons around one.
struct Around {
    std::int64_t smallest = -1;
    std::size_t count = 0;
};

/// Around a place of polygon `c` that lies on no other, by brute force; none if there is no such place.
inline std::optional<Around> around(const Polygons& polygons, std::size_t c) {
    const auto size = [&](std::int64_t p) {
        const Int128 area = twice_area(polygons[static_cast<std::size_t>(p)]);
        return area < 0 ? -area : area;
    };
    for (std::size_t i = 0; i < polygons[c].size(); ++i) {
        const Point a = polygons[c][i];
        const Point b = polygons[c][(i + 1) % polygons[c].size()];
        const rings::Place middle{Int128{a.x} + b.x, Int128{a.y} + b.y, 2};
        bool on = false;
        Around found;
        for (std::size_t o = 0; o < polygons.size() && !on; ++o) {
            const std::optional<int> winding = o == c ? std::optional(0) : rings::winding(polygons[o], middle);
            on = !winding;
            if (winding.value_or(0) != 0) {
                const auto other = static_cast<std::int64_t>(o);
                found.smallest = found.smallest < 0 || size(other) < size(found.smallest) ? other : found.smallest;
                ++found.count;
            }
        }
        if (!on) {
            return found;
        }
    }
    return {};
}

inline std::string broken_parent(const Contour& contour, const std::optional<Around>& around) {
    if (around && contour.parent != around->smallest) {
        return "the parent is " + std::to_string(contour.parent) + ", not " + std::to_string(around->smallest);
    }
    if (around && (contour.role == lamella::Role::hole) != (around->count % 2 == 1)) {
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
    const Polygons polygons = rings_of(layer);
    for (std::size_t c = 0; c < layer.contours.size(); ++c) {
        if (const std::string broken = broken_parent(layer.contours[c], around(polygons, c)); !broken.empty()) {
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
