#include "5_sweep/active_edges.hpp"

#include <algorithm>
#include <type_traits>

namespace lamella {

void ActiveEdges::reserve(std::size_t slots) {
    if (slots <= endings_.size()) {
        return;
    }
    const std::size_t padded = (slots + padded_count - 1) / padded_count * padded_count;
    for_each_array([padded](auto& array) { array.resize(padded); });
}

void ActiveEdges::copy(Slot to, Slot from) {
    if (to >= endings_.size()) {
        reserve(to + to / 2 + 1024);
    }
    for_each_array([to, from](auto& array) { array[to] = array[from]; });
    enlist(to);
}

void ActiveEdges::compact(std::span<const Slot> new_to_old, PlaneIndex plane) {
    for_each_array([new_to_old](auto& array) {
        std::remove_reference_t<decltype(array)> moved(array.size(), array.get_allocator());
        std::transform(new_to_old.begin(), new_to_old.end(), moved.begin(), [&array](Slot old) { return array[old]; });
        array.swap(moved);
    });
    std::fill(head_.begin() + (plane - first_), head_.end(), no_link);
    for (Slot slot = 0; slot < new_to_old.size(); ++slot) {
        enlist(slot);
    }
}

}  // namespace lamella
