// The walk of a plane where some slot joins two ends of the same orientation: links are followed by whichever port they lead
// to, and most segments decide which way a contour runs.
#include <algorithm>

#include "slicing/contours/link_graph.hpp"

namespace lamella {

void LinkGraph::walk_any_orientation() {
    leave_by_.resize(order_next_.size());
    for (Slot slot = 0; slot < slots_.slot_end() && slots_.open_count() > 0; ++slot) {
        if (!slots_.is_free(slot) && slots_.has_any(slot, SlotTable::open_end) && !walked(slot)) {
            walk_polyline(slot, !slots_.is_linked(slot, target_port) ? source_port : target_port, false);
        }
    }
    for (Slot slot = 0; slot < slots_.slot_end(); ++slot) {
        if (!slots_.is_free(slot) && !walked(slot)) {
            walk_polyline(slot, source_port, true);
        }
    }
}

void LinkGraph::walk_polyline(Slot start, int leave_by, bool closed) {
    const std::uint32_t begin = filled_;
    follow_any_orientation(start, leave_by, closed);
    bool is_mixed = false;
    for (std::uint32_t i = begin; i < filled_; ++i) {
        is_mixed = is_mixed || slots_.has_any(order_next_[i + 1], SlotTable::mixed);
    }
    if (runs_backwards(begin, closed)) {
        std::reverse(order_next_.begin() + 1 + begin, order_next_.begin() + 1 + filled_);
        for (std::uint32_t i = begin; i < filled_; ++i) {
            position_[order_next_[i + 1]] = i + 1;
        }
    }
    add_contour(begin, closed, is_mixed);
}

void LinkGraph::follow_any_orientation(Slot start, int leave_by, bool closed) {
    Slot slot = start;
    for (;;) {
        worker_.spend(slot_work);
        order_next_[filled_ + 1] = slot;
        leave_by_[filled_] = static_cast<std::uint8_t>(leave_by);
        position_[slot] = ++filled_;
        const PortRef next = slots_.ports()[port_of(slot, leave_by)].across;
        if (next == no_port || (closed && slot_of(next) == start)) {
            return;
        }
        slot = slot_of(next);
        leave_by = 1 - static_cast<int>(next & 1);
    }
}

/// True if most segments of the walk run against it, or as many as along it where the walk backwards is the smaller sequence
/// of edges, a closed one from its smallest edge on.
bool LinkGraph::runs_backwards(std::uint32_t begin, bool closed) {
    const std::uint32_t count = filled_ - begin;
    const Slot* slots = order_next_.data() + 1 + begin;
    const std::uint32_t segments = closed ? count : count - 1;
    std::uint32_t forwards = 0;
    for (std::uint32_t i = 0; i < segments; ++i) {
        const bool by_source = leave_by_[begin + i] == source_port;
        const auto other = by_source ? SlotTable::mixed_source_is_target : SlotTable::mixed_target_is_source;
        forwards += !slots_.has_any(slots[i], other) == by_source ? 1 : 0;
    }
    if (2 * forwards != segments) {
        return 2 * forwards < segments;
    }
    const auto key_at = [&](std::uint32_t i) { return to_key(slots_.edge(slots[i % count])); };
    const auto smaller = [&](std::uint32_t a, bool a_back, std::uint32_t b, bool b_back) {
        for (std::uint32_t i = 0; i < count; ++i) {
            worker_.spend(slot_work);
            const EndKey key_a = key_at(a_back ? a + count - i : a + i);
            const EndKey key_b = key_at(b_back ? b + count - i : b + i);
            if (key_a != key_b) {
                return key_a < key_b;
            }
        }
        return false;
    };
    if (!closed) {
        return smaller(count - 1, true, 0, false);
    }
    std::uint32_t best = 0;
    bool best_back = false;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (key_at(i) <= key_at(best)) {
            for (const bool back : {false, true}) {
                if (smaller(i, back, best, best_back)) {
                    best = i;
                    best_back = back;
                }
            }
        }
    }
    return best_back;
}

}  // namespace lamella
