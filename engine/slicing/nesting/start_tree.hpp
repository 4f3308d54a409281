// A tree over the starts of a layer, for layers that are too wide for windows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/lanes.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella::nesting {

/// Starts in tiles of sixteen, in the proportions of the boxes that will be asked for: strips by y, cut by x, above them
/// nodes of sixteen. What is taken off is not looked at again, nor are nodes with nothing left.
class StartTree {
public:
    explicit StartTree(const Memory* memory)
        : nodes_(memory), levels_(memory), start_at_(memory), place_of_(memory), by_y_(memory), spare_(memory) {}

    /// `slimness`: the share of the layer's width that a box takes in the mean, over that of its height. Throws
    /// std::bad_alloc.
    void assign(std::span<const SortKey> by_start, double slimness);
    /// Appends the starts left that lie strictly within the box to `found`, in an unspecified but reproducible order.
    void find(Point box_min, Point box_max, Vector<std::uint32_t>& found) const;
    void take_off(std::uint32_t start) noexcept;

private:
    struct Node {
        std::int32_t min_x[lanes], max_x[lanes], min_y[lanes], max_y[lanes];
        std::uint32_t left;  // a bit for each child with a start that is left
    };
    void order_places(std::span<const SortKey> by_start, std::uint32_t strips);
    void add(std::uint32_t place, Point start) noexcept;
    void search(std::size_t level, std::uint32_t node, Point box_min, Point box_max, Vector<std::uint32_t>& found) const;

    Vector<Node> nodes_;
    Vector<std::uint32_t> levels_;    // first node of each, from the leaves up
    Vector<std::uint32_t> start_at_;  // each place
    Vector<std::uint32_t> place_of_;  // each start
    Vector<SortKey> by_y_, spare_;
};

}  // namespace lamella::nesting
