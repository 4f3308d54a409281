// A plane's open polylines joined over gaps: into longer polylines, and into closed contours where the last end meets the
// first start again.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

// Which ends of a plane's open polylines are joined over gaps: nearest first. Only on request: by default a mesh that lacks
// faces gives open polylines.

/// The length asked for, or if that is stitch_by_mesh what the mesh's own box makes of it. By operations that round alike
/// everywhere.
inline double gap_length_mm(double asked_mm, const Bounds& mesh) noexcept {
    if (asked_mm != stitch_by_mesh) {
        return asked_mm;
    }
    double squares = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double side = mesh.max_mm[axis] - mesh.min_mm[axis];
        squares += side * side;
    }
    return std::sqrt(squares) / 100;
}

/// The length up to which joints may cross contours. By the mesh, cracks are closed whatever crosses them, since surfaces
/// overlap a little there; what lies within a wider gap may be a wall.
inline double crossing_gap_mm(double asked_mm, double length_mm) noexcept {
    return asked_mm == stitch_by_mesh ? length_mm / 10 : length_mm;
}

/// Where a polyline starts and ends, in grid units.
struct PolylineEnds {
    Point first;
    Point last;

    Point at(bool at_last) const noexcept { return at_last ? last : first; }
};

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
};

struct GapRules {
    double reach = 0;           ///< grid units
    double crossing_reach = 0;  ///< grid units: joints longer than that cross no contour and no shorter joint
    StitchDirection sense = StitchDirection::oriented;
};

/// One per thread; scratch is kept.
class GapCloser {
public:
    explicit GapCloser(Worker& worker) noexcept : worker_(worker) {}

    /// Which of `polylines`, fewer than 2^31, follow each other over gaps of at most `rules.reach`. Pairs of ends are joined
    /// by distance, the nearest first, if neither is joined yet; at equal distances those that turn no polyline come first,
    /// then by coordinates. At most about three searches in a tree, or two of them, for each end: O(o log o) for o
    /// polylines unless they lie so that searches are slow. O(o) memory.
    std::span<const Gap> close(std::span<const PolylineEnds> polylines, const GapRules& rules);

    /// After close(): leaves those gaps open for which `crossed` is not 0, and returns the others.
    std::span<const Gap> leave_open(std::span<const std::uint8_t> crossed);

    /// After close(): the end that `end` is joined to, or `end` itself.
    PolylineEnd joined_to(PolylineEnd end) const noexcept { return joined_to_[end.number()]; }
    bool is_joined(PolylineEnd end) const noexcept { return !(joined_to(end) == end); }

private:
    /// The first points, or the last points, that lie at one place: they cost a search no more than one end does.
    struct Site {
        Point at;
        std::uint32_t next, end;  // the ends left: a range of ends_
    };
    using SiteNumber = std::uint32_t;  // of sites_
    static constexpr SiteNumber none = PointTree::none;

    void list_sites(std::span<const PolylineEnds> polylines);
    bool is_last(SiteNumber site) const noexcept { return site >= first_sites_; }
    SiteNumber base_of(bool last) const noexcept { return last ? first_sites_ : 0; }
    std::uint32_t count_at(SiteNumber site) const noexcept { return sites_[site].end - sites_[site].next; }
    PolylineEnd take(SiteNumber site) noexcept;
    void take_off(SiteNumber site) noexcept { trees_[is_last(site) ? 1 : 0].take_off(site - base_of(is_last(site))); }
    void follow_chains(SiteNumber begin, SiteNumber end);
    void follow_chain(SiteNumber first);
    SiteNumber nearest_of(bool last, Point to, double most_squared, SiteNumber but) const;
    SiteNumber nearest(SiteNumber site) const;
    void join(SiteNumber a, SiteNumber b);
    void sort_gaps(std::span<const PolylineEnds> polylines);

    Worker& worker_;
    double reach_squared_ = 0;
    StitchDirection sense_ = StitchDirection::oriented;
    Vector<PolylineEnd> ends_{worker_.memory()};                  // first points, then last ones; by place, then by number
    Vector<Site> sites_{worker_.memory()};                        // of ends_, in that order
    SiteNumber first_sites_ = 0;                                  // as many of sites_ are of first points
    PointTree trees_[2]{PointTree(worker_), PointTree(worker_)};  // of first and of last sites where an end is left
    Vector<SiteNumber> chain_{worker_.memory()};                  // each the nearest to its predecessor
    Vector<PolylineEnd> joined_to_{worker_.memory()};             // by number
    Vector<Gap> gaps_{worker_.memory()};
};

/// One per thread; scratch is kept.
class PolylineRepair {
public:
    explicit PolylineRepair(Worker& worker) noexcept : worker_(worker) {}

    /// Joins open polylines over gaps by these rules, nearest first, and appends the gaps that were closed to
    /// `stitches`, as of `layer`. Gaps longer than the crossing reach stay open where the joint would cross a polyline, a
    /// closed contour of `around` or a shorter joint. What comes of polylines that run against each other runs as most of
    /// their segments do. Returns whether there were any: joined() then takes the place of all polylines. What comes out
    /// does not depend on the order of polylines and contours. O(o log o + q) for o polylines with q points, unless gaps lie
    /// so that searches are slow; where gaps may stay open, also O((m + c) log (m + c)) for m edges of which c pairs come
    /// near one another. Throws std::bad_alloc.
    bool join(std::span<const Path> polylines, std::span<const Path> around, const GapRules& rules, std::uint64_t layer,
              Vector<Stitch>& stitches);

    /// Each with the flag stitched, but for a polyline that nothing was joined to, and with orientation_mixed where some
    /// run against the others. Valid until the next call.
    std::span<const Path> joined() const noexcept { return joined_; }

private:
    void sort(std::span<const Path> polylines);
    std::span<const Gap> choose_gaps(std::span<const Path> around, const GapRules& rules);
    void mark_crossed(std::span<const Path> around, std::size_t free);
    void join_from(PolylineEnd first);
    void append(PolylineEnd entered);
    Point at(PolylineEnd end) const noexcept { return ends_[end.polyline()].at(end.last()); }
    bool leads_on_from(PolylineEnd last) const;

    Worker& worker_;
    GapCloser gap_closer_{worker_};
    EdgePairs pairs_{worker_};
    Vector<Point> joints_{worker_.memory()};                                            // ends of the gaps, two by two
    Vector<std::uint8_t> crossed_{worker_.memory()};                                    // of each gap: it stays open
    Vector<std::pair<std::uint32_t, std::uint32_t>> between_joints_{worker_.memory()};  // the later, the earlier
    Vector<Path> sorted_{worker_.memory()};                                             // as given, in canonical order
    Vector<PolylineEnds> ends_{worker_.memory()};                                       // of sorted_
    Vector<std::uint8_t> used_{worker_.memory()};  // of sorted_: whether it is part of a joined one
    Vector<Point> points_{worker_.memory()};       // of joined_
    Vector<PointOrigin> origins_{worker_.memory()};
    Vector<Path> joined_{worker_.memory()};
};

}  // namespace lamella
