// Which joints would cross a contour of their layer.
//
//        .--------.  .--------.      `a` and `b` are the nearest ends, but a wall lies between them: they are not joined.
//        |        a||b        |
//        |         ||         |
//        '---------++---------'
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "base/vector.hpp"
#include "slicing/edges/edge_pairs.hpp"

namespace lamella {

/// A line that is to join two ends.
struct Joint {
    Point from;
    Point to;
};

/// One per thread; scratch is kept.
class CrossedJoints {
public:
    explicit CrossedJoints(const Memory* memory)
        : pairs_(memory), ends_(memory), crossed_(memory), between_joints_(memory) {}

    /// From here on find() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept { pairs_.follow(host); }

    /// Forgets what was added.
    void clear() noexcept { pairs_.clear(); }
    /// The points must stay until find() has returned.
    void add(std::span<const Point> contour, bool closed);

    /// For each joint, the shortest first: 1 if between its ends it meets an edge of what was added, or a joint before it
    /// that is marked 0; edges along its line do not count. The first `free` joints are marked 0, whatever they meet.
    /// O((m + c) log (m + c)) for m edges of which c pairs come near one another. Valid until the next call.
    std::span<const std::uint8_t> find(std::span<const Joint> joints, std::size_t free);

private:
    EdgePairs pairs_;
    Vector<Point> ends_;  // of the joints, two by two
    Vector<std::uint8_t> crossed_;
    Vector<std::pair<std::uint32_t, std::uint32_t>> between_joints_;  // the later, the earlier
};

}  // namespace lamella
