// Which ends of a plane's open polylines are joined over gaps: nearest first. Only on request: by default a mesh that lacks
// faces gives open polylines.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/result.hpp"
#include "slicing/repair/end_tree.hpp"

namespace lamella {

/// The first or the last point of a polyline.
class PolylineEnd {
public:
    PolylineEnd(std::uint32_t polyline, bool last) noexcept : number_(2 * polyline + (last ? 1 : 0)) {}

    std::uint32_t polyline() const noexcept { return number_ / 2; }
    bool last() const noexcept { return number_ % 2 != 0; }
    /// Among the first and last points of all polylines in turn.
    std::uint32_t number() const noexcept { return number_; }
    PolylineEnd other() const noexcept { return {polyline(), !last()}; }
    friend bool operator==(PolylineEnd a, PolylineEnd b) noexcept { return a.number_ == b.number_; }

private:
    std::uint32_t number_;
};

/// Two ends that are joined: a polyline's last point and the first one of the same or another polyline, or, where the sense
/// may change, two of a kind, the smaller point first.
struct Gap {
    PolylineEnd from;
    PolylineEnd to;

    bool turns() const noexcept { return from.last() == to.last(); }
};

struct GapRules {
    double reach = 0;           ///< grid units
    double crossing_reach = 0;  ///< grid units: joints longer than that cross no contour and no shorter joint
    GapSense sense = GapSense::kept;
};

/// One per thread; scratch is kept.
class GapCloser {
public:
    explicit GapCloser(const Memory* memory)
        : ends_(memory), starts_(memory), chain_(memory), joined_to_(memory), gaps_(memory) {}

    /// From here on close() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept {
        pace_.follow(host);
        ends_.follow(host);
        starts_.follow(host);
    }

    /// Which of `polylines`, fewer than 2^31, follow each other over gaps of at most `rules.reach`. Pairs of ends are joined
    /// by distance, the nearest first, if neither is joined yet; at equal distances those that turn no polyline come first,
    /// then by coordinates. At most about three searches in a k-d tree, or two of them, for each end: O(o log o) for o
    /// polylines unless they lie so that searches are slow. O(o) memory.
    std::span<const Gap> close(std::span<const PolylineEnds> polylines, const GapRules& rules);

    /// After close(): leaves those gaps open for which `crossed` is not 0, and returns the others.
    std::span<const Gap> leave_open(std::span<const std::uint8_t> crossed);

    /// After close(): the end that `end` is joined to, or `end` itself.
    PolylineEnd joined_to(PolylineEnd end) const noexcept { return joined_to_[end.number()]; }
    bool is_joined(PolylineEnd end) const noexcept { return !(joined_to(end) == end); }

private:
    struct Site {
        std::uint32_t number;
        bool last;  // in ends_, not starts_

        friend bool operator==(Site a, Site b) noexcept { return a.number == b.number && a.last == b.last; }
    };
    static constexpr Site no_site{EndTree::none, false};

    EndTree& tree_of(bool last) noexcept { return last ? ends_ : starts_; }
    Point at(Site site) noexcept { return tree_of(site.last).at(site.number); }
    void follow_chains(bool last);
    void follow_chain(Site first);
    Site nearest(Site site);
    void join(Site a, Site b);
    void sort_gaps(std::span<const PolylineEnds> polylines);

    double reach_squared_ = 0;
    GapSense sense_ = GapSense::kept;
    EndTree ends_, starts_;          // those not joined yet
    Vector<Site> chain_;             // each the nearest to its predecessor
    Vector<PolylineEnd> joined_to_;  // by number
    Vector<Gap> gaps_;
    StopPace pace_;
};

}  // namespace lamella
