#include "6_contours/link_graph.hpp"

#include <algorithm>
#include <bit>
#include <type_traits>
#include <utility>

namespace lamella {

LinkGraph::LinkGraph(std::pmr::memory_resource* memory)
    : keys_(memory),
      links_{std::pmr::vector<PortRef>(memory), std::pmr::vector<PortRef>(memory)},
      flags_(memory),
      position_(memory),
      free_(memory),
      fresh_(memory),
      table_(memory),
      crowd_(memory),
      meeting_(memory),
      pairing_(memory),
      order_(memory),
      order_next_(memory),
      breaks_(memory),
      contours_(memory),
      old_starts_(memory),
      leave_by_(memory) {
    clear();
}

void LinkGraph::clear() {
    free_.clear();
    fresh_.clear();
    crowd_.clear();
    contours_.clear();
    used_ = 0;
    slot_end_ = 0;
    live_ = 0;
    open_ = 0;
    mixed_ = 0;
    ordered_ = 0;
    order_.resize(std::max<std::size_t>(1, order_.size()));
    breaks_.assign(1, 0);
    changes_ = 0;
    order_known_ = true;
}

void LinkGraph::reserve(std::size_t slots) {
    if (slots > keys_.size()) {
        keys_.resize(slots);
        links_[target_port].resize(slots);
        links_[source_port].resize(slots);
        flags_.resize(slots);
        position_.resize(slots);
        capacity_ = static_cast<Slot>(slots);
    }
}

void LinkGraph::begin_events(std::size_t attachments) {
    // Two ends share an edge as a rule. Small tables are less than half full then; large ones, of a band's first plane, take
    // memory.
    const bool small = attachments < (std::size_t{1} << 16);
    const std::size_t edges = small ? attachments : attachments / 2;
    const std::size_t size = std::bit_ceil(std::max<std::size_t>(16, edges + edges / 4));
    if (size > table_.size() || ++epoch_ == 0) {
        table_.assign(std::max(size, table_.size()), Entry{0, 0});
        epoch_ = 1;
    }
    table_mask_ = size - 1;
    table_shift_ = 64 - std::countr_zero(size);
    table_limit_ = static_cast<Slot>(size - size / 8);
    fresh_.clear();
    used_ = 0;
    spare_ = spare();
}

/// Fewer ends shared an edge than is the rule: the edges made so far go to a table of twice the size.
void LinkGraph::grow_table() {
    const std::size_t size = 2 * (table_mask_ + 1);
    table_.assign(size, Entry{0, 0});
    epoch_ = 1;
    table_mask_ = size - 1;
    --table_shift_;
    table_limit_ = static_cast<Slot>(size - size / 8);
    const Slot made = std::exchange(used_, 0);
    for (; used_ < made; ++used_) {
        std::size_t i = hash_key(keys_[spare()]) >> table_shift_;
        while (table_[i].epoch == epoch_) {
            i = (i + 1) & table_mask_;
        }
        table_[i] = {epoch_, spare()};
    }
}

std::span<const Slot> LinkGraph::end_attaching() {
    const std::size_t recycled = std::min<std::size_t>(used_, free_.size());
    fresh_.assign(free_.end() - static_cast<std::ptrdiff_t>(recycled), free_.end());
    free_.resize(free_.size() - recycled);
    for (; fresh_.size() < used_; ++slot_end_) {
        fresh_.push_back(slot_end_);
    }
    used_ = 0;
    for (const Slot slot : fresh_) {
        make(slot);
    }
    return fresh_;
}

void LinkGraph::make(Slot slot) {
    flags_[slot] = 0;
    position_[slot] = no_position;
    ++live_;
    ++changes_;
}

// --- Meetings

void LinkGraph::settle(std::span<Link> links, FunctionRef<void(Slot, std::span<MeetingEnd>)> order,
                       FunctionRef<void(Slot, Slot)> copied) {
    for (const Crowded& c : crowd_) {
        flags_[c.slot] |= crowded;
    }
    for (const Slot slot : fresh_) {
        const bool one_sided = links_[target_port][slot] == no_link || links_[source_port][slot] == no_link;
        if (one_sided && (flags_[slot] & crowded) == 0) {
            note_open(slot);
        }
    }
    if (!crowd_.empty()) {
        settle_crowded(links, order, copied);
    }
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
            if (const std::uint32_t link = links_[port][slot]; link != no_link) {
                meeting_.push_back({link, port == source_port});
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
            links_[target_port][slot] = no_link;
            links_[source_port][slot] = no_link;
            return slot;
        }
        const Slot copy = spare();
        reserve(copy + std::size_t{1});
        keys_[copy] = keys_[slot];
        links_[target_port][copy] = no_link;
        links_[source_port][copy] = no_link;
        if (free_.empty()) {
            ++slot_end_;
        } else {
            free_.pop_back();
        }
        fresh_.push_back(copy);
        make(copy);
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

void LinkGraph::seat(Slot slot, int port, const MeetingEnd& end, std::span<Link> links) {
    const PortRef ref = 2 * slot + static_cast<unsigned>(port);
    links[end.link].ends[end.is_source ? source_port : target_port] = ref;
    if (end.is_source && port == target_port) {
        flags_[slot] |= mixed_target_is_source;
    } else if (!end.is_source && port == source_port) {
        flags_[slot] |= mixed_source_is_target;
    }
}

// --- Compaction

bool LinkGraph::compact(FunctionRef<void(std::span<const Slot>)> moved) {
    assert(changes_ == 0);
    if (slot_end_ < 256 || 2 * live_ >= slot_end_) {
        return false;
    }
    const auto moved_ref = [this](PortRef ref) {
        return ref == no_link ? no_link : 2 * (position_[ref >> 1] - 1) + (ref & 1);
    };
    const std::span<const Slot> new_to_old = order();
    const auto move = [new_to_old](auto& array) {
        std::remove_reference_t<decltype(array)> to(array.size(), array.get_allocator());
        std::transform(new_to_old.begin(), new_to_old.end(), to.begin(), [&array](Slot old) { return array[old]; });
        array.swap(to);
    };
    move(keys_);
    move(flags_);
    for (auto& links : links_) {
        move(links);
        std::transform(links.begin(), links.begin() + ordered_, links.begin(), moved_ref);
    }
    moved(new_to_old);
    for (Slot slot = 0; slot < ordered_; ++slot) {
        order_[slot + 1] = slot;
        position_[slot] = slot + 1;
    }
    slot_end_ = ordered_;
    free_.clear();
    fresh_.clear();
    return true;
}

}  // namespace lamella
