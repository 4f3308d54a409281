// A plane's open polylines joined over gaps: into longer polylines, and into closed contours where the last end meets the
// first start again.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/assemble.hpp"
#include "lamella/result.hpp"
#include "slicing/repair/crossed_joints.hpp"
#include "slicing/repair/gaps.hpp"

namespace lamella {

struct Polyline {
    std::span<const Point> points;         ///< not empty
    const PointOrigin* origins = nullptr;  ///< of each point, or null for all polylines
    EndKey start_key;                      ///< the edge that the first point lies on
    std::uint32_t segments = 0;
    std::uint16_t flags = 0;  ///< ContourFlag bits
};

/// What takes the place of polylines that follow each other.
struct JoinedPolyline {
    std::span<Point> points;         ///< of all of them; repeated points are left in
    PointOrigin* origins = nullptr;  ///< of each point, or null
    EndKey start_key;                ///< of the first of them; zero if that one was turned round
    std::uint32_t segments = 0;
    std::uint16_t flags = 0;  ///< with gap_closed, but for a polyline that nothing was joined to; with orientation_mixed
                              ///< where some run against the others
    bool closed = false;      ///< its end was joined to its own start
};

/// One per thread; scratch is kept.
class PolylineRepair {
public:
    explicit PolylineRepair(const Memory* memory)
        : gap_closer_(memory),
          crossed_joints_(memory),
          joints_(memory),
          sorted_(memory),
          ends_(memory),
          used_(memory),
          points_(memory),
          origins_(memory),
          joined_(memory) {}

    /// From here on join() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept {
        pace_.follow(host);
        gap_closer_.follow(host);
        crossed_joints_.follow(host);
    }

    /// Joins open polylines over gaps by these rules, nearest first, and appends the gaps that were closed to
    /// `closed_gaps`, as of `layer`. Gaps longer than the crossing reach stay open where the joint would cross a polyline, a
    /// closed contour of `around` or a shorter joint. What comes of polylines that run against each other runs as most of
    /// their segments do. Returns whether there were any: joined() then takes the place of all polylines. What comes out
    /// does not depend on the order of polylines and contours. O(o log o + q) for o polylines with q points, unless gaps lie
    /// so that searches are slow; where gaps may stay open, also what CrossedJoints::find() takes for all edges. Throws
    /// std::bad_alloc.
    bool join(std::span<const Polyline> polylines, std::span<const std::span<const Point>> around, const GapRules& rules,
              std::uint64_t layer, Vector<ClosedGap>& closed_gaps);

    /// Valid until the next call.
    std::span<const JoinedPolyline> joined() const noexcept { return joined_; }

private:
    void sort(std::span<const Polyline> polylines);
    std::span<const Gap> choose_gaps(std::span<const std::span<const Point>> around, const GapRules& rules);
    void join_open_from(bool last);
    void join_rings();
    void join_from(PolylineEnd first);
    void append(PolylineEnd entered);
    void append_origins(PolylineEnd entered);
    Point at(PolylineEnd end) const noexcept { return ends_[end.polyline()].at(end.last()); }
    bool leads_on_from(PolylineEnd last) const;
    void turn_round(JoinedPolyline& whole) const;

    GapCloser gap_closer_;
    CrossedJoints crossed_joints_;
    Vector<Joint> joints_;
    Vector<Polyline> sorted_;    // as given, in canonical order
    Vector<PolylineEnds> ends_;  // of sorted_
    Vector<std::uint8_t> used_;  // of sorted_: whether it is part of a joined one
    Vector<Point> points_;       // of joined_
    Vector<PointOrigin> origins_;
    Vector<JoinedPolyline> joined_;
    StopPace pace_;
};

}  // namespace lamella
