// Stage 7, where a fill rule was asked for: what is inside by it, where contours overlap, nest the same way or run
// backwards.
//
// Contours that meet nothing stay as they are or go, as the winding numbers on their two sides say, which nesting tells:
//
//      0  +----------+     even-odd      non-zero, positive
//         | 1 +----+ |     both stay     the inner one goes: it is filled on both sides
//         |   | 2  | |
//         |   +----+ |
//         +----------+
//
// Clusters of contours that meet are clipped, together with what lies in them, each in the winding number around it.
//
// O(q log q) for q points of contours that meet nothing. Clusters cost what clipping costs; those that would take more than
// seconds are refused.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/clipping.hpp"
#include "slicing/regions/contacts.hpp"

namespace lamella {

/// A contour of a region.
struct RegionContour {
    std::int64_t kept = -1;     ///< the contour that it is, unchanged; -1: clipping made it
    std::uint32_t first = 0;    ///< made: its points, solid on the left
    std::uint32_t count = 0;    ///< made: so many
    std::int64_t cluster = -1;  ///< made: of what was clipped together
    std::int64_t around = -1;  ///< made: the one of its cluster that it lies directly in, an index into the region; -1: none
    bool hole = false;
};

/// Layer after layer; scratch is kept. One per thread.
class Fill {
public:
    explicit Fill(const Memory* memory);

    /// Of closed contours by (start, content), equal ones behind one another. False: they are too entangled to be clipped,
    /// and there is no region. Throws std::bad_alloc.
    bool run(std::span<const NestItem> contours, FillRule rule, Nester& nester);

    std::span<const RegionContour> region() const noexcept { return region_; }
    std::size_t clusters() const noexcept { return clusters_; }
    std::span<Point> points_of(const RegionContour& made) noexcept {
        return std::span(points_).subspan(made.first, made.count);
    }

private:
    /// What is known of a contour; parents come before what lies in them.
    struct Own {
        std::uint32_t index = 0;   // of those given: the first of equal ones
        std::uint32_t times = 0;   // how many of them
        std::int64_t winding = 0;  // just inside
        bool clipped = false;
    };
    /// The most that the winding numbers of contours can add up to.
    struct Windings {
        std::int64_t positive = 0;
        std::int64_t negative = 0;
        std::int64_t either = 0;  // of contours that meet themselves
    };

    void take_equal_ones_together(std::span<const NestItem> contours);
    void find_clusters(Nester& nester);
    void take_or_leave(std::uint32_t contour, FillRule rule);
    bool clip_cluster(std::span<const std::uint32_t> members, FillRule rule);
    Windings windings_of(std::span<const std::uint32_t> members) const noexcept;
    std::uint32_t copies_that_matter(std::uint32_t contour, FillRule rule, const Windings& all,
                                     std::int64_t ambient) const noexcept;

    Contacts contacts_;
    Clipping clipping_;
    Vector<NestItem> items_;  // one of equal ones
    Vector<Own> own_;
    Vector<std::uint32_t> members_;  // contours that are clipped, by leader, then in order
    Vector<RegionContour> region_;
    std::size_t clusters_ = 0;
    Vector<Point> points_;
};

}  // namespace lamella
