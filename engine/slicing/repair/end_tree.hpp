// A k-d tree over the ends of polylines, from which they are taken one by one.
#pragma once

#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// Where a polyline starts and ends, in grid units.
struct PolylineEnds {
    Point first;
    Point last;

    Point at(bool at_last) const noexcept { return at_last ? last : first; }
};

inline double squared_distance(Point a, Point b) noexcept {
    const double dx = static_cast<double>(a.x) - b.x;
    const double dy = static_cast<double>(a.y) - b.y;
    return dx * dx + dy * dy;
}

/// Ends at the same point share one site, so that they cost a search no more than one end does. A site is named by its place
/// in the tree. Boxes cover the ends that are left and shrink as ends are taken.
class EndTree {
public:
    explicit EndTree(const Memory* memory) : polylines_(memory), sites_(memory), boxes_(memory) {}

    /// From here on assign() and nearest() throw Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept { pace_.follow(host); }

    /// Fills the tree with one end of each polyline, the first or the last point. O(n log n). Throws std::bad_alloc.
    void assign(std::span<const PolylineEnds> polylines, Point PolylineEnds::*end);

    std::uint32_t site_count() const noexcept { return static_cast<std::uint32_t>(sites_.size()); }
    Point at(std::uint32_t site) const noexcept { return sites_[site].at; }
    bool holds(std::uint32_t site) const noexcept { return sites_[site].next != sites_[site].end; }
    std::uint32_t count_at(std::uint32_t site) const noexcept { return sites_[site].end - sites_[site].next; }

    static constexpr std::uint32_t none = ~0U;
    /// The nearest site that has an end left, at most the square root of `most_squared` away, or none. At equal distances
    /// the smallest point. The site `but` is passed over.
    std::uint32_t nearest(Point to, double most_squared, std::uint32_t but = none);

    /// Takes an end off the site and returns its polyline, the first by number. O(log n).
    std::uint32_t take(std::uint32_t site) noexcept;
    /// Takes all ends off the site.
    void take_all(std::uint32_t site) noexcept;

private:
    struct Site {
        Point at;
        std::uint32_t next, end;  // the ends left: a range of polylines_
    };
    struct Box {
        Point min, max;  // min > max: empty
    };
    struct Nearest {
        double squared;
        Point at;
        std::uint32_t site;
        std::uint32_t but;  // is no answer
    };

    std::uint32_t first_site(std::uint32_t leaf) const noexcept;
    void order(std::uint32_t first_leaf, std::uint32_t leaf_count);
    Box box_of(std::uint32_t first, std::uint32_t end) const noexcept;
    void measure(std::uint32_t node) noexcept;
    void shrink(std::uint32_t site) noexcept;
    static double squared_distance_to(const Box& box, Point point) noexcept;
    void search(std::uint32_t node, Point to, Nearest& best);

    Vector<std::uint32_t> polylines_;  // by where they end, then by number
    Vector<Site> sites_;               // leaf by leaf
    Vector<Box> boxes_;                // 1: the root's; 2 i and 2 i + 1: those below i; the last half: the leaves'
    std::uint32_t leaf_count_ = 0;     // a power of two
    StopPace pace_;
};

}  // namespace lamella
