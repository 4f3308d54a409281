#include "slicing/contours/slot_table.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace lamella {

void SlotTable::reserve(std::size_t slots) {
    const std::size_t before = capacity();
    if (slots <= before) {
        return;
    }
    grow_exactly(ports_, 2 * slots, worker_);
    grow_exactly(ends_, slots, worker_, no_plane);
    grow_exactly(flags_, slots, worker_);
    grow_exactly(free_, slots + select_padding, worker_);
    grow_exactly(edges_, slots, worker_);  // the last: a table that could not grow has the capacity that it had
    // New slots go beneath the stack. The slots that are being made lie above its top and come along.
    const std::size_t added = slots - before;
    std::copy_backward(free_.begin(), free_.begin() + static_cast<std::ptrdiff_t>(before),
                       free_.begin() + static_cast<std::ptrdiff_t>(slots));
    std::generate_n(free_.begin(), added, [slot = static_cast<Slot>(slots)]() mutable { return --slot; });
    free_count_ += added;
}

void SlotTable::clear() {
    std::fill_n(ends_.begin(), slot_end_, no_plane);
    std::fill_n(flags_.begin(), slot_end_, std::uint16_t{0});
    free_count_ = capacity() - slot_end_;  // those never used are at the bottom as they were
    while (slot_end_ > 0) {
        free_[free_count_++] = --slot_end_;
    }
    fresh_count_ = 0;
    open_ = 0;
    mixed_ = 0;
}

// --- Edges that end and edges that begin

std::span<const Slot> SlotTable::release_ended(PlaneIndex plane) {
    Slot* const ended = free_.data() + free_count_;
    const std::size_t count = kernels_.select_equal(ends_.data(), slot_end_, plane, ended);
    for (std::size_t i = 0; i < count; ++i) {
        const Slot slot = ended[i];
        ends_[slot] = no_plane;
        if (flags_[slot] != 0) {
            const std::uint16_t flags = std::exchange(flags_[slot], std::uint16_t{0});
            open_ -= (flags & open_end) != 0 ? 1 : 0;
            mixed_ -= (flags & mixed) != 0 ? 1 : 0;
        }
    }
    free_count_ += count;
    fresh_count_ = 0;
    return {ended, count};
}

SlotTable::Attaching SlotTable::begin_attaching(std::size_t attachments) {
    // Mostly two ends share an edge. Small maps are then an eighth full: an edge that finds its place taken costs a
    // mispredicted branch. Large ones, of a band's first plane, save memory.
    const bool small = attachments < (std::size_t{1} << 16);
    const std::size_t edges = small ? attachments : attachments / 2 + 64;
    const std::size_t size = std::bit_ceil(std::max<std::size_t>(16, small ? 4 * edges : 2 * edges));
    late_ends_.clear();
    clear_map(size);
    map_mask_ = size - 1;
    map_shift_ = 64 - std::countr_zero(size);
    map_limit_ = static_cast<std::uint32_t>(edges);
    if (const std::size_t needed = live() + edges + 1; needed > capacity()) {  // one is written before it is known to be new
        reserve(needed + needed / 8);
    }
    return Attaching(*this);
}

void SlotTable::clear_map(std::size_t size) {
    grow_exactly(map_, size, worker_);
    worker_.in_stretches(
        0, size, 1, [this](std::size_t begin, std::size_t end) { std::fill_n(map_.data() + begin, end - begin, no_slot); });
}

/// More edges than expected: the `made` ones so far go to a map of twice the size.
void SlotTable::grow_map(std::uint32_t made) {
    const std::size_t size = 2 * (map_mask_ + 1);
    clear_map(size);
    map_mask_ = size - 1;
    --map_shift_;
    map_limit_ = static_cast<std::uint32_t>(size - size / 8);
    reserve(live() + map_limit_ + 1);
    for (std::uint32_t i = 1; i <= made; ++i) {
        const Slot slot = free_[free_count_ - i];
        std::size_t place = edges_[slot].hash() >> map_shift_;
        while (map_[place] != no_slot) {
            place = (place + 1) & map_mask_;
        }
        map_[place] = slot;
    }
}

void SlotTable::end_attaching(const Attaching& attaching, std::size_t attachments) {
    ends_[*(attaching.free_top_ - attaching.made_)] = no_plane;  // the spare that was not taken
    take_spares(attaching.made_);
    one_sided_ = attachments - late_ends_.size() < 2 * std::size_t{attaching.made_};
}

/// Takes `count` slots off the stack, to fresh().
void SlotTable::take_spares(std::uint32_t count) {
    free_count_ -= count;
    fresh_count_ += count;
    if (count > 0) {  // the highest of those never used is the deepest
        slot_end_ = std::max(slot_end_, free_[free_count_] + 1);
    }
}

Slot SlotTable::add_copy(Slot slot) {
    if (free_count_ == 0) {
        reserve(capacity() + capacity() / 2 + 64);
    }
    take_spares(1);
    const Slot copy = free_[free_count_];
    edges_[copy] = edges_[slot];
    ends_[copy] = ends_[slot];
    disconnect(copy);
    return copy;
}

void SlotTable::connect(std::span<const Link> links) noexcept {
    for (const Link& link : links) {
        ports_[link.ends[source_port]].across = link.ends[target_port];
        ports_[link.ends[target_port]].across = link.ends[source_port];
    }
}

void SlotTable::add_flag(Slot slot, Flag flag) noexcept {
    const std::uint16_t before = flags_[slot];
    const auto after = static_cast<std::uint16_t>(before | flag);
    flags_[slot] = after;
    open_ += (after & open_end) != 0 && (before & open_end) == 0 ? 1 : 0;
    mixed_ += (after & mixed) != 0 && (before & mixed) == 0 ? 1 : 0;
}

}  // namespace lamella
