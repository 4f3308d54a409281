#include "slicing/repair/polylines.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "slicing/grid/exact.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

void EndTree::assign(std::span<const PolylineEnds> polylines, Point PolylineEnds::*end) {
    polylines_.resize(polylines.size());
    std::iota(polylines_.begin(), polylines_.end(), 0U);
    std::sort(polylines_.begin(), polylines_.end(), [polylines, end, this](std::uint32_t a, std::uint32_t b) {
        worker_.spend(1);
        return std::tie(polylines[a].*end, a) < std::tie(polylines[b].*end, b);
    });
    sites_.clear();
    for (std::uint32_t i = 0; i < polylines_.size(); ++i) {
        const Point at = polylines[polylines_[i]].*end;
        if (sites_.empty() || sites_.back().at != at) {
            sites_.push_back({at, i, i});
        }
        ++sites_.back().end;
    }
    tree_.assign(sites_.size(), [this](std::size_t site) { return sites_[site].at; });
}

std::uint32_t EndTree::take(std::uint32_t site) noexcept {
    assert(holds(site));
    const std::uint32_t polyline = polylines_[sites_[site].next++];
    if (!holds(site)) {
        tree_.take_off(site);
    }
    return polyline;
}

void EndTree::take_all(std::uint32_t site) noexcept {
    sites_[site].next = sites_[site].end;
    tree_.take_off(site);
}

/// Two ends that are each other's nearest are a pair, whatever is joined before them, since everything else is farther from
/// both. The pairs can therefore be found in any order; sorting all distances is not needed.
std::span<const Gap> GapCloser::close(std::span<const PolylineEnds> polylines, const GapRules& rules) {
    assert(polylines.size() < std::size_t{1} << 31);
    reach_squared_ = std::min(rules.reach * rules.reach, std::numeric_limits<double>::max());
    sense_ = rules.sense;
    ends_.assign(polylines, &PolylineEnds::last);
    starts_.assign(polylines, &PolylineEnds::first);
    joined_to_.clear();
    joined_to_.reserve(2 * polylines.size());
    for (std::uint32_t p = 0; p < polylines.size(); ++p) {
        joined_to_.emplace_back(p, false);
        joined_to_.emplace_back(p, true);
    }
    gaps_.clear();
    follow_chains(true);
    if (sense_ == StitchDirection::any) {
        follow_chains(false);
    }
    sort_gaps(polylines);
    return gaps_;
}

/// Until no last or no first point is left.
void GapCloser::follow_chains(bool last) {
    const EndTree& tree = tree_of(last);
    for (std::uint32_t site = 0; site < tree.site_count(); ++site) {
        while (tree.holds(site)) {
            follow_chain({site, last});
        }
    }
}

/// Follows the chain from `first` to the site nearest to it, to the one nearest to that, and so on. Pairs come ever earlier
/// in the order in which they are joined, until two sites are each other's nearest. They are joined, and the chain goes on
/// from the site before them, so that no search is repeated. On return an end of `first` is joined, or all are taken off if
/// nothing is within reach.
void GapCloser::follow_chain(Site first) {
    chain_.assign(1, first);
    while (!chain_.empty()) {
        const Site site = chain_.back();
        const Site other = nearest(site);
        if (other == no_site) {
            tree_of(site.last).take_all(site.number);  // it is `first`: all others are within reach of their predecessor
            chain_.pop_back();
        } else if (other == site) {
            join(site, site);
            chain_.pop_back();
        } else if (chain_.size() > 1 && other == chain_.end()[-2]) {
            join(site, other);
            chain_.resize(chain_.size() - 2);
        } else {
            chain_.push_back(other);
        }
    }
}

/// The site whose ends come first among those that an end at `site` can be joined to: the site itself where two ends of a
/// kind meet there and no end of the other kind does.
GapCloser::Site GapCloser::nearest(Site site) {
    const Point from = at(site);
    const Site kept{tree_of(!site.last).nearest(from, reach_squared_), !site.last};
    if (sense_ == StitchDirection::oriented) {
        return kept.number == EndTree::none ? no_site : kept;
    }
    double least = reach_squared_;
    if (kept.number != EndTree::none) {
        least = squared_distance(from, at(kept));
        if (least == 0) {
            return kept;
        }
    }
    EndTree& same = tree_of(site.last);
    if (same.count_at(site.number) > 1) {
        return site;
    }
    const Site turned{same.nearest(from, least, site.number), site.last};
    const bool turns =
        turned.number != EndTree::none && (kept.number == EndTree::none || squared_distance(from, at(turned)) < least);
    return turns ? turned : (kept.number == EndTree::none ? no_site : kept);
}

/// Joins as many as both sites hold. All are equally far apart, so they are paired by number.
void GapCloser::join(Site a, Site b) {
    const bool swap = a.last != b.last ? b.last : at(b) < at(a);
    const auto [from, to] = swap ? std::pair(b, a) : std::pair(a, b);
    EndTree& tree_from = tree_of(from.last);
    EndTree& tree_to = tree_of(to.last);
    const std::uint32_t count =
        a == b ? tree_from.count_at(a.number) / 2 : std::min(tree_from.count_at(from.number), tree_to.count_at(to.number));
    for (std::uint32_t i = 0; i < count; ++i) {
        const PolylineEnd end{tree_from.take(from.number), from.last};
        const PolylineEnd start{tree_to.take(to.number), to.last};
        joined_to_[end.number()] = start;
        joined_to_[start.number()] = end;
        gaps_.push_back({end, start});
    }
}

std::span<const Gap> GapCloser::leave_open(std::span<const std::uint8_t> crossed) {
    std::size_t kept = 0;
    for (std::size_t g = 0; g < gaps_.size(); ++g) {
        const Gap gap = gaps_[g];
        if (crossed[g] == 0) {
            gaps_[kept++] = gap;
        } else {
            joined_to_[gap.from.number()] = gap.from;
            joined_to_[gap.to.number()] = gap.to;
        }
    }
    gaps_.erase(gaps_.begin() + static_cast<std::ptrdiff_t>(kept), gaps_.end());
    return gaps_;
}

/// By distance; see close().
void GapCloser::sort_gaps(std::span<const PolylineEnds> polylines) {
    std::sort(gaps_.begin(), gaps_.end(), [polylines, this](const Gap& a, const Gap& b) {
        worker_.spend(1);
        const auto key = [polylines](const Gap& gap) {
            const Point from = polylines[gap.from.polyline()].at(gap.from.last());
            const Point to = polylines[gap.to.polyline()].at(gap.to.last());
            return std::tuple(squared_distance(from, to), gap.turns(), from, to, gap.from.number(), gap.to.number());
        };
        return key(a) < key(b);
    });
}

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
