// Which ends of a plane's open polylines are joined over gaps: nearest first. Only on request: by default a mesh that lacks
// faces gives open polylines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/stop_pace.hpp"
#include "base/vector.hpp"
#include "slicing/repair/end_tree.hpp"

namespace lamella {

/// From where one polyline ends to where the next one starts, in grid units.
struct Gap {
    std::uint32_t from;  ///< index of the polyline that ends there
    std::uint32_t to;    ///< index of the one that starts there; may be the same
};

/// One per thread; scratch is kept.
class GapCloser {
public:
    explicit GapCloser(const Memory* memory)
        : ends_(memory), starts_(memory), chain_(memory), next_(memory), taken_(memory), gaps_(memory) {}

    /// From here on close() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept {
        pace_.follow(host);
        ends_.follow(host);
        starts_.follow(host);
    }

    /// Which of `polylines` follow each other over gaps of at most `reach` grid units. Pairs of an end and a start are
    /// joined by distance, the nearest first, if neither is joined yet; at equal distances by coordinates. At most about
    /// three searches in a k-d tree for each polyline: O(o log o) for o polylines unless they lie so that searches are slow.
    /// O(o) memory.
    std::span<const Gap> close(std::span<const PolylineEnds> polylines, double reach);

    /// After close(): the polyline that follows `polyline`, or -1.
    std::int64_t next(std::uint32_t polyline) const noexcept { return next_[polyline]; }
    /// After close(): whether it follows another one, or itself.
    bool follows(std::uint32_t polyline) const noexcept { return taken_[polyline] != 0; }

private:
    void follow_chain(std::uint32_t end, double reach_squared);
    void join(std::uint32_t end, std::uint32_t start);

    EndTree ends_, starts_;        // those not joined yet
    Vector<std::uint32_t> chain_;  // sites of ends_ and starts_ in turn, each the nearest to its predecessor
    Vector<std::int64_t> next_;
    Vector<std::uint8_t> taken_;
    Vector<Gap> gaps_;
    StopPace pace_;
};

}  // namespace lamella
