#include "slicing/repair/polylines.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <tuple>

#include "base/sort.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// Two ends that are each other's nearest are a pair, whatever is joined before them, since everything else is farther from
/// both. The pairs can therefore be found in any order; sorting all distances is not needed.
std::span<const Gap> GapCloser::close(std::span<const PolylineEnds> polylines, const GapRules& rules) {
    assert(polylines.size() < std::size_t{1} << 31);
    reach_squared_ = std::min(rules.reach * rules.reach, std::numeric_limits<double>::max());
    sense_ = rules.sense;
    joined_to_.clear();
    joined_to_.reserve(2 * polylines.size());
    for (std::uint32_t p = 0; p < polylines.size(); ++p) {
        joined_to_.emplace_back(p, false);
        joined_to_.emplace_back(p, true);
    }
    list_sites(polylines);
    gaps_.clear();
    follow_chains(first_sites_, static_cast<SiteNumber>(sites_.size()));
    if (sense_ == StitchDirection::any) {  // else nothing is left to join
        follow_chains(0, first_sites_);
    }
    sort_gaps(polylines);
    return gaps_;
}

void GapCloser::list_sites(std::span<const PolylineEnds> polylines) {
    const auto at = [polylines](PolylineEnd end) { return polylines[end.polyline()].at(end.last()); };
    ends_.assign(joined_to_.begin(), joined_to_.end());
    sort_briefly(ends_.begin(), ends_.end(), [&at, this](PolylineEnd a, PolylineEnd b) {
        worker_.spend(1);
        return std::tuple(a.last(), at(a), a.number()) < std::tuple(b.last(), at(b), b.number());
    });
    sites_.clear();
    sites_.reserve(ends_.size());
    first_sites_ = 0;
    for (std::uint32_t i = 0; i < ends_.size(); ++i) {
        if (i == polylines.size()) {
            first_sites_ = static_cast<SiteNumber>(sites_.size());
        }
        if (i == 0 || i == polylines.size() || sites_.back().at != at(ends_[i])) {
            sites_.push_back({at(ends_[i]), i, i});
        }
        ++sites_.back().end;
    }
    for (const bool last : {false, true}) {
        const std::size_t end = last ? sites_.size() : first_sites_;
        trees_[last ? 1 : 0].assign(end - base_of(last), [&](std::size_t i) { return sites_[base_of(last) + i].at; });
    }
}

PolylineEnd GapCloser::take(SiteNumber site) noexcept {
    assert(count_at(site) > 0);
    const PolylineEnd end = ends_[sites_[site].next++];
    if (count_at(site) == 0) {
        take_off(site);
    }
    return end;
}

/// Until no end is left at the sites from `begin` to `end`.
void GapCloser::follow_chains(SiteNumber begin, SiteNumber end) {
    for (SiteNumber site = begin; site < end; ++site) {
        while (count_at(site) > 0) {
            follow_chain(site);
        }
    }
}

/// Follows the chain from `first` to the site nearest to it, to the one nearest to that, and so on. Pairs come ever earlier
/// in the order in which they are joined, until two sites are each other's nearest. They are joined, and the chain goes on
/// from the site before them, so that no search is repeated. On return an end of `first` is joined, or all are taken off if
/// nothing is within reach.
void GapCloser::follow_chain(SiteNumber first) {
    chain_.assign(1, first);
    while (!chain_.empty()) {
        const SiteNumber site = chain_.back();
        const SiteNumber other = nearest(site);
        if (other == none) {
            sites_[site].next = sites_[site].end;  // it is `first`: all others are within reach of their predecessor
            take_off(site);
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

/// The nearest site of its kind where an end is left, at most the square root of `most_squared` away, or none. At equal
/// distances the smallest point.
GapCloser::SiteNumber GapCloser::nearest_of(bool last, Point to, double most_squared, SiteNumber but) const {
    const SiteNumber found = trees_[last ? 1 : 0].nearest(to, most_squared, but == none ? none : but - base_of(last));
    return found == none ? none : base_of(last) + found;
}

/// The site whose ends come first among those that an end at `site` can be joined to: the site itself where two ends of a
/// kind meet there and no end of the other kind does.
GapCloser::SiteNumber GapCloser::nearest(SiteNumber site) const {
    const Point from = sites_[site].at;
    const SiteNumber kept = nearest_of(!is_last(site), from, reach_squared_, none);
    const double least = kept == none ? reach_squared_ : squared_distance(from, sites_[kept].at);
    if (sense_ == StitchDirection::oriented || (kept != none && least == 0)) {
        return kept;
    }
    if (count_at(site) > 1) {
        return site;
    }
    const SiteNumber turned = nearest_of(is_last(site), from, least, site);
    return turned != none && (kept == none || squared_distance(from, sites_[turned].at) < least) ? turned : kept;
}

/// Joins as many as both sites hold. All are equally far apart, so they are paired by number.
void GapCloser::join(SiteNumber a, SiteNumber b) {
    const auto [from, to] = is_last(a) != is_last(b) ? std::minmax(a, b, std::greater<>()) : std::minmax(a, b);
    const std::uint32_t count = a == b ? count_at(a) / 2 : std::min(count_at(a), count_at(b));
    for (std::uint32_t i = 0; i < count; ++i) {
        const PolylineEnd end = take(from);
        const PolylineEnd start = take(to);
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
    sort_briefly(gaps_.begin(), gaps_.end(), [polylines, this](const Gap& a, const Gap& b) {
        worker_.spend(1);
        const auto key = [polylines](const Gap& gap) {
            const Point from = polylines[gap.from.polyline()].at(gap.from.last());
            const Point to = polylines[gap.to.polyline()].at(gap.to.last());
            const bool turns = gap.from.last() == gap.to.last();
            return std::tuple(squared_distance(from, to), turns, from, to, gap.from.number(), gap.to.number());
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
    // From first points that are not joined, then what has a last point at both of its ends, then rings.
    for (const int pass : {0, 1, 2}) {
        for (std::uint32_t p = 0; p < sorted_.size(); ++p) {
            const PolylineEnd end{p, pass == 1};
            if (used_[p] == 0 && (pass == 2 || !gap_closer_.is_joined(end))) {
                join_from(end);
            }
        }
    }
    return true;
}

std::span<const Gap> PolylineRepair::choose_gaps(std::span<const Path> around, const GapRules& rules) {
    const std::span<const Gap> gaps = gap_closer_.close(ends_, rules);
    joints_.clear();
    std::size_t free = 0;
    for (const Gap& gap : gaps) {
        joints_.insert(joints_.end(), {at(gap.from), at(gap.to)});
        free += squared_distance(at(gap.from), at(gap.to)) <= rules.crossing_reach * rules.crossing_reach ? 1U : 0U;
    }
    if (free == gaps.size()) {
        return gaps;
    }
    mark_crossed(around, free);
    return gap_closer_.leave_open(crossed_);
}

/// Marks joints, the shortest first, that between their ends meet an edge of a contour, or a joint before them that is not
/// marked; edges along their lines do not count. The first `free` joints are not marked, whatever they meet.
///
///        .--------.  .--------.      `a` and `b` are the nearest ends, but a wall lies between them: they are not joined.
///        |        a||b        |
///        |         ||         |
///        '---------++---------'
void PolylineRepair::mark_crossed(std::span<const Path> around, std::size_t free) {
    pairs_.clear();
    for (const std::span<const Path> paths : {std::span<const Path>(sorted_), around}) {
        for (const Path& path : paths) {
            pairs_.add({.points = points_of(path), .contour = no_joint, .closed = path.item.closed});
        }
    }
    for (std::size_t i = 0; i < joints_.size(); i += 2) {
        pairs_.add({.points = std::span(joints_).subspan(i, 2), .contour = i / 2, .closed = false});
    }
    crossed_.assign(joints_.size() / 2, 0);
    between_joints_.clear();
    pairs_.find(0, no_joint, [&](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        const auto [joint, path, edge] =
            a.contour <= b.contour ? std::tuple(a.contour, &b, j) : std::tuple(b.contour, &a, i);
        if (joint == no_joint ||
            !meets_between_ends(joints_[2 * joint], joints_[2 * joint + 1], (*path)[edge], (*path)[edge + 1])) {
            return;
        }
        if (path->contour == no_joint) {
            crossed_[joint] = joint >= free ? 1 : 0;
        } else if (path->contour >= free) {
            between_joints_.emplace_back(static_cast<std::uint32_t>(path->contour), static_cast<std::uint32_t>(joint));
        }
    });
    sort_briefly(between_joints_.begin(), between_joints_.end());
    for (const auto& [later, earlier] : between_joints_) {
        crossed_[later] |= static_cast<std::uint8_t>(crossed_[earlier] == 0);
    }
}

void PolylineRepair::sort(std::span<const Path> polylines) {
    sorted_.assign(polylines.begin(), polylines.end());
    sort_briefly(sorted_.begin(), sorted_.end(), [this](const Path& a, const Path& b) {
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
