// A contour of a layer from the walk, or wherever else it comes from, until it is appended to the band's output.
#pragma once

#include <cstdint>
#include <span>

#include "base/function_ref.hpp"
#include "lamella/layers.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella {

/// It is no Contour, which has a place in a result, and neither a start nor a key. A NestItem is the part of it that the
/// search for parents reads again and again.
struct Path {
    NestItem item;               ///< points, area and box; then what nesting decides
    EndKey start_key{};          ///< the edge that the start lies on; zero where the contour was joined or made
    std::uint32_t segments = 0;  ///< triangles that it crosses; of a contour that was made its edges
    bool made = false;           ///< by a fill rule or an offset, of one contour or several
    bool hole = false;           ///< of a region: clockwise in the result
    std::uint32_t source = 0;    ///< of an offset curve: index of the path that was moved
    std::int64_t touched = -1;   ///< of a region: see Arrangement::trace()
};

/// The edge that the i-th point of a contour lies on.
using KeyAt = FunctionRef<EndKey(std::uint32_t)>;

/// A closed contour for nesting from its points alone, at least one. `origins`: of each point, or null. O(points).
NestItem closed_item(std::span<const Point> points, const PointOrigin* origins = nullptr, std::uint32_t part = 0) noexcept;

/// A closed contour of `count` points. Its start is the smallest (x, y, edge key); where the contour passes through one edge
/// twice, the smaller of the two rotations, by points and then by origins. If consecutive points are equal, the ring is
/// rewritten without repeats. `origins`: of each point, or null.
Path closed_path(Point* ring, std::uint32_t count, const RingFacts& facts, KeyAt key_at, PointOrigin* origins);

/// A closed contour whose points lie on no mesh edge.
Path closed_path(std::span<Point> ring, PointOrigin* origins);

/// An open contour. One of equal consecutive points is kept.
Path open_path(std::span<Point> points, PointOrigin* origins);

/// By the start point, then by its edge, then by content, origins last: contours equal in all of that are interchangeable.
bool comes_before(const Path& path_a, const Path& path_b);
/// Points, and their origins unless null, of a contour walked the other way. A closed one keeps the origin of the edge that
/// closes it.
void turn_round(std::span<Point> points, PointOrigin* origins, bool closed);

/// A contour of a caller's own, of which a layer is to be built: its points and origins are copied.
inline Path given_path(std::span<const Point> points, const PointOrigin* origins = nullptr, bool closed = true) noexcept {
    const auto count = static_cast<std::uint32_t>(points.size());
    return {.item = {.points = points.data(), .origins = origins, .count = count, .closed = closed}, .segments = count};
}

}  // namespace lamella
