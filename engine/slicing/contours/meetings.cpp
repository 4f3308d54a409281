#include "slicing/contours/meetings.hpp"

#include <algorithm>
#include <utility>

namespace lamella {

namespace {

void mark_open(SlotTable& slots, Slot slot) {
    slots.add_flag(slot, SlotTable::open_end);
    slots.disconnect(slot);  // the end that is there is connected later
}

void mark_open_ends(SlotTable& slots) {
    for (const Slot slot : slots.fresh()) {
        const bool both = slots.first_link(slot, target_port) != no_link && slots.first_link(slot, source_port) != no_link;
        if (!both && !slots.has_any(slot, SlotTable::irregular)) {
            mark_open(slots, slot);
        }
    }
}

/// Gives the end this port, whatever its own orientation.
void seat(SlotTable& slots, Slot slot, int port, const MeetingEnd& end, std::span<Link> links) {
    links[end.link].ends[end.is_source ? source_port : target_port] = port_of(slot, port);
    if (end.is_source && port == target_port) {
        slots.add_flag(slot, SlotTable::mixed_target_is_source);
    } else if (!end.is_source && port == source_port) {
        slots.add_flag(slot, SlotTable::mixed_source_is_target);
    }
}

}  // namespace

bool Meetings::settle(SlotTable& slots, std::span<Link> links, Order order, Copied copied) {
    const std::span<const SlotTable::LateEnd> late = slots.late_ends();
    for (const SlotTable::LateEnd& end : late) {
        slots.add_flag(end.slot, SlotTable::irregular);
    }
    if (slots.one_sided() || !late.empty()) {
        mark_open_ends(slots);
    }
    if (late.empty()) {
        return false;
    }
    settle_irregular(slots, links, order, copied);
    return true;
}

void Meetings::settle_irregular(SlotTable& slots, std::span<Link> links, Order order, Copied copied) {
    const std::span<SlotTable::LateEnd> late = slots.late_ends();
    std::sort(late.begin(), late.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
    for (std::size_t i = 0; i < late.size();) {
        const Slot slot = late[i].slot;
        ends_.clear();
        for (const int port : {target_port, source_port}) {
            if (const LinkIndex first = slots.first_link(slot, port); first != no_link) {
                ends_.push_back({first, port == source_port});
            }
        }
        for (; i < late.size() && late[i].slot == slot; ++i) {
            ends_.push_back({late[i].link, late[i].is_source});
        }
        order(slot, ends_);
        pairing_.match(ends_);
        seat_pairs(slots, slot, links, copied);
    }
}

/// One slot for each pair, the first in the slot that they met in.
void Meetings::seat_pairs(SlotTable& slots, Slot slot, std::span<Link> links, Copied copied) const {
    bool first = true;
    const auto next_slot = [&] {
        if (std::exchange(first, false)) {
            return slot;
        }
        const Slot copy = slots.add_copy(slot);
        copied(copy, slot);
        return copy;
    };
    for (const auto& [in, out] : pairing_.pairs()) {
        const Slot at = next_slot();
        seat(slots, at, target_port, ends_[in], links);
        seat(slots, at, source_port, ends_[out], links);
    }
    if (pairing_.odd_one() >= 0) {
        const MeetingEnd& odd = ends_[static_cast<std::size_t>(pairing_.odd_one())];
        const Slot at = next_slot();
        seat(slots, at, odd.is_source ? source_port : target_port, odd, links);
        mark_open(slots, at);
    }
}

}  // namespace lamella
