#include "5_sweep/active_edges.hpp"

#include <algorithm>

namespace lamella {

void ActiveEdges::reserve(std::size_t slots) {
    if (slots <= end_.size()) {
        return;
    }
    const std::size_t padded = (slots + padded_count - 1) / padded_count * padded_count;
    for (auto* quantity : {&x_, &y_, &z_, &slope_x_, &slope_y_}) {
        quantity->resize(padded);
    }
    end_.resize(padded);
    next_.resize(padded);
}

void ActiveEdges::copy(Slot to, Slot from) {
    if (to >= end_.size()) {
        reserve(to + to / 2 + 1024);
    }
    for (auto* quantity : {&x_, &y_, &z_, &slope_x_, &slope_y_}) {
        (*quantity)[to] = (*quantity)[from];
    }
    end_[to] = end_[from];
    enlist(to);
}

void ActiveEdges::compact(std::span<const Slot> new_to_old, PlaneIndex plane) {
    std::pmr::vector<double> moved(end_.size(), x_.get_allocator());
    for (auto* quantity : {&x_, &y_, &z_, &slope_x_, &slope_y_}) {
        for (std::size_t slot = 0; slot < new_to_old.size(); ++slot) {
            moved[slot] = (*quantity)[new_to_old[slot]];
        }
        quantity->swap(moved);
    }
    std::pmr::vector<PlaneIndex> ends(end_.size(), end_.get_allocator());
    for (std::size_t slot = 0; slot < new_to_old.size(); ++slot) {
        ends[slot] = end_[new_to_old[slot]];
    }
    end_.swap(ends);
    std::fill(head_.begin() + (plane - first_), head_.end(), no_link);
    for (Slot slot = 0; slot < new_to_old.size(); ++slot) {
        enlist(slot);
    }
}

}  // namespace lamella
