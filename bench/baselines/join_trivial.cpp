// A contour begins with any segment. A linear search finds an unused segment with an end where the contour ends. It is
// reversed if needed, appended and removed, until the contour closes. O(m²) for m segments in a plane.
//
// Segment ends are compared by their rounded points, so contours that touch may fuse or be split. The paper assumes
// well-formed input. For other input, a segment of no length after rounding is dropped, and a polyline that ends is
// continued from its other end.
#include "methods.hpp"

#include <algorithm>

namespace lamella::baselines {

namespace {

/// Appends segments until the polyline closes or none continues it. Returns whether it closed.
bool prolong(std::vector<Point>& points, std::vector<Segment>& left) {
    while (points.front() != points.back()) {
        const Point end = points.back();
        const auto next = std::find_if(left.begin(), left.end(),
                                       [end](const Segment& segment) { return segment.from == end || segment.to == end; });
        if (next == left.end()) {
            return false;
        }
        points.push_back(next->from == end ? next->to : next->from);
        *next = left.back();
        left.pop_back();
    }
    return true;
}

Polyline polyline_from(const Segment& segment, std::vector<Segment>& left) {
    Polyline polyline{{segment.from, segment.to}, false};
    polyline.closed = prolong(polyline.points, left);
    if (polyline.closed) {
        polyline.points.pop_back();
        return polyline;
    }
    std::reverse(polyline.points.begin(), polyline.points.end());
    prolong(polyline.points, left);
    std::reverse(polyline.points.begin(), polyline.points.end());
    return polyline;
}

std::vector<Polyline> join_plane(const std::vector<Segment>& segments) {
    std::vector<Segment> left = segments;
    std::erase_if(left, [](const Segment& segment) { return segment.from == segment.to; });
    std::vector<Polyline> polylines;
    while (!left.empty()) {
        const Segment first = left.back();
        left.pop_back();
        polylines.push_back(polyline_from(first, left));
    }
    return polylines;
}

}  // namespace

const ContourMethod trivial_contours{.name = "trivial", .join_plane = join_plane};

}  // namespace lamella::baselines
