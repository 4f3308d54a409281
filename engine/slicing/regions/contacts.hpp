// Which contours must be clipped together because they meet, where a fill rule is asked for.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/stop_pace.hpp"
#include "base/vector.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/edges/edge_pairs.hpp"

namespace lamella {

/// Grid units by which clipping moves a point at most.
inline constexpr std::int32_t clipping_reach = 2;

/// True if `p` lies within `reach` of the edge from `a` to `b`; may be true somewhat farther away if `reach` > 0.
bool is_near(Point p, Point a, Point b, std::int32_t reach) noexcept;

/// Two contours meet where their edges come within two units of each other: clipping rounds points to units, and a clipped
/// contour must not reach another. A contour meets itself where two of its edges that are not neighbours have a common
/// point. Contours that meet, directly or by way of others, are a cluster.
class Contacts {
public:
    explicit Contacts(const Memory* memory) : contours_(memory), clusters_(memory), shared_(memory) {}

    /// From here on find() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept {
        near_.follow(host);
        pace_.follow(host);
    }

    /// Finds the clusters of closed contours. False if there are more contacts than could be clipped in seconds. O(q log q)
    /// for q points whose edges lie apart, plus a step for each pair of edges with close boxes, up to a fixed number. Throws
    /// std::bad_alloc.
    bool find(std::span<const NestItem> contours);

    /// The first contour of the cluster.
    std::uint32_t leader(std::uint32_t contour) noexcept { return clusters_.root(contour); }
    /// Merges the clusters of two contours.
    void join(std::uint32_t a, std::uint32_t b) noexcept;

    bool meets_itself(std::uint32_t contour) const noexcept { return contours_[contour].itself; }
    /// Whether a stretch of one of its edges is shared with two other edges.
    bool is_crowded(std::uint32_t contour) const noexcept { return contours_[contour].crowded; }
    /// In the leader's cluster: pairs of edges that meet, and how many of them share a stretch.
    std::uint64_t contacts(std::uint32_t leader) const noexcept { return contours_[leader].contacts; }
    std::uint64_t shared_stretches(std::uint32_t leader) const noexcept { return contours_[leader].shared; }

private:
    struct Own {
        bool itself = false;
        bool crowded = false;
        std::uint64_t contacts = 0;  // of a leader: in its cluster
        std::uint64_t shared = 0;    // of a leader: in its cluster
    };
    /// A stretch that an edge shares with another.
    struct Shared {
        std::uint32_t contour;
        std::uint32_t edge;
        Point low;
        Point high;
        friend constexpr auto operator<=>(const Shared&, const Shared&) = default;
    };

    void meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j);
    void note_shared(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j);
    void find_crowds();

    EdgePairs near_;
    Vector<Own> contours_;
    DisjointSets clusters_;  // the leader is the root
    Vector<Shared> shared_;
    StopPace pace_;
};

}  // namespace lamella
