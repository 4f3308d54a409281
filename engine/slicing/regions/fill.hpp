// The region that a layer's closed contours bound by a fill rule, where they overlap, nest with equal orientation or are
// reversed.
//
// A contour that meets no other stays if exactly one of its two sides is filled. Nesting gives the winding numbers of both:
//
//      0  +----------+     even-odd      non-zero, positive
//         | 1 +----+ |     both stay     the inner one goes: it is filled on both sides
//         |   | 2  | |
//         |   +----+ |
//         +----------+
//
// A cluster of contours that meet is clipped together with all contours inside it, given the winding number around it.
//
// O(q log q) for q points of contours that meet no others, plus the cost of clipping. Clusters that would take more than
// seconds are refused.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/stop_pace.hpp"
#include "base/vector.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/clipping.hpp"
#include "slicing/regions/contacts.hpp"

namespace lamella {

/// A contour of a region.
struct RegionContour {
    std::int64_t kept = -1;     ///< index of the given contour that it is, unchanged; -1: clipping made it
    std::uint32_t first = 0;    ///< made: index of its first point; solid is on the left
    std::uint32_t count = 0;    ///< made: number of its points
    std::int64_t cluster = -1;  ///< made: number of its cluster
    std::int64_t around = -1;   ///< made: its parent within the cluster, an index into the region; -1: none
    bool hole = false;
};

/// Layer after layer; scratch is kept. One per thread.
class Fill {
public:
    explicit Fill(const Memory* memory);

    /// From here on run() throws Stopped where the host wants the call to end. A single call of the clipping library is not
    /// interrupted.
    void follow(const StopCheck& host) noexcept {
        pace_.follow(host);
        contacts_.follow(host);
        clipping_.follow(host);
    }

    /// Computes the region. `contours` are closed and sorted by (start, content), so that equal ones are neighbours. False,
    /// without a region, if clipping them would take too long or gives no two results that agree. Throws std::bad_alloc.
    bool run(std::span<const NestItem> contours, FillRule rule, Nester& nester);

    std::span<const RegionContour> region() const noexcept { return region_; }
    std::size_t clusters() const noexcept { return clusters_; }
    std::span<Point> points_of(const RegionContour& made) noexcept {
        return std::span(points_).subspan(made.first, made.count);
    }

private:
    /// A contour that is equal to no other; parents come before their children.
    struct Own {
        std::uint32_t index = 0;   // of the given contours: the first of equal ones
        std::uint32_t times = 0;   // number of equal ones
        std::int64_t winding = 0;  // just inside
        bool clipped = false;
    };
    /// Bounds of the sum of contours' winding numbers, by orientation.
    struct Windings {
        std::int64_t positive = 0;
        std::int64_t negative = 0;
        std::int64_t either = 0;  // self-intersecting contours: counts for both
    };

    void merge_equal_ones(std::span<const NestItem> contours);
    void find_clusters(Nester& nester);
    void keep_or_drop(std::uint32_t contour, FillRule rule);
    bool clip_cluster(std::span<const std::uint32_t> members, FillRule rule);
    Windings windings_of(std::span<const std::uint32_t> members) const noexcept;
    std::uint32_t copies_that_matter(std::uint32_t contour, FillRule rule, const Windings& all,
                                     std::int64_t ambient) const noexcept;

    Contacts contacts_;
    Clipping clipping_;
    Vector<NestItem> items_;  // one of each group of equal contours
    Vector<Own> own_;
    Vector<std::uint32_t> members_;  // contours to be clipped, by leader, then in order
    Vector<RegionContour> region_;
    std::size_t clusters_ = 0;
    Vector<Point> points_;
    StopPace pace_;
};

}  // namespace lamella
