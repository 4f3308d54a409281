// Stage 6, where asked for: the ends of a plane's open polylines joined over gaps, nearest first. Never by itself: a mesh
// that lacks faces says so.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella {

/// From where one polyline ends to where the next one starts, in grid units.
struct Gap {
    std::uint32_t from;  ///< index of the polyline that ends there
    std::uint32_t to;    ///< index of the one that starts there; may be the same
};

/// One per thread; scratch is kept.
class GapCloser {
public:
    explicit GapCloser(std::pmr::memory_resource* memory)
        : by_x_(memory), candidates_(memory), next_(memory), taken_(memory), gaps_(memory) {}

    struct Ends {
        Point first;
        Point last;
    };

    /// Which of `polylines` follow each other over gaps of at most `reach` grid units: each pair of an end and a start, from
    /// the nearest on, while neither has been taken; at equal distances by coordinates. O(o log o) for o polylines, and a
    /// step for each end and start that lie within `reach` of each other in x.
    std::span<const Gap> close(std::span<const Ends> polylines, double reach);

    /// After close(): the polyline that follows `polyline`, or -1.
    std::int64_t next(std::uint32_t polyline) const noexcept { return next_[polyline]; }
    /// After close(): whether it follows another one, or itself.
    bool follows(std::uint32_t polyline) const noexcept { return taken_[polyline] != 0; }

private:
    struct Candidate {
        double squared;
        Gap gap;
    };

    void find_candidates(std::span<const Ends> polylines, double reach);

    std::pmr::vector<std::uint32_t> by_x_;  // polylines by where they start
    std::pmr::vector<Candidate> candidates_;
    std::pmr::vector<std::int64_t> next_;
    std::pmr::vector<std::uint8_t> taken_;
    std::pmr::vector<Gap> gaps_;
};

}  // namespace lamella
