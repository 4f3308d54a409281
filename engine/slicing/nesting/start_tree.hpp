// A tree over the starts of a layer, for layers whose windows of the start line are too long.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/lanes.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella::nesting {

/// Starts in tiles of sixteen, shaped like the boxes that will be searched: strips by y, cut by x. Nodes of sixteen above
/// them. Starts that are taken off, and nodes without starts left, are not visited again.
class StartTree {
public:
    explicit StartTree(const Memory* memory)
        : nodes_(memory),
          levels_(memory),
          start_at_(memory),
          place_of_(memory),
          strip_of_(memory),
          next_place_(memory),
          by_y_(memory),
          spare_(memory) {}

    /// `slimness`: the mean width of the boxes as a share of the layer's width, divided by the same for heights. Throws
    /// std::bad_alloc.
    void assign(std::span<const SortKey> by_start, double slimness);
    /// From here on assign() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept { pace_.follow(host); }
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
    Vector<std::uint32_t> levels_;      // first node of each, from the leaves up
    Vector<std::uint32_t> start_at_;    // at each place
    Vector<std::uint32_t> place_of_;    // of each start
    Vector<std::uint32_t> strip_of_;    // of each start
    Vector<std::uint32_t> next_place_;  // of each strip, while places are given out
    Vector<SortKey> by_y_, spare_;
    StopPace pace_;
};

}  // namespace lamella::nesting
