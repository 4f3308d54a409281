#include "slicing/contours/slot_table.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "base/numbers.hpp"
#include "slicing/grid/exact.hpp"

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

namespace {

/// Where directions lie round an axis, measured counter-clockwise from a reference.
class AngleOrder {
public:
    AngleOrder(const GridVertex& lower, const GridVertex& upper, const GridVertex& reference) noexcept
        : lower_(half(lower)), axis_(half(upper) - lower_), reference_normal_(normal_to(reference)) {}

    /// 0: at the reference (or on the axis, where there is no angle), 1: within half a turn, 2: half a turn, 3: beyond.
    int quadrant(const GridVertex& apex) const noexcept {
        if (const int side = sign_of(dot(reference_normal_, half(apex) - lower_)); side != 0) {
            return side > 0 ? 1 : 3;
        }
        return dot(reference_normal_, normal_to(apex)) < 0 ? 2 : 0;  // the normals are parallel
    }

    /// Positive where b lies counter-clockwise of a by less than half a turn.
    int turn(const GridVertex& a, const GridVertex& b) const noexcept {
        return sign_of(dot(normal_to(a), half(b) - lower_));
    }

    bool on_axis(const GridVertex& apex) const noexcept { return normal_to(apex) == GridVector{}; }

private:
    /// Of the plane through the axis and a vertex.
    GridVector normal_to(const GridVertex& apex) const noexcept { return cross(axis_, half(apex) - lower_); }

    GridVector lower_;
    GridVector axis_;
    GridVector reference_normal_;
};

}  // namespace

void sort_round_edge(const GridVertex& lower, const GridVertex& upper, std::span<FaceAtEdge> faces) {
    assert(!faces.empty());
    const AngleOrder any(lower, upper, faces.front().apex);
    const GridVertex* reference = nullptr;
    for (const FaceAtEdge& face : faces) {
        if (!any.on_axis(face.apex) && (reference == nullptr || face.apex < *reference)) {
            reference = &face.apex;
        }
    }
    const AngleOrder order(lower, upper, reference != nullptr ? *reference : faces.front().apex);
    std::sort(faces.begin(), faces.end(), [&](const FaceAtEdge& a, const FaceAtEdge& b) {
        const int quadrant_a = order.quadrant(a.apex);
        const int quadrant_b = order.quadrant(b.apex);
        if (quadrant_a != quadrant_b) {
            return quadrant_a < quadrant_b;
        }
        if (quadrant_a % 2 == 1) {
            if (const int turn = order.turn(a.apex, b.apex); turn != 0) {
                return turn > 0;
            }
        }
        if (a.end.is_source != b.end.is_source) {
            return !a.end.is_source;
        }
        const FaceAtEdge& first = a.end.is_source ? b : a;
        const FaceAtEdge& second = a.end.is_source ? a : b;
        return first.apex != second.apex ? first.apex < second.apex : first.triangle < second.triangle;
    });
}

void Pairing::match(std::span<const MeetingEnd> ends) {
    pairs_.clear();
    stack_.clear();
    unmatched_.clear();
    odd_ = -1;
    for (std::uint32_t i = 0; i < ends.size(); ++i) {
        if (ends[i].is_source) {
            stack_.push_back(i);
        } else if (!stack_.empty()) {
            pairs_.emplace_back(i, stack_.back());
            stack_.pop_back();
        } else {
            unmatched_.push_back(i);
        }
    }
    // Round the corner: brackets still open meet the ones that closed before any had been opened.
    std::size_t closed = 0;
    for (; closed < unmatched_.size() && !stack_.empty(); ++closed) {
        pairs_.emplace_back(unmatched_[closed], stack_.back());
        stack_.pop_back();
    }
    unmatched_.erase(unmatched_.begin(), unmatched_.begin() + static_cast<std::ptrdiff_t>(closed));
    const auto& rest = unmatched_.empty() ? stack_ : unmatched_;
    for (std::size_t i = 0; i + 1 < rest.size(); i += 2) {
        pairs_.emplace_back(rest[i], rest[i + 1]);
    }
    if (rest.size() % 2 == 1) {
        odd_ = rest.back();
    }
}

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
