// Stage 7: orientation and nesting of one layer (step 4 of the paper's Fig. 1).
//
// The parent of a closed contour is the smallest closed contour (by |area|, ties by start, box and points) whose non-zero
// winding interior strictly contains its start point. All tests are exact.
//
// Parent chains cannot cycle, even where contours cross: a contour's start is the smallest (x, y) of its convex hull, so
// whatever lies strictly inside it is larger, and starts strictly descend from child to parent.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "lamella/grid.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// One contour of a layer: what nesting reads and what it decides.
struct NestItem {
    const Point* points = nullptr;  ///< consecutive ones distinct; closed: the first is not repeated; any may come first
    std::uint32_t count = 0;
    std::uint32_t start = 0;  ///< closed: index of its smallest (x, y)
    Wide twice_area;          ///< closed: as walked, square grid units
    Point box_min, box_max;   ///< closed: of its points
    bool closed = false;

    bool reverse = false;      ///< out: the points must be stored backwards (outer counter-clockwise, hole clockwise)
    std::int8_t sense = 0;     ///< out: sign of the area; 0 for flat and open
    Role role = Role::open;    ///< out
    std::uint16_t flags = 0;   ///< out: sense_overruled is added to what is there
    std::int32_t parent = -1;  ///< out: index of an item, -1 for none
};

}  // namespace lamella

namespace lamella::nesting {

/// A closed contour with area, in the order of starts: what lies around it comes before it.
struct Ring {
    Point start;
    Point box_min, box_max;
    std::uint32_t item = 0;
    std::int32_t parent = -1;  // index of a ring
    std::int32_t winding = 0;  // just inside, as the senses add up from the outermost
    std::uint32_t depth = 0;   // number of rings around
    bool overruled = false;    // a winding below zero, here or around
};

}  // namespace lamella::nesting

namespace lamella {

/// Nests layer after layer; scratch is kept, so that a steady state allocates nothing. One per thread.
class Nester {
public:
    /// `memory` null: operator new.
    explicit Nester(std::pmr::memory_resource* memory);

    /// Fills in the outputs of `items`, at most 2^31 - 1. They do not depend on the order of the items, except that of
    /// contours equal in every point the first is taken as parent. Throws std::bad_alloc.
    void nest(std::span<NestItem> items);

private:
    void collect(std::span<NestItem> items);
    void find_parents(std::span<const NestItem> items);
    void assign_roles(std::span<NestItem> items);

    using InsideTest = bool (*)(const Point* points, std::uint32_t count, Point query) noexcept;
    InsideTest inside_;
    std::pmr::vector<nesting::Ring> rings_;
};

}  // namespace lamella
