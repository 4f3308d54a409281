#include "slicing/repair/polylines.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "slicing/grid/exact.hpp"
#include "slicing/grid/origins.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t no_joint = std::numeric_limits<std::uint64_t>::max();

/// True if the edge from `c` to `d` meets the joint between the joint's ends, and does not run along it.
bool meets_between_ends(Point from, Point to, Point c, Point d) noexcept {
    return side_of(c, d, from) * side_of(c, d, to) < 0 && side_of(from, to, c) * side_of(from, to, d) <= 0;
}

}  // namespace

void CrossedJoints::add(std::span<const Point> contour, bool closed) {
    pairs_.add({.points = contour, .contour = no_joint, .closed = closed});
}

std::span<const std::uint8_t> CrossedJoints::find(std::span<const Joint> joints, std::size_t free) {
    ends_.clear();
    ends_.reserve(2 * joints.size());
    for (const Joint& joint : joints) {
        ends_.insert(ends_.end(), {joint.from, joint.to});
        pairs_.add({.points = std::span(ends_).last(2), .contour = ends_.size() / 2 - 1, .closed = false});
    }
    crossed_.assign(joints.size(), 0);
    between_joints_.clear();
    pairs_.find(0, no_joint, [&](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        const auto [joint, path, edge] =
            a.contour <= b.contour ? std::tuple(a.contour, &b, j) : std::tuple(b.contour, &a, i);
        if (joint == no_joint ||
            !meets_between_ends(joints[joint].from, joints[joint].to, (*path)[edge], (*path)[edge + 1])) {
            return;
        }
        if (path->contour == no_joint) {
            crossed_[joint] = joint >= free ? 1 : 0;
        } else if (path->contour >= free) {
            between_joints_.emplace_back(static_cast<std::uint32_t>(path->contour), static_cast<std::uint32_t>(joint));
        }
    });
    std::sort(between_joints_.begin(), between_joints_.end());
    for (const auto& [later, earlier] : between_joints_) {
        crossed_[later] |= static_cast<std::uint8_t>(crossed_[earlier] == 0);
    }
    return crossed_;
}

namespace {

std::span<const Point> points_of(const Path& path) noexcept {
    return {path.item.points, path.item.count};
}

}  // namespace

bool PolylineRepair::join(std::span<const Path> polylines, std::span<const Path> around, const GapRules& rules,
                          std::uint64_t layer, Vector<Stitch>& stitches) {
    sort(polylines);
    const std::span<const Gap> gaps = choose_gaps(around, rules);
    for (const Gap& gap : gaps) {
        stitches.push_back({layer, at(gap.from), at(gap.to)});
    }
    used_.assign(sorted_.size(), 0);
    joined_.clear();
    points_.clear();
    origins_.clear();
    if (gaps.empty()) {
        return false;
    }
    join_open_from(false);
    join_open_from(true);
    join_rings();
    return true;
}

std::span<const Gap> PolylineRepair::choose_gaps(std::span<const Path> around, const GapRules& rules) {
    const std::span<const Gap> gaps = gap_closer_.close(ends_, rules);
    joints_.clear();
    std::size_t free = 0;
    for (const Gap& gap : gaps) {
        joints_.push_back({at(gap.from), at(gap.to)});
        free += squared_distance(at(gap.from), at(gap.to)) <= rules.crossing_reach * rules.crossing_reach ? 1 : 0;
    }
    if (free == joints_.size()) {
        return gaps;
    }
    crossed_joints_.clear();
    for (const Path& polyline : sorted_) {
        crossed_joints_.add(points_of(polyline), false);
    }
    for (const Path& contour : around) {
        crossed_joints_.add(points_of(contour), true);
    }
    return gap_closer_.leave_open(crossed_joints_.find(joints_, free));
}

/// Joins what starts at a first (a last) point that is not joined. After all that start at a first point, only what has a
/// last point at both of its ends is left for the last points.
void PolylineRepair::join_open_from(bool last) {
    for (std::uint32_t p = 0; p < sorted_.size(); ++p) {
        const PolylineEnd end{p, last};
        if (used_[p] == 0 && !gap_closer_.is_joined(end)) {
            join_from(end);
        }
    }
}

void PolylineRepair::join_rings() {
    for (std::uint32_t p = 0; p < sorted_.size(); ++p) {
        if (used_[p] == 0) {
            join_from({p, false});
        }
    }
}

void PolylineRepair::sort(std::span<const Path> polylines) {
    sorted_.assign(polylines.begin(), polylines.end());
    std::sort(sorted_.begin(), sorted_.end(), [this](const Path& a, const Path& b) {
        worker_.spend(1);
        return comes_before(a, b);
    });
    ends_.clear();
    std::size_t points = 0;
    for (const Path& polyline : sorted_) {
        ends_.push_back({points_of(polyline).front(), points_of(polyline).back()});
        points += polyline.item.count;
    }
    points_.reserve(points);  // joined polylines point into it, and into origins_
    if (!polylines.empty() && polylines.front().item.origins != nullptr) {
        origins_.reserve(points);
    }
}

/// True if an edge that has a length leads on from the end of a polyline.
bool PolylineRepair::leads_on_from(PolylineEnd last) const {
    if (!gap_closer_.is_joined(last)) {
        return false;
    }
    const PolylineEnd next = gap_closer_.joined_to(last);
    return at(next) != at(last);
}

/// Joins all polylines that follow each other from `first` on, up to an end that is not joined or until they meet `first`.
/// An edge that joins two of them comes from no triangle.
void PolylineRepair::join_from(PolylineEnd first) {
    const std::size_t begin = points_.size();
    const bool closed = gap_closer_.is_joined(first);
    std::uint64_t segments[2] = {0, 0};  // along the walk, against it
    bool runs[2] = {false, false};
    bool is_joined = closed;
    std::uint16_t flags = 0;
    PolylineEnd last = first;
    for (PolylineEnd entered = first; used_[entered.polyline()] == 0; entered = gap_closer_.joined_to(last)) {
        const Path& part = sorted_[entered.polyline()];
        append(entered);
        segments[entered.last() ? 1 : 0] += part.segments;
        runs[entered.last() ? 1 : 0] = true;
        flags |= part.item.flags;
        last = entered.other();
        is_joined |= gap_closer_.is_joined(last);
    }
    const auto points = std::span(points_).subspan(begin);
    PointOrigin* const origins = origins_.empty() ? nullptr : origins_.data() + begin;
    const bool turned = segments[1] > segments[0] || !runs[0];
    if (turned) {
        turn_round(points, origins, closed);
    }
    const PolylineEnd start = turned ? last : first;
    Path& whole = joined_.emplace_back(closed ? closed_path(points, origins) : open_path(points, origins));
    whole.start_key = closed || start.last() ? EndKey{} : sorted_[start.polyline()].start_key;
    whole.segments = static_cast<std::uint32_t>(segments[0] + segments[1]);
    whole.item.flags =
        static_cast<std::uint16_t>(flags | (is_joined ? stitched : 0) | (runs[0] && runs[1] ? orientation_mixed : 0));
}

/// Appends the points of a polyline from `entered` to its other end.
void PolylineRepair::append(PolylineEnd entered) {
    const NestItem& part = sorted_[entered.polyline()].item;
    worker_.spend(part.count);
    points_.insert(points_.end(), part.points, part.points + part.count);
    if (part.origins != nullptr) {
        origins_.insert(origins_.end(), part.origins, part.origins + part.count);
    }
    if (entered.last()) {
        turn_round(std::span(points_).last(part.count),
                   origins_.empty() ? nullptr : origins_.data() + (origins_.size() - part.count), false);
    }
    if (part.origins != nullptr && leads_on_from(entered.other())) {
        origins_.back() = PointOrigin();
    }
    used_[entered.polyline()] = 1;
}

}  // namespace lamella
