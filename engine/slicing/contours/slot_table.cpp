#include "slicing/contours/slot_table.hpp"

#include <algorithm>
#include <bit>
#include <iterator>
#include <utility>

#include "base/numbers.hpp"
#include "base/sort.hpp"
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

void SlotTable::disconnect(Slot slot) noexcept {
    ports_[port_of(slot, target_port)].across = no_port;
    ports_[port_of(slot, source_port)].across = no_port;
}

void SlotTable::add_flag(Slot slot, Flag flag) noexcept {
    const std::uint16_t before = flags_[slot];
    const auto after = static_cast<std::uint16_t>(before | flag);
    flags_[slot] = after;
    open_ += (after & open_end) != 0 && (before & open_end) == 0 ? 1 : 0;
    mixed_ += (after & mixed) != 0 && (before & mixed) == 0 ? 1 : 0;
}

/// An angle is measured from the face with the smallest apex off the edge's line: by quadrant, and within one by the side on
/// which one face lies of another.
void sort_round_edge(const GridVertex& lower, const GridVertex& upper, std::span<FaceAtEdge> faces) {
    const GridVector origin = half(lower);
    const GridVector axis = half(upper) - origin;
    const auto arm = [&](const FaceAtEdge& face) { return half(face.apex) - origin; };
    const auto normal = [&](const FaceAtEdge& face) { return cross(axis, arm(face)); };
    const FaceAtEdge* reference = nullptr;
    for (const FaceAtEdge& face : faces) {
        if (normal(face) != GridVector{} && (reference == nullptr || face.apex < reference->apex)) {
            reference = &face;
        }
    }
    const GridVector zero = reference != nullptr ? normal(*reference) : GridVector{};
    // 0: at the reference (or on the axis, where there is no angle), 1: within half a turn, 2: half a turn, 3: beyond.
    const auto quadrant = [&](const FaceAtEdge& face) {
        if (const int side = sign_of(dot(zero, arm(face))); side != 0) {
            return side > 0 ? 1 : 3;
        }
        return dot(zero, normal(face)) < 0 ? 2 : 0;  // the normals are parallel
    };
    sort_briefly(faces.begin(), faces.end(), [&](const FaceAtEdge& a, const FaceAtEdge& b) {
        const int quadrant_a = quadrant(a);
        const int quadrant_b = quadrant(b);
        if (quadrant_a != quadrant_b) {
            return quadrant_a < quadrant_b;
        }
        if (quadrant_a % 2 == 1) {
            if (const int turn = sign_of(dot(normal(a), arm(b))); turn != 0) {
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

// Irregular edges: ends that meet at one edge are paired by orientation, then by angle.
//
// The ends are sorted counter-clockwise round the edge, seen from above. The solid begins at an end that goes out (its left
// is the counter-clockwise side) and ends at one that comes in: "out" opens a bracket, "in" closes it. Matching brackets
// share a wedge of solid, so contours paired this way never cross:
//
//              out                          four faces, two solids that touch along the edge:
//               | solid A                       out in out in   ->   (out in) (out in)
//        -------+------- in
//     in        |                           a solid with a wedge-shaped gap of solid in its gap ...:
//       solid B | out                           out out in in   ->   (out (out in) in)
//
// The ends left over have one orientation. Each pairs with its neighbour round the edge, and an odd one ends an open
// polyline.

void SlotTable::mark_open(Slot slot) noexcept {
    add_flag(slot, open_end);
    disconnect(slot);  // the end that is there is connected later
}

bool SlotTable::settle(std::span<Link> links, SortEnds sort_ends) {
    gather_first_ends();
    if (one_sided_ || !late_ends_.empty()) {
        for (const Slot slot : fresh()) {
            const bool both = ports_[port_of(slot, target_port)].first_link != no_link &&
                              ports_[port_of(slot, source_port)].first_link != no_link;
            if (!both && !has_any(slot, irregular)) {
                mark_open(slot);
            }
        }
    }
    sort_briefly(late_ends_.begin(), late_ends_.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
    for (auto begin = late_ends_.begin(); begin != late_ends_.end();) {
        const auto end = std::find_if(begin, late_ends_.end(), [begin](const auto& end) { return end.slot != begin->slot; });
        const std::span<MeetingEnd> ends(&*begin, static_cast<std::size_t>(end - begin));
        sort_ends(ends);
        seat_pairs(ends, links);
        begin = end;
    }
    return !late_ends_.empty();
}

/// The ends that came first join those that came late to their edge.
void SlotTable::gather_first_ends() {
    const std::size_t late = late_ends_.size();
    for (std::size_t i = 0; i < late; ++i) {
        const Slot slot = late_ends_[i].slot;
        for (const int port : {target_port, source_port}) {
            const LinkIndex first = ports_[port_of(slot, port)].first_link;
            if (first != no_link && !has_any(slot, irregular)) {
                late_ends_.push_back({slot, first, port == source_port});
            }
        }
        add_flag(slot, irregular);
    }
}

std::span<const std::array<std::uint32_t, 2>> Pairing::match(std::span<const MeetingEnd> ends) {
    pairs_.clear();
    unopened_.clear();
    unclosed_.clear();
    for (std::uint32_t i = 0; i < ends.size(); ++i) {
        if (ends[i].is_source) {
            unclosed_.push_back(i);
        } else if (unclosed_.empty()) {
            unopened_.push_back(i);
        } else {
            pairs_.push_back({i, unclosed_.back()});
            unclosed_.pop_back();
        }
    }
    // Round the corner: brackets still open meet the ones that closed before any had been opened.
    std::size_t closed = 0;
    for (; closed < unopened_.size() && !unclosed_.empty(); ++closed) {
        pairs_.push_back({unopened_[closed], unclosed_.back()});
        unclosed_.pop_back();
    }
    const auto rest = closed < unopened_.size() ? std::span(unopened_).subspan(closed) : std::span(unclosed_);
    for (std::size_t i = 0; i < rest.size(); i += 2) {
        pairs_.push_back({rest[i], i + 1 < rest.size() ? rest[i + 1] : no_partner});
    }
    return pairs_;
}

/// Gives the end this port, whatever its own orientation.
void SlotTable::seat(Slot slot, int port, const MeetingEnd& end, std::span<Link> links) noexcept {
    links[end.link].ends[end.is_source ? source_port : target_port] = port_of(slot, port);
    if (end.is_source && port == target_port) {
        add_flag(slot, mixed_target_is_source);
    } else if (!end.is_source && port == source_port) {
        add_flag(slot, mixed_source_is_target);
    }
}

/// One slot for each pair, the first in the slot that they met in.
void SlotTable::seat_pairs(std::span<const MeetingEnd> ends, std::span<Link> links) {
    const auto pairs = pairing_.match(ends);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto [in, out] = pairs[i];
        const Slot at = i == 0 ? ends.front().slot : add_copy(ends.front().slot);
        if (out != Pairing::no_partner) {
            seat(at, target_port, ends[in], links);
            seat(at, source_port, ends[out], links);
        } else {
            seat(at, ends[in].is_source ? source_port : target_port, ends[in], links);
            mark_open(at);
        }
    }
}

}  // namespace lamella
