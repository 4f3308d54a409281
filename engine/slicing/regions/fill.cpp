#include "slicing/regions/fill.hpp"

#include <algorithm>
#include <cassert>

namespace lamella {

namespace {

constexpr std::size_t item_work = 4;  ///< as StopPace counts it

}  // namespace

Fill::Fill(const Memory* memory)
    : contacts_(memory), items_(memory), own_(memory), members_(memory), region_(memory), points_(memory) {}

bool Fill::run(std::span<const NestItem> contours, FillRule rule, Nester& nester) {
    assert(rule != FillRule::contours);
    region_.clear();
    points_.clear();
    clusters_ = 0;
    merge_equal_ones(contours);
    if (!contacts_.find(items_)) {
        return false;
    }
    find_clusters(nester);
    clipping_.begin();
    const std::uint32_t* cluster = members_.data();
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        pace_.spend(item_work);
        if (!own_[c].clipped) {
            keep_or_drop(c, rule);
        } else if (contacts_.leader(c) == c) {
            const std::uint32_t* const begin = cluster;
            while (cluster != members_.data() + members_.size() && contacts_.leader(*cluster) == c) {
                ++cluster;
            }
            if (!clip_cluster({begin, cluster}, rule)) {
                return false;
            }
        }
    }
    return true;
}

void Fill::merge_equal_ones(std::span<const NestItem> contours) {
    items_.clear();
    own_.clear();
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        pace_.spend(item_work);
        if (c > 0 && std::is_eq(compare_points(contours[c - 1], contours[c]))) {
            ++own_.back().times;
        } else {
            items_.push_back(contours[c]);
            own_.push_back({c, 1});
        }
    }
}

/// A contour inside a clipped one is clipped with it. Nesting finds those contours. Self-intersecting contours are made the
/// smallest of all for it, so that each contour inside one has it as parent, or has another contour inside it as parent.
void Fill::find_clusters(Nester& nester) {
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        if (contacts_.meets_itself(c)) {
            items_[c].twice_area = {1, 0};
        }
        pace_.spend(item_work);
        const std::uint32_t leader = contacts_.leader(c);
        own_[leader].clipped = own_[leader].clipped || leader != c || contacts_.meets_itself(c);
    }
    nester.nest(items_);
    members_.clear();
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        const std::int32_t parent = items_[c].parent;
        assert(parent < static_cast<std::int32_t>(c) && "a parent starts before its children");
        if (parent >= 0 && own_[static_cast<std::size_t>(parent)].clipped) {
            contacts_.join(c, static_cast<std::uint32_t>(parent));
        }
        own_[c].clipped = own_[contacts_.leader(c)].clipped;
        if (own_[c].clipped) {
            members_.push_back(c);
        }
    }
    std::sort(members_.begin(), members_.end(), [this](std::uint32_t a, std::uint32_t b) {
        pace_.spend(1);
        return std::pair(contacts_.leader(a), a) < std::pair(contacts_.leader(b), b);
    });
}

/// For a contour that meets no other and is inside none that does.
void Fill::keep_or_drop(std::uint32_t contour, FillRule rule) {
    const NestItem& item = items_[contour];
    Own& own = own_[contour];
    const Own around = item.parent < 0 ? Own{} : own_[static_cast<std::size_t>(item.parent)];
    own.winding = around.winding + item.orientation * static_cast<std::int64_t>(own.times);
    if (fills(rule, own.winding) != fills(rule, around.winding)) {
        region_.push_back({own.index, 0, 0, -1, -1, !fills(rule, own.winding)});
    }
}

bool Fill::clip_cluster(std::span<const std::uint32_t> members, FillRule rule) {
    const std::uint32_t leader = members[0];
    const std::int32_t parent = items_[leader].parent;
    const Own around = parent < 0 ? Own{} : own_[static_cast<std::size_t>(parent)];
    const Windings all = windings_of(members);
    Clipping::Meetings meetings{contacts_.contacts(leader), contacts_.shared_stretches(leader), false};
    clipping_.clear();
    for (const std::uint32_t member : members) {
        const std::uint32_t times = copies_that_matter(member, rule, all, around.winding);
        if (times > 0) {
            clipping_.add(items_[member], times, contacts_.meets_itself(member));
        }
        meetings.crowded = meetings.crowded || times > 1 || contacts_.is_crowded(member);
    }
    const std::int64_t most = all.negative + all.positive + all.either + 1;  // larger values give the same signs
    const std::int64_t ambient = rule == FillRule::even_odd ? around.winding % 2 : std::clamp(around.winding, -most, most);
    const auto base = static_cast<std::int64_t>(region_.size());
    const auto cluster = static_cast<std::int64_t>(clusters_++);
    return clipping_.fill(rule, ambient, meetings, [&](std::span<const Point> contour, std::int64_t within) {
        const bool hole = within < 0 ? fills(rule, ambient) : !region_[static_cast<std::size_t>(base + within)].hole;
        region_.push_back({-1, static_cast<std::uint32_t>(points_.size()), static_cast<std::uint32_t>(contour.size()),
                           cluster, within < 0 ? -1 : base + within, hole});
        points_.insert(points_.end(), contour.begin(), contour.end());
        pace_.spend(contour.size());
    });
}

Fill::Windings Fill::windings_of(std::span<const std::uint32_t> members) const noexcept {
    Windings all;
    for (const std::uint32_t member : members) {
        if (contacts_.meets_itself(member)) {
            all.either += std::int64_t{items_[member].count} * own_[member].times;
        } else {
            (items_[member].orientation > 0 ? all.positive : all.negative) += own_[member].times;
        }
    }
    return all;
}

/// One copy more than opposite contours could cancel: further copies do not change the region.
std::uint32_t Fill::copies_that_matter(std::uint32_t contour, FillRule rule, const Windings& all,
                                       std::int64_t ambient) const noexcept {
    const std::uint32_t times = own_[contour].times;
    if (rule == FillRule::even_odd) {
        return times % 2;
    }
    std::int64_t against = all.either;
    if (contacts_.meets_itself(contour)) {
        against += all.positive + all.negative + std::abs(ambient);
    } else if (items_[contour].orientation > 0) {
        against += all.negative + std::max<std::int64_t>(0, -ambient);
    } else {
        against += all.positive + std::max<std::int64_t>(0, ambient);
    }
    return static_cast<std::uint32_t>(std::min<std::int64_t>(times, against + 1));
}

}  // namespace lamella
