// A plane's open polylines joined over gaps: into longer polylines, and into closed contours where the last end meets the
// first start again.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/result.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/nesting/path.hpp"
#include "slicing/repair/gaps.hpp"

namespace lamella {

/// A line that is to join two ends.
struct Joint {
    Point from;
    Point to;
};

/// Which joints would cross a contour of their layer. One per thread; scratch is kept.
///
///        .--------.  .--------.      `a` and `b` are the nearest ends, but a wall lies between them: they are not joined.
///        |        a||b        |
///        |         ||         |
///        '---------++---------'
class CrossedJoints {
public:
    explicit CrossedJoints(Worker& worker) noexcept : worker_(worker) {}

    /// Forgets what was added.
    void clear() noexcept { pairs_.clear(); }
    /// The points must stay until find() has returned.
    void add(std::span<const Point> contour, bool closed);

    /// For each joint, the shortest first: 1 if between its ends it meets an edge of what was added, or a joint before it
    /// that is marked 0; edges along its line do not count. The first `free` joints are marked 0, whatever they meet.
    /// O((m + c) log (m + c)) for m edges of which c pairs come near one another. Valid until the next call.
    std::span<const std::uint8_t> find(std::span<const Joint> joints, std::size_t free);

private:
    Worker& worker_;
    EdgePairs pairs_{worker_};
    Vector<Point> ends_{worker_.memory()};  // of the joints, two by two
    Vector<std::uint8_t> crossed_{worker_.memory()};
    Vector<std::pair<std::uint32_t, std::uint32_t>> between_joints_{worker_.memory()};  // the later, the earlier
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
    /// so that searches are slow; where gaps may stay open, also what CrossedJoints::find() takes for all edges. Throws
    /// std::bad_alloc.
    bool join(std::span<const Path> polylines, std::span<const Path> around, const GapRules& rules, std::uint64_t layer,
              Vector<Stitch>& stitches);

    /// Each with the flag stitched, but for a polyline that nothing was joined to, and with orientation_mixed where some
    /// run against the others. Valid until the next call.
    std::span<const Path> joined() const noexcept { return joined_; }

private:
    void sort(std::span<const Path> polylines);
    std::span<const Gap> choose_gaps(std::span<const Path> around, const GapRules& rules);
    void join_open_from(bool last);
    void join_rings();
    void join_from(PolylineEnd first);
    void append(PolylineEnd entered);
    Point at(PolylineEnd end) const noexcept { return ends_[end.polyline()].at(end.last()); }
    bool leads_on_from(PolylineEnd last) const;

    Worker& worker_;
    GapCloser gap_closer_{worker_};
    CrossedJoints crossed_joints_{worker_};
    Vector<Joint> joints_{worker_.memory()};
    Vector<Path> sorted_{worker_.memory()};        // as given, in canonical order
    Vector<PolylineEnds> ends_{worker_.memory()};  // of sorted_
    Vector<std::uint8_t> used_{worker_.memory()};  // of sorted_: whether it is part of a joined one
    Vector<Point> points_{worker_.memory()};       // of joined_
    Vector<PointOrigin> origins_{worker_.memory()};
    Vector<Path> joined_{worker_.memory()};
};

}  // namespace lamella
