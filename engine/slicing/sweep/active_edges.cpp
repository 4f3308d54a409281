#include "slicing/sweep/active_edges.hpp"

namespace lamella {

void ActiveEdges::reserve(std::size_t slots, StopPace& pace) {
    if (slots > capacity()) {
        const std::size_t padded = (slots + padded_count - 1) / padded_count * padded_count;
        for_each_array([&](auto& array) { resize_exactly(array, padded, pace); });
    }
}

void ActiveEdges::compact(std::span<const Slot> new_to_old) {
    for_each_array([&](auto& array) { gather_slots(array, new_to_old, moving_); });
}

}  // namespace lamella
