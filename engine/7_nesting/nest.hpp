// Stage 7: orientation and nesting of one layer (step 4 of the paper's Fig. 1).
//
// The parent of a closed contour is the smallest closed contour (by |area|, ties by start, box and points) whose non-zero
// winding interior strictly contains its start point. All tests are exact: box tests choose candidates, integer products
// decide.
//
// Parent chains cannot cycle, even where contours cross: a contour's start is the smallest (x, y) of its convex hull, so
// whatever lies strictly inside it is larger, and starts strictly descend from child to parent.
//
// So contours are taken in the order of starts, and what lies around one is searched backwards from it. Where contours do
// not cross, the first found is the smallest. Layers of few contours look at all the others nevertheless. Layers of more
// than 100 sweep over the starts with a tree of boxes and look further only while a budget of 4,096 nodes and 4 a contour
// lasts: where contours cross as well, a few may get a larger parent than the smallest, the same in any order of the items.
//
// O(q log q) for q contours and points, deep nests and arrays of contours that lie apart included. What costs more: k
// contours whose boxes, but not whose insides, lie around a start cost O(k) for it (L shapes, one in the crook of the
// other).
#pragma once

#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "7_nesting/boxes.hpp"
#include "7_nesting/inside.hpp"
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

/// A closed contour with area. Rings are in the order of starts: what lies around one comes before it.
struct Ring {
    Point start;
    Point box_min, box_max;
    std::size_t edge_index = 0;  // handle, once asked often
    std::uint32_t item = 0;
    std::uint32_t tests = 0;   // points tested against it
    std::int32_t parent = -1;  // index of a ring
    std::int32_t winding = 0;  // just inside, as the senses add up from the outermost
    std::uint32_t depth = 0;   // number of rings around
    bool overruled = false;    // a winding below zero, here or around
};

/// What rings are sorted by, with whose it is.
struct SortKey {
    std::uint64_t key = 0;
    std::uint32_t index = 0;
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
    void sort_by_start(std::span<const NestItem> items);
    void find_parents_among_few(std::span<const NestItem> items);
    void find_parents_among_many(std::span<const NestItem> items);
    void ask_all_around(std::span<const NestItem> items, std::size_t ring, std::size_t& patience);
    void order_places();
    void take_if_closer(std::span<const NestItem> items, std::size_t ring, std::size_t around);
    bool inside(const NestItem& contour, nesting::Ring& ring, Point query);
    void assign_roles(std::span<NestItem> items);

    std::pmr::memory_resource* memory_;
    nesting::AddEdges add_edges_;
    std::pmr::vector<nesting::Ring> rings_;
    std::pmr::vector<std::uint64_t> areas_;  // of the rings: |twice_area|, as far as it fits
    std::pmr::vector<nesting::SortKey> keys_, spare_keys_;
    std::pmr::vector<nesting::BoxQuad> quads_;
    std::pmr::vector<std::uint32_t> places_;  // of the rings in the tree
    std::pmr::vector<std::uint32_t> strip_ends_;
    nesting::BoxTree tree_;
    std::pmr::vector<std::int32_t> around_;
    nesting::EdgeIndex edge_index_;
};

}  // namespace lamella
