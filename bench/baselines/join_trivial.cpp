// A contour begins with any segment; all that are left are looked through for one that has an end where the contour ends,
// which is turned as needed, appended and removed, until the loop closes. O(m²) for a plane of m segments.
//
// Ends are told apart by their rounded points, so that contours that touch may fuse or be cut up. Added for what the paper
// takes to be well-formed: a segment that rounding has left without length is dropped, and a polyline that ends is followed
// from its other end too.
#include "join_trivial.hpp"

#include <algorithm>

namespace lamella::baselines {

namespace {

/// Appends segments until the polyline closes or none is left that goes on; returns whether it closed.
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

const ContourMethod trivial_contours{
    .name = "trivial", .source = "Minetto et al. 2017, section 2.2", .join_plane = join_plane};

}  // namespace lamella::baselines
