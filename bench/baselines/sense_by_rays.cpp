// A contour is a hole if an odd number of other contours of its plane enclose it. Every contour is tested against every
// other: a ray from one of its points counts crossings with the other. O(c²) tests. The orientation of facets is not
// used.
//
// A point on the other's boundary decides nothing, so the next point is tested. Contours that cross each other get
// arbitrary roles.
#include <algorithm>

#include "base/numbers.hpp"
#include "methods.hpp"

namespace lamella::baselines {

namespace {

enum class Place { outside, inside, boundary };

/// Counts crossings of the ray from p along x; exact.
Place place_in(const Polyline& polygon, Point p) {
    bool inside = false;
    Point a = polygon.points.back();
    for (const Point b : polygon.points) {
        const bool level = a.y == p.y && b.y == p.y;
        if (b == p || (level && (a.x < p.x) != (b.x < p.x))) {
            return Place::boundary;
        }
        if ((a.y <= p.y) != (b.y <= p.y)) {
            // Differences are at most 2^31, so products fit. The sign of b.y - a.y decides which way to compare them.
            const std::int64_t edge = (std::int64_t{b.x} - a.x) * (std::int64_t{p.y} - a.y);
            const std::int64_t ray = (std::int64_t{p.x} - a.x) * (std::int64_t{b.y} - a.y);
            if (edge == ray) {
                return Place::boundary;
            }
            inside ^= (edge > ray) == (b.y > a.y);
        }
        a = b;
    }
    return inside ? Place::inside : Place::outside;
}

bool lies_in(const Polyline& contour, const Polyline& other) {
    for (const Point p : contour.points) {
        if (const Place place = place_in(other, p); place != Place::boundary) {
            return place == Place::inside;
        }
    }
    return false;
}

Int128 twice_area(const Polyline& contour) {
    Int128 sum = 0;
    Point a = contour.points.back();
    for (const Point b : contour.points) {
        sum += Int128{a.x} * b.y - Int128{a.y} * b.x;
        a = b;
    }
    return sum;
}

Role role_of(const Polyline& polyline, const std::vector<Polyline>& plane) {
    if (!polyline.closed) {
        return Role::open;
    }
    if (twice_area(polyline) == 0) {
        return Role::flat;
    }
    const auto around = std::count_if(plane.begin(), plane.end(), [&](const Polyline& other) {
        return &other != &polyline && other.closed && lies_in(polyline, other);
    });
    return around % 2 == 0 ? Role::outer : Role::hole;
}

void turn(Polyline& polyline, Role role) {
    const bool closed = role == Role::outer || role == Role::hole;
    if (closed && (twice_area(polyline) > 0) != (role == Role::outer)) {
        std::reverse(polyline.points.begin(), polyline.points.end());
    }
}

}  // namespace

Roles sense_by_rays(Contours& contours) {
    Roles roles(contours.size());
    for (std::size_t i = 0; i < contours.size(); ++i) {
        for (Polyline& polyline : contours[i]) {
            roles[i].push_back(role_of(polyline, contours[i]));
            turn(polyline, roles[i].back());
        }
    }
    return roles;
}

}  // namespace lamella::baselines
