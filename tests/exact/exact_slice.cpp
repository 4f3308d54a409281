#include "exact/exact_slice.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>

namespace exact {

using lamella::GridVertex;

namespace {

constexpr std::size_t none = static_cast<std::size_t>(-1);

struct Segment {
    Point2 from;
    Point2 to;
};

/// A segment's end, listed at the point where segments meet.
struct End {
    std::size_t segment;
    bool leaves;
};

using Meetings = std::map<Point2, std::vector<End>, Kernel::Less_xy_2>;

Point2 crossing(const Kernel::Plane_3& plane, GridVertex u, GridVertex v) {
    const auto space = [](GridVertex g) { return Kernel::Point_3(g.x, g.y, g.z); };
    const auto met = CGAL::intersection(plane, Kernel::Segment_3(space(u), space(v)));
    const auto* point = met ? boost::get<Kernel::Point_3>(&*met) : nullptr;
    if (point == nullptr) {
        throw std::logic_error("an edge that crosses the plane does not meet it in a point");
    }
    return {point->x(), point->y()};
}

/// The segments have the solid on the left: faces are counter-clockwise, and a segment starts at the edge that its face
/// runs down.
std::vector<Segment> segments_at(std::span<const oracle::Triangle> triangles, std::int32_t z) {
    const Kernel::Plane_3 plane(0, 0, 1, -z);
    std::vector<Segment> segments;
    for (const oracle::Triangle& t : triangles) {
        std::array<Point2, 2> ends;
        bool crossed = false;
        for (std::size_t i = 0; i < 3; ++i) {
            const GridVertex u = t[i];
            const GridVertex v = t[(i + 1) % 3];
            if ((u.z < z) != (v.z < z)) {
                ends[v.z < z ? 0 : 1] = crossing(plane, u, v);
                crossed = true;
            }
        }
        if (crossed) {
            segments.push_back({ends[0], ends[1]});
        }
    }
    return segments;
}

void sort_counter_clockwise(std::vector<End>& ends, const std::vector<Segment>& segments) {
    const auto direction = [&](const End& end) {
        const Segment& s = segments[end.segment];
        return end.leaves ? Kernel::Direction_2(s.to - s.from) : Kernel::Direction_2(s.from - s.to);
    };
    std::sort(ends.begin(), ends.end(), [&](const End& a, const End& b) { return direction(a) < direction(b); });
    for (std::size_t i = 1; i < ends.size(); ++i) {
        if (direction(ends[i - 1]) == direction(ends[i])) {
            throw std::logic_error("more than two segments meet, and two of them in the same direction");
        }
    }
}

/// By segment: the segment that starts where it ends, or none.
std::vector<std::size_t> successors(const std::vector<Segment>& segments) {
    Meetings meetings;
    for (std::size_t s = 0; s < segments.size(); ++s) {
        meetings[segments[s].from].push_back({s, true});
        meetings[segments[s].to].push_back({s, false});
    }
    std::vector<std::size_t> next(segments.size(), none);
    for (auto& [point, ends] : meetings) {
        if (ends.size() > 2) {
            sort_counter_clockwise(ends, segments);
        }
        for (std::size_t i = 0; i < ends.size() && ends.size() > 1; ++i) {
            const End& clockwise = ends[(i + ends.size() - 1) % ends.size()];
            if (ends[i].leaves == clockwise.leaves) {
                throw std::logic_error("two segments that meet both start or both end there");
            }
            if (!ends[i].leaves) {
                next[ends[i].segment] = clockwise.segment;
            }
        }
    }
    return next;
}

}  // namespace

std::vector<Chain> chains_at(std::span<const oracle::Triangle> triangles, std::int32_t z) {
    const std::vector<Segment> segments = segments_at(triangles, z);
    const std::vector<std::size_t> next = successors(segments);
    std::vector<char> used(segments.size(), 0);
    std::vector<char> follows(segments.size(), 0);
    for (const std::size_t s : next) {
        if (s != none) {
            follows[s] = 1;
        }
    }
    std::vector<Chain> chains;
    const auto follow = [&](std::size_t first, bool closed) {
        Chain chain{{}, closed};
        std::size_t last = first;
        for (std::size_t s = first; s != none && used[s] == 0; s = next[s]) {
            used[s] = 1;
            chain.points.push_back(segments[s].from);
            last = s;
        }
        if (!closed) {
            chain.points.push_back(segments[last].to);
        }
        chains.push_back(std::move(chain));
    };
    for (const bool closed : {false, true}) {
        for (std::size_t s = 0; s < segments.size(); ++s) {
            if (used[s] == 0 && (closed || follows[s] == 0)) {
                follow(s, closed);
            }
        }
    }
    return chains;
}

bool strictly_around(const Chain& chain, const Point2& p) {
    int winding = 0;
    for (std::size_t i = 0; i < chain.points.size(); ++i) {
        const Point2& a = chain.points[i];
        const Point2& b = chain.points[(i + 1) % chain.points.size()];
        const bool a_below = CGAL::compare_y(a, p) != CGAL::LARGER;
        const bool b_below = CGAL::compare_y(b, p) != CGAL::LARGER;
        if (a_below != b_below) {
            const CGAL::Orientation side = CGAL::orientation(a, b, p);
            if (side == CGAL::COLLINEAR) {
                return false;
            }
            winding +=
                static_cast<int>(a_below && side == CGAL::LEFT_TURN) - static_cast<int>(b_below && side == CGAL::RIGHT_TURN);
        } else if (a == p || (CGAL::compare_y(a, p) == CGAL::EQUAL && CGAL::compare_y(b, p) == CGAL::EQUAL &&
                              CGAL::collinear_are_ordered_along_line(a, p, b))) {
            return false;
        }
    }
    return winding != 0;
}

}  // namespace exact
