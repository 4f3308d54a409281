#include "slicing/repair/polylines.hpp"

#include <algorithm>

namespace lamella {

namespace {

/// By the start and its edge, then by content.
bool before(const Polyline& a, const Polyline& b) {
    if (a.points[0] != b.points[0]) {
        return a.points[0] < b.points[0];
    }
    if (a.start_key != b.start_key) {
        return a.start_key < b.start_key;
    }
    if (a.points.size() != b.points.size()) {
        return a.points.size() < b.points.size();
    }
    if (a.segments != b.segments) {
        return a.segments < b.segments;
    }
    const auto [at_a, at_b] = std::mismatch(a.points.begin(), a.points.end(), b.points.begin());
    return at_a != a.points.end() ? *at_a < *at_b : a.flags < b.flags;
}

}  // namespace

bool PolylineRepair::join(std::span<const Polyline> polylines, double reach, std::uint64_t layer,
                          Vector<ClosedGap>& closed_gaps) {
    sort(polylines);
    const std::span<const Gap> gaps = gap_closer_.close(ends_, reach);
    for (const Gap& gap : gaps) {
        closed_gaps.push_back({layer, ends_[gap.from].last, ends_[gap.to].first});
    }
    used_.assign(sorted_.size(), 0);
    joined_.clear();
    points_.clear();
    for (const bool in_rings : {false, true}) {
        for (std::uint32_t p = 0; p < sorted_.size() && !gaps.empty(); ++p) {
            if (used_[p] == 0 && gap_closer_.follows(p) == in_rings) {
                join_from(p);
            }
        }
    }
    return !gaps.empty();
}

void PolylineRepair::sort(std::span<const Polyline> polylines) {
    sorted_.assign(polylines.begin(), polylines.end());
    std::sort(sorted_.begin(), sorted_.end(), [this](const Polyline& a, const Polyline& b) {
        pace_.spend(1);
        return before(a, b);
    });
    ends_.clear();
    std::size_t points = 0;
    for (const Polyline& polyline : sorted_) {
        ends_.push_back({polyline.points.front(), polyline.points.back()});
        points += polyline.points.size();
    }
    points_.reserve(points);  // joined polylines point into it
}

/// Appends `first` and all that follow it.
void PolylineRepair::join_from(std::uint32_t first) {
    const std::size_t begin = points_.size();
    JoinedPolyline whole;
    whole.start_key = sorted_[first].start_key;
    for (std::int64_t next = first; next >= 0 && used_[static_cast<std::size_t>(next)] == 0;) {
        const auto p = static_cast<std::uint32_t>(next);
        const Polyline& part = sorted_[p];
        pace_.spend(part.points.size());
        points_.insert(points_.end(), part.points.begin(), part.points.end());
        whole.segments += part.segments;
        whole.flags |= part.flags;
        used_[p] = 1;
        next = gap_closer_.next(p);
    }
    whole.points = std::span(points_).subspan(begin);
    whole.closed = gap_closer_.follows(first);
    if (gap_closer_.next(first) >= 0) {
        whole.flags |= gap_closed;
    }
    joined_.push_back(whole);
}

}  // namespace lamella
