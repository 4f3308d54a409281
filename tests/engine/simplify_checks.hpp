// Simplified contours against plain methods: how far they lie from what they replace, whether edges meet that did not, and
// what lies in what.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "engine/region_checks.hpp"
#include "slicing/nesting/path.hpp"
#include "slicing/simplify/simplifier.hpp"

namespace simplify_checks {

using lamella::Contour;
using lamella::FillRule;
using lamella::Point;
using lamella::RegionRules;
using lamella::Role;
using lamella::SliceResult;
using Ring = regions::Polygon;
using Rings = regions::Polygons;
using Wide = rings::Int128;

constexpr double unit_mm = lamella::default_grid_mm;

/// A contour before and after: `left` holds indices of `points`, those that stayed, from the start on.
struct Before {
    Ring points;
    std::vector<std::size_t> left;
    bool closed = true;

    std::size_t edges() const { return closed ? left.size() : left.size() - 1; }
    std::size_t begin_of(std::size_t edge) const { return left[edge]; }
    std::size_t end_of(std::size_t edge) const { return edge + 1 < left.size() ? left[edge + 1] : points.size(); }
    Point at(std::size_t i) const { return points[i % points.size()]; }
    bool is_line(std::size_t edge) const { return end_of(edge) - begin_of(edge) > 1; }
};

inline Wide dot(Point a, Point b, Point p) {
    return (Wide{b.x} - a.x) * (Wide{p.x} - a.x) + (Wide{b.y} - a.y) * (Wide{p.y} - a.y);
}

/// By steps of a unit where lengths are small: exact in long double up to its rounding.
inline bool is_within(Point p, Point a, Point b, long double tolerance) {
    const auto length2 = static_cast<long double>(dot(a, b, b));
    const auto along = static_cast<long double>(dot(a, b, p));
    if (along <= 0 || along >= length2) {
        const Point end = along <= 0 ? a : b;
        return static_cast<long double>(dot(end, p, p)) <= tolerance * tolerance * 1.0000001L;
    }
    const auto area = static_cast<long double>(rings::cross(a, b, p));
    return area * area <= tolerance * tolerance * length2 * 1.0000001L;
}

/// The same points in the same order, from the same start. A contour must pass each point once.
inline Before match(std::span<const Point> before, std::span<const Point> after, bool closed) {
    Before contour{Ring(before.begin(), before.end()), {}, closed};
    std::size_t next = 0;
    for (const Point p : after) {
        while (next < before.size() && before[next] != p) {
            ++next;
        }
        REQUIRE(next < before.size());
        contour.left.push_back(next++);
    }
    REQUIRE(contour.left.front() == 0);
    REQUIRE((closed || contour.left.back() + 1 == before.size()));
    return contour;
}

inline std::size_t lines_beyond(const Before& contour, double tolerance) {
    std::size_t beyond = 0;
    for (std::size_t e = 0; e < contour.edges(); ++e) {
        for (std::size_t i = contour.begin_of(e) + 1; i < contour.end_of(e); ++i) {
            beyond +=
                !is_within(contour.points[i], contour.at(contour.begin_of(e)), contour.at(contour.end_of(e)), tolerance);
        }
    }
    return beyond;
}

/// Pairs of edges, one of them a line that replaces points, that have a point in common other than a joint.
inline std::size_t meeting_lines(const std::vector<Before>& contours) {
    std::size_t found = 0;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        for (std::size_t e = 0; e < contours[c].edges(); ++e) {
            if (!contours[c].is_line(e)) {
                continue;
            }
            const Point a = contours[c].at(contours[c].begin_of(e));
            const Point b = contours[c].at(contours[c].end_of(e));
            for (std::size_t d = 0; d < contours.size(); ++d) {
                const Before& other = contours[d];
                const std::size_t count = other.edges();
                for (std::size_t f = 0; f < count; ++f) {
                    const Point from = other.at(other.begin_of(f));
                    const Point to = other.at(other.end_of(f));
                    if (c != d ||
                        (f != e && f != e + 1 && e != f + 1 && !(other.closed && f + e + 1 == count && f * e == 0))) {
                        found += rings::meet(a, b, from, to);
                    } else if (f != e) {
                        const bool after = f == e + 1 || (f == 0 && e + 1 == count && e != 1);
                        found += after ? rings::lies_on(a, b, to) || rings::lies_on(from, to, a)
                                       : rings::lies_on(a, b, from) || rings::lies_on(from, to, b);
                    }
                }
            }
        }
    }
    return found;
}

/// Counts pairs of a closed contour and another one whose start is no longer on the same side of it.
inline std::size_t starts_that_changed_sides(const std::vector<Before>& contours) {
    std::size_t moved = 0;
    for (const Before& around : contours) {
        Ring left;
        for (const std::size_t i : around.left) {
            left.push_back(around.points[i]);
        }
        for (const Before& other : contours) {
            const Point start = other.points.front();
            moved +=
                &other != &around && around.closed && rings::winding(around.points, start) != rings::winding(left, start);
        }
    }
    return moved;
}

struct Comparison {
    std::size_t points_before = 0;
    std::size_t points_after = 0;
};

/// Checks all promises of simplification.
inline Comparison compare(std::span<const Contour> before, std::span<const Point> points_before,
                          std::span<const Contour> after, std::span<const Point> points_after, double tolerance) {
    REQUIRE(before.size() == after.size());
    std::vector<Before> contours;
    Comparison sizes;
    for (std::size_t c = 0; c < before.size(); ++c) {
        const auto old_points = points_before.subspan(before[c].first_point, before[c].point_count);
        const auto new_points = points_after.subspan(after[c].first_point, after[c].point_count);
        CHECK(before[c].role == after[c].role);
        CHECK(before[c].orientation == after[c].orientation);
        CHECK(before[c].flags == after[c].flags);
        contours.push_back(match(old_points, new_points, before[c].role != Role::open));
        CHECK(lines_beyond(contours.back(), tolerance) == 0);
        CHECK((before[c].role == Role::open || new_points.size() >= std::min<std::size_t>(3, old_points.size())));
        sizes.points_before += old_points.size();
        sizes.points_after += new_points.size();
    }
    CHECK(meeting_lines(contours) == 0);
    CHECK(starts_that_changed_sides(contours) == 0);
    return sizes;
}

inline RegionRules simplified_by(double units, RegionRules rules = {}) {
    rules.simplify_mm = (units + 0.5) * unit_mm;
    return rules;
}

inline SliceResult region_by(const Rings& rings, const RegionRules& rules) {
    auto made = regions::region(rings, rules);
    INFO((made ? std::string() : made.error().message));
    REQUIRE(made.ok());
    return std::move(made).value();
}

/// Simplifies, compares with the plain region, and again from other starts and in another order of contours.
inline Comparison simplify(const Rings& rings, double units, const RegionRules& rules = {}) {
    const SliceResult before = region_by(rings, rules);
    const SliceResult after = region_by(rings, simplified_by(units, rules));
    const Comparison sizes = compare(before.contours, before.points, after.contours, after.points, units);
    Rings turned = rings;
    std::reverse(turned.begin(), turned.end());
    for (Ring& ring : turned) {
        std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(ring.size() / 3), ring.end());
    }
    CHECK(regions::same(after, region_by(turned, simplified_by(units, rules))));
    return sizes;
}

inline int sign_of_area(const lamella::NestItem& item) {
    const Wide twice = lamella::to_int128(item.twice_area);
    return (twice > 0) - (twice < 0);
}

/// The same of contours that may pass a point twice: the stage says which points it left.
inline Comparison simplify_as_given(const Rings& rings, std::int64_t tolerance) {
    std::vector<lamella::NestItem> items;
    for (const Ring& ring : rings) {
        items.push_back(lamella::closed_item(ring));
    }
    std::vector<lamella::NestItem> after = items;
    lamella::Worker worker;
    lamella::Simplifier simplifier(worker);
    simplifier.run(after, tolerance);
    std::vector<Before> contours;
    Comparison sizes;
    for (std::size_t c = 0; c < rings.size(); ++c) {
        Before contour{rings[c], {}, true};
        std::rotate(contour.points.begin(), contour.points.begin() + items[c].start, contour.points.end());
        const auto left = simplifier.left_of(c);
        contour.left.assign(left.begin(), left.end());
        REQUIRE(after[c].count == left.size());
        REQUIRE(contour.left.front() == 0);
        for (std::uint32_t i = 0; i < after[c].count; ++i) {
            REQUIRE(after[c].from_start(i) == contour.at(contour.left[i]));
        }
        CHECK(lines_beyond(contour, static_cast<double>(tolerance)) == 0);
        CHECK(sign_of_area(items[c]) == sign_of_area(after[c]));
        sizes.points_before += rings[c].size();
        sizes.points_after += left.size();
        contours.push_back(std::move(contour));
    }
    CHECK(meeting_lines(contours) == 0);
    CHECK(starts_that_changed_sides(contours) == 0);
    return sizes;
}

/// Around a centre, wavy and rough.
inline Ring wavy_ring(std::mt19937& random, Point centre, double radius, std::size_t count, double wave, double rough,
                      bool hole) {
    std::uniform_real_distribution<double> draw(-1, 1);
    const double turns = static_cast<double>(3 + random() % 9);
    Ring ring;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
        const double r = radius + wave * std::sin(turns * angle) + rough * draw(random);
        const Point p{centre.x + static_cast<std::int32_t>(std::lround(r * std::cos(angle))),
                      centre.y + static_cast<std::int32_t>(std::lround(r * std::sin(angle)))};
        if (ring.empty() || ring.back() != p) {
            ring.push_back(p);
        }
    }
    if (hole) {
        std::reverse(ring.begin(), ring.end());
    }
    return ring;
}

inline Ring circle(double radius, std::size_t count) {
    std::mt19937 unused(1);
    return wavy_ring(unused, {0, 0}, radius, count, 0, 0, false);
}

}  // namespace simplify_checks
