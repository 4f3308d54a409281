#include "slicing/contours/link_graph.hpp"
#include "lamella/memory.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace lamella {

LinkGraph::LinkGraph(const Memory* memory)
    : kernels_(best_of(kernel_forms())),
      edges_(memory),
      links_(memory),
      ends_(memory),
      flags_(memory),
      position_(memory),
      free_(memory),
      moving_(memory),
      table_(memory),
      crowd_(memory),
      meeting_(memory),
      pairing_(memory),
      order_(memory),
      order_next_(memory),
      breaks_(memory),
      contours_(memory),
      old_contours_(memory),
      pieces_(memory),
      lanes_(memory),
      leave_by_(memory) {
    clear();
}

void LinkGraph::clear() {
    crowd_.clear();
    contours_.clear();
    free_all_from(0);
    open_ = 0;
    mixed_ = 0;
    ordered_ = 0;
    order_.resize(std::max<std::size_t>(32, order_.size()));
    breaks_.assign(1, 0);
    changes_ = 0;
    order_known_ = true;
}

void LinkGraph::reserve(std::size_t slots) {
    const std::size_t before = capacity();
    if (slots <= before) {
        return;
    }
    resize_exactly(edges_, slots);
    resize_exactly(links_, 2 * slots);
    resize_exactly(ends_, slots, no_plane);
    resize_exactly(flags_, slots);
    resize_exactly(position_, slots, no_position);
    // What was added goes beneath the stack. The slots that are being made lie above its top and come along.
    const std::size_t added = slots - before;
    resize_exactly(free_, slots + select_padding);
    std::copy_backward(free_.begin(), free_.begin() + static_cast<std::ptrdiff_t>(before),
                       free_.begin() + static_cast<std::ptrdiff_t>(slots));
    std::generate_n(free_.begin(), added, [slot = static_cast<Slot>(slots)]() mutable { return --slot; });
    free_count_ += added;
}

/// Slots from `first` on are free, none below it is.
void LinkGraph::free_all_from(Slot first) {
    for (Slot slot = first; slot < slot_end_; ++slot) {
        ends_[slot] = no_plane;
        flags_[slot] = 0;
        position_[slot] = no_position;
    }
    free_count_ = capacity() - slot_end_;  // those never used are at the bottom as they were
    while (slot_end_ > first) {
        free_[free_count_++] = --slot_end_;
    }
    fresh_count_ = 0;
}

// --- Edges that end and edges that begin

void LinkGraph::release_ended(PlaneIndex plane) {
    Slot* const ended = free_.data() + free_count_;
    const std::size_t count = kernels_.select_equal(ends_.data(), slot_end_, plane, ended);
    for (std::size_t i = 0; i < count; ++i) {
        const Slot slot = ended[i];
        break_after(position_[slot]);
        position_[slot] = no_position;
        ends_[slot] = no_plane;
        if (flags_[slot] != 0) {
            const std::uint16_t flags = std::exchange(flags_[slot], std::uint16_t{0});
            open_ -= (flags & open_end) != 0 ? 1 : 0;
            mixed_ -= (flags & mixed) != 0 ? 1 : 0;
        }
    }
    free_count_ += count;
    fresh_count_ = 0;
    changes_ += count;
}

LinkGraph::Attaching LinkGraph::begin_attaching(std::size_t attachments) {
    // Two ends share an edge as a rule. Small tables are an eighth full then: an edge that finds its place taken is what the
    // processor does not foresee. Large ones, of a band's first plane, take memory.
    const bool small = attachments < (std::size_t{1} << 16);
    const std::size_t edges = small ? attachments : attachments / 2 + 64;
    const std::size_t size = std::bit_ceil(std::max<std::size_t>(16, small ? 4 * edges : 2 * edges));
    clear_table(size);
    table_mask_ = size - 1;
    table_shift_ = 64 - std::countr_zero(size);
    limit_ = static_cast<std::uint32_t>(edges);
    if (const std::size_t needed = live() + edges + 1; needed > capacity()) {  // one is written before it is known to be new
        reserve(needed + needed / 8);
    }
    return Attaching(*this);
}

void LinkGraph::clear_table(std::size_t size) {
    if (table_.size() < size) {
        resize_exactly(table_, size);
    }
    std::fill_n(table_.begin(), size, no_slot);
}

/// Fewer ends shared an edge than is the rule: the `made` edges so far go to a table of twice the size.
void LinkGraph::grow(std::uint32_t made) {
    const std::size_t size = 2 * (table_mask_ + 1);
    clear_table(size);
    table_mask_ = size - 1;
    --table_shift_;
    limit_ = static_cast<std::uint32_t>(size - size / 8);
    reserve(live() + limit_ + 1);
    for (std::uint32_t i = 1; i <= made; ++i) {
        const Slot slot = free_[free_count_ - i];
        std::size_t place = edges_[slot].hash() >> table_shift_;
        while (table_[place] != no_slot) {
            place = (place + 1) & table_mask_;
        }
        table_[place] = slot;
    }
}

void LinkGraph::end_attaching(const Attaching& attaching, std::size_t attachments) {
    ends_[*(attaching.free_top_ - attaching.made_)] = no_plane;  // the spare that was not taken
    take_spares(attaching.made_);
    one_sided_ = attachments - crowd_.size() < 2 * std::size_t{attaching.made_};
}

/// Takes `count` slots off the stack, to fresh().
void LinkGraph::take_spares(std::uint32_t count) {
    free_count_ -= count;
    fresh_count_ += count;
    changes_ += count;
    if (count > 0) {  // the highest of those never used is the deepest
        slot_end_ = std::max(slot_end_, free_[free_count_] + 1);
    }
}

// --- Meetings

bool LinkGraph::settle(std::span<Link> links, FunctionRef<void(Slot, std::span<MeetingEnd>)> order,
                       FunctionRef<void(Slot, Slot)> copied) {
    for (const Crowded& c : crowd_) {
        flags_[c.slot] |= crowded;
    }
    if (one_sided_ || !crowd_.empty()) {
        for (const Slot slot : fresh()) {
            const bool both = has(slot, target_port) && has(slot, source_port);
            if (!both && (flags_[slot] & crowded) == 0) {
                note_open(slot);
            }
        }
    }
    if (crowd_.empty()) {
        return false;
    }
    settle_crowded(links, order, copied);
    return true;
}

void LinkGraph::note_open(Slot slot) {
    flags_[slot] |= open_end;
    ++open_;
}

void LinkGraph::settle_crowded(std::span<Link> links, FunctionRef<void(Slot, std::span<MeetingEnd>)> order,
                               FunctionRef<void(Slot, Slot)> copied) {
    std::sort(crowd_.begin(), crowd_.end(), [](const Crowded& a, const Crowded& b) { return a.slot < b.slot; });
    for (std::size_t i = 0; i < crowd_.size();) {
        const Slot slot = crowd_[i].slot;
        meeting_.clear();
        for (const int port : {target_port, source_port}) {
            if (has(slot, port)) {
                meeting_.push_back({links_[2 * slot + static_cast<unsigned>(port)], port == source_port});
            }
        }
        for (; i < crowd_.size() && crowd_[i].slot == slot; ++i) {
            meeting_.push_back({crowd_[i].link, crowd_[i].is_source});
        }
        order(slot, meeting_);
        pairing_.match(meeting_);
        settle_one(slot, links, copied);
    }
    crowd_.clear();
}

/// One slot for each pair, the first in the slot that they met in.
void LinkGraph::settle_one(Slot slot, std::span<Link> links, FunctionRef<void(Slot, Slot)> copied) {
    bool first = true;
    const auto next_slot = [&] {
        if (std::exchange(first, false)) {
            links_[2 * slot + target_port] = no_link;
            links_[2 * slot + source_port] = no_link;
            return slot;
        }
        const Slot copy = add_copy(slot);
        copied(copy, slot);
        return copy;
    };
    for (const auto& [in, out] : pairing_.pairs()) {
        const Slot at = next_slot();
        seat(at, target_port, meeting_[in], links);
        seat(at, source_port, meeting_[out], links);
        mixed_ += (flags_[at] & mixed) != 0 ? 1 : 0;
    }
    if (pairing_.odd_one() >= 0) {
        const MeetingEnd& odd = meeting_[static_cast<std::size_t>(pairing_.odd_one())];
        const Slot at = next_slot();
        seat(at, odd.is_source ? source_port : target_port, odd, links);
        note_open(at);
    }
}

Slot LinkGraph::add_copy(Slot slot) {
    if (free_count_ == 0) {
        reserve(capacity() + capacity() / 2 + 64);
    }
    take_spares(1);
    const Slot copy = free_[free_count_];
    edges_[copy] = edges_[slot];
    ends_[copy] = ends_[slot];
    links_[2 * copy + target_port] = no_link;
    links_[2 * copy + source_port] = no_link;
    return copy;
}

void LinkGraph::seat(Slot slot, int port, const MeetingEnd& end, std::span<Link> links) {
    const PortRef ref = 2 * slot + static_cast<unsigned>(port);
    links[end.link].ends[end.is_source ? source_port : target_port] = ref;
    if (end.is_source && port == target_port) {
        flags_[slot] |= mixed_target_is_source;
    } else if (!end.is_source && port == source_port) {
        flags_[slot] |= mixed_source_is_target;
    }
}

void LinkGraph::connect(std::span<const Link> links) {
    for (const Link& link : links) {
        links_[link.ends[source_port]] = link.ends[target_port];
        links_[link.ends[target_port]] = link.ends[source_port];
    }
    changes_ += links.size();
    if (!most_changed()) {  // else the walk does not ask for runs
        for (const Link& link : links) {
            break_after(position_[link.ends[source_port] >> 1]);
        }
    }
}

// --- Compaction

bool LinkGraph::compact(FunctionRef<void(std::span<const Slot>)> move) {
    assert(changes_ == 0);
    if (slot_end_ < 256 || slot_end_ <= 2 * live()) {
        return false;
    }
    const std::span<const Slot> new_to_old = order();
    gather_slots(edges_, new_to_old, moving_);
    gather_slots(ends_, new_to_old, moving_);
    gather_slots(flags_, new_to_old, moving_);
    for (Slot slot = 0; slot < ordered_; ++slot) {
        PortRef ends[2];
        for (const unsigned port : {0U, 1U}) {
            const PortRef ref = links_[2 * new_to_old[slot] + port];
            ends[port] = ref == no_link ? no_link : moved(ref);
        }
        moving_[slot] = std::bit_cast<std::uint64_t>(ends);
    }
    std::memcpy(links_.data(), moving_.data(), ordered_ * sizeof(std::uint64_t));
    move(new_to_old);
    free_all_from(ordered_);
    for (Slot slot = 0; slot < ordered_; ++slot) {
        order_[slot + 1] = slot;
        position_[slot] = slot + 1;
    }
    return true;
}

}  // namespace lamella
