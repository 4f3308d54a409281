// The active set of a band: the mesh edges that pierce the current plane, as lines, by slot.
#pragma once

#include <span>
#include <vector>

#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/contours/link_graph.hpp"

namespace lamella {

class ActiveEdges {
public:
    explicit ActiveEdges(const Memory* memory)
        : x_(memory), y_(memory), z_(memory), slope_x_(memory), slope_y_(memory), moving_(memory) {}

    /// Makes room for at least `slots` slots.
    void reserve(std::size_t slots, StopPace& pace) {
        if (slots > capacity()) {
            const std::size_t padded = (slots + padded_count - 1) / padded_count * padded_count;
            for_each_array([&](auto& array) { grow_exactly(array, padded, pace); });
        }
    }
    std::size_t capacity() const noexcept { return x_.size(); }

    void put(Slot slot, const MeshEdge& edge) {
        const GridVertex lower = edge.lower();
        const GridVertex upper = edge.upper();
        const double rise = static_cast<double>(upper.z) - lower.z;
        x_[slot] = lower.x;
        y_[slot] = lower.y;
        z_[slot] = lower.z;
        slope_x_[slot] = (static_cast<double>(upper.x) - lower.x) / rise;
        slope_y_[slot] = (static_cast<double>(upper.y) - lower.y) / rise;
    }

    /// Renumbers after LinkGraph::compact().
    void compact(std::span<const Slot> new_to_old) {
        for_each_array([&](auto& array) { gather_slots(array, new_to_old, moving_); });
    }

    /// From slot `first` on.
    EdgeArrays arrays(std::size_t first) const noexcept {
        return {x_.data() + first, y_.data() + first, z_.data() + first, slope_x_.data() + first, slope_y_.data() + first};
    }

private:
    /// Calls use(array) for each array.
    template <class Use>
    void for_each_array(Use&& use) {
        use(y_);
        use(z_);
        use(slope_x_);
        use(slope_y_);
        use(x_);  // the last: arrays that could not grow have the capacity that they had
    }

    Vector<std::int32_t> x_, y_, z_;
    Vector<double> slope_x_, slope_y_;
    Vector<std::uint64_t> moving_;  // scratch
};

}  // namespace lamella
