// The active set of a band: the mesh edges that pierce the current plane, by slot, with the plane at which each leaves.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "3_planes/plane_set.hpp"
#include "6_contours/link_graph.hpp"
#include "base/kernels.hpp"
#include "lamella/grid.hpp"

namespace lamella {

class ActiveEdges {
public:
    explicit ActiveEdges(std::pmr::memory_resource* memory)
        : x_(memory), y_(memory), z_(memory), slope_x_(memory), slope_y_(memory), endings_(memory), head_(memory) {}

    /// Empties the set, for planes [first, last).
    void clear(PlaneIndex first, PlaneIndex last) {
        first_ = first;
        last_ = last;
        head_.assign(last - first, no_link);
    }

    /// Takes memory for `slots` slots at once rather than by growing.
    void reserve(std::size_t slots);

    /// The edge in `slot` will leave at plane `end`; put() follows.
    void note_end(Slot slot, PlaneIndex end) {
        if (slot >= endings_.size()) {
            reserve(slot + slot / 2 + 1024);
        }
        endings_[slot].plane = end;
    }

    /// The edge in `slot`. Precondition: note_end().
    void put(Slot slot, const GridVertex& lower, const GridVertex& upper) {
        const double rise = static_cast<double>(upper.z) - lower.z;
        x_[slot] = lower.x;
        y_[slot] = lower.y;
        z_[slot] = lower.z;
        slope_x_[slot] = (static_cast<double>(upper.x) - lower.x) / rise;
        slope_y_[slot] = (static_cast<double>(upper.y) - lower.y) / rise;
        enlist(slot);
    }

    /// Puts the edge of slot `from` in slot `to` too.
    void copy(Slot to, Slot from);

    /// Calls leave(slot) for each edge that leaves at `plane`; returns their number.
    template <class Leave>
    std::size_t take_ended(PlaneIndex plane, Leave&& leave) {
        std::size_t count = 0;
        for (Slot slot = std::exchange(head_[plane - first_], no_link); slot != no_link;) {
            const Slot next = endings_[slot].next;
            leave(slot);
            slot = next;
            ++count;
        }
        return count;
    }

    /// Renumbers after LinkGraph::compact(). `plane` is the current one.
    void compact(std::span<const Slot> new_to_old, PlaneIndex plane);

    EdgeArrays arrays() const noexcept { return {x_.data(), y_.data(), z_.data(), slope_x_.data(), slope_y_.data()}; }
    std::size_t capacity() const noexcept { return endings_.size(); }

private:
    /// When an edge leaves, and the next of those that leave with it.
    struct Ending {
        PlaneIndex plane;
        Slot next;
    };

    /// Calls use(array) for each array that is indexed by slot.
    template <class Use>
    void for_each_array(Use&& use) {
        use(x_);
        use(y_);
        use(z_);
        use(slope_x_);
        use(slope_y_);
        use(endings_);
    }

    void enlist(Slot slot) {
        if (endings_[slot].plane < last_) {
            endings_[slot].next = std::exchange(head_[endings_[slot].plane - first_], slot);
        }
    }

    std::pmr::vector<std::int32_t> x_, y_, z_;
    std::pmr::vector<double> slope_x_, slope_y_;
    std::pmr::vector<Ending> endings_;
    std::pmr::vector<Slot> head_;  // by plane of the band
    PlaneIndex first_ = 0;
    PlaneIndex last_ = 0;
};

}  // namespace lamella
