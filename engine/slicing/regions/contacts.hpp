// Stage 7, where a fill rule was asked for: which contours must be clipped together because they meet.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/vector.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/edge_pairs.hpp"

namespace lamella {

/// Grid units by which clipping moves a point at most.
inline constexpr std::int32_t clipping_reach = 2;

/// Whether `p` lies within `reach` of the edge from `a` to `b`; also somewhat beyond, where `reach` is not 0.
bool is_near(Point p, Point a, Point b, std::int32_t reach) noexcept;

/// Two contours meet where their edges come within two units of each other: clipping rounds points to units, and what it
/// makes of one must not reach the other. A contour meets itself where edges of it that do not follow each other have a
/// point in common. Contours that meet, and those that meet them, are a cluster.
class Contacts {
public:
    explicit Contacts(const Memory* memory) : contours_(memory), clusters_(memory), shared_(memory) {}

    /// Of closed contours. False if they meet more often than could be clipped in seconds. O(q log q) for q points whose
    /// edges lie apart, and as many steps as edges' boxes lie close, up to a fixed number. Throws std::bad_alloc.
    bool find(std::span<const NestItem> contours);

    /// The first contour of the cluster.
    std::uint32_t leader(std::uint32_t contour) noexcept { return clusters_.root(contour); }
    /// Makes one cluster of two.
    void join(std::uint32_t a, std::uint32_t b) noexcept;

    bool meets_itself(std::uint32_t contour) const noexcept { return contours_[contour].itself; }
    /// Some stretch of an edge is part of two other edges as well.
    bool is_crowded(std::uint32_t contour) const noexcept { return contours_[contour].crowded; }
    /// In the cluster that the contour leads: pairs of edges that meet, and of them those that share a stretch.
    std::uint64_t contacts(std::uint32_t leader) const noexcept { return contours_[leader].contacts; }
    std::uint64_t shared_stretches(std::uint32_t leader) const noexcept { return contours_[leader].shared; }

private:
    struct Own {
        bool itself = false;
        bool crowded = false;
        std::uint64_t contacts = 0;  // of those led
        std::uint64_t shared = 0;    // of those led
    };
    /// A stretch that an edge has in common with another.
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
};

}  // namespace lamella
