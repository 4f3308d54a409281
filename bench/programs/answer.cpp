#include "answer.hpp"

#include <algorithm>
#include <cassert>
#include <span>

#include "base/numbers.hpp"

namespace lamella::bench {

namespace {

std::uint64_t hash_of(Point p) noexcept {
    return std::uint64_t{static_cast<std::uint32_t>(p.x)} << 32 | static_cast<std::uint32_t>(p.y);
}

std::uint64_t hash_of(Point from, Point to) noexcept {
    return mix64(mix64(hash_of(from) + 0x9E3779B97F4A7C15U) + hash_of(to));
}

/// Skips segments of no length, because a contour stores two equal successive points as one.
void add_segment(PlaneAnswer& plane, Point a, Point b) {
    if (a != b) {
        plane.segments += a < b ? hash_of(a, b) : hash_of(b, a);
    }
}

void add_contour(PlaneAnswer& plane, std::span<const Point> points, bool closed) {
    std::uint64_t steps = 0;
    for (std::size_t i = 1; i < points.size() + (closed ? 1 : 0); ++i) {
        const Point from = points[i - 1];
        const Point to = points[i % points.size()];
        add_segment(plane, from, to);
        steps += from != to ? hash_of(from, to) : 0;
    }
    if (closed) {
        plane.closed.push_back(mix64(steps));
    }
}

/// `add(plane, l)` adds what plane l has.
template <class Add>
Answer answer_of_planes(std::size_t planes, const Add& add) {
    Answer answer(planes);
    for (std::size_t l = 0; l < planes; ++l) {
        add(answer[l], l);
        std::sort(answer[l].closed.begin(), answer[l].closed.end());
    }
    return answer;
}

}  // namespace

Answer answer_of(const SliceResult& result) {
    return answer_of_planes(result.layers.size(), [&](PlaneAnswer& plane, std::size_t l) {
        for (const Contour& contour : result.contours_of(result.layers[l])) {
            add_contour(plane, result.points_of(contour), contour.role != Role::open);
        }
    });
}

Answer answer_of(const baselines::Contours& contours) {
    return answer_of_planes(contours.size(), [&](PlaneAnswer& plane, std::size_t l) {
        for (const baselines::Polyline& contour : contours[l]) {
            add_contour(plane, contour.points, contour.closed);
        }
    });
}

Answer answer_of(const baselines::SegmentLists& lists) {
    return answer_of_planes(lists.size(), [&](PlaneAnswer& plane, std::size_t l) {
        for (const baselines::Segment& segment : lists[l]) {
            add_segment(plane, segment.from, segment.to);
        }
    });
}

Difference difference(const Answer& expected, const Answer& found) {
    assert(expected.size() == found.size());
    Difference all;
    for (std::size_t l = 0; l < expected.size(); ++l) {
        all.planes += expected[l].segments != found[l].segments ? 1U : 0U;
        std::vector<std::uint64_t> apart;
        std::set_symmetric_difference(expected[l].closed.begin(), expected[l].closed.end(), found[l].closed.begin(),
                                      found[l].closed.end(), std::back_inserter(apart));
        all.contours += apart.size();
    }
    return all;
}

}  // namespace lamella::bench
