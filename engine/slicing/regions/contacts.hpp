// Which contours of a layer meet, and where, if a fill rule is asked for.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

/// Two edges that are both moved by rounding, each by half a unit per axis, can touch where they come so near.
inline constexpr std::int32_t rounding_reach = 1;

/// True if `p` lies within `reach` of the edge from `a` to `b` on both axes; may be true somewhat farther away if
/// `reach` > 0.
bool is_near(Point p, Point a, Point b, std::int32_t reach) noexcept;

/// Where two edges cross at a point that is an end of neither, rounded: the grid point whose pixel, which is a unit wide and
/// contains its left and lower side, contains the crossing. `a` to `b` and `c` to `d` must cross there.
Point rounded_crossing(Point a, Point b, Point c, Point d) noexcept;

/// Two contours meet where their edges come within rounding_reach of each other. A contour meets itself where two of its
/// edges have a common point that is not the end of one and the start of the next.
class Contacts {
public:
    explicit Contacts(Worker& worker) noexcept : worker_(worker) {}

    /// Compares closed contours. O(q log q) for q points whose edges lie apart, plus a step for each pair of
    /// edges with close boxes. Throws std::bad_alloc.
    void find(std::span<const NestItem> contours);

    /// True if the contour meets another or itself.
    bool meets(std::uint32_t contour) const noexcept { return meets_[contour] != 0; }
    bool any_meets() const noexcept { return any_meets_; }
    /// For each edge of a contour from its start whether it comes within rounding_reach of an edge of another contour, or
    /// of another run of its own, or at a sharp corner of the next one. Contours that meet nothing: without sharp corners.
    std::span<const std::uint8_t> near_edges(std::uint32_t contour) const noexcept {
        return std::span(near_edges_).subspan(first_edges_[contour], first_edges_[contour + 1] - first_edges_[contour]);
    }
    /// Where edges cross, rounded; in no order, and as often as two cross there.
    std::span<const Point> crossings() const noexcept { return crossings_; }

private:
    void meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j);
    void mark(const EdgePath& path, std::size_t edge, bool meets) noexcept;
    void mark_sharp_corners(const NestItem& contour, std::uint32_t number);

    Worker& worker_;
    EdgePairs near_{worker_};
    Vector<std::uint8_t> meets_{worker_.memory()};       // of each contour
    Vector<std::size_t> first_edges_{worker_.memory()};  // of each contour
    Vector<std::uint8_t> near_edges_{worker_.memory()};
    Vector<Point> crossings_{worker_.memory()};
    bool any_meets_ = false;
};

}  // namespace lamella
