#include "slicing/contours/link_graph.hpp"

#include <algorithm>
#include <bit>
#include <cassert>

#include "base/system/processor.hpp"

namespace lamella {

/// To be called before the slots are freed.
void LinkGraph::forget_order() {
    const std::size_t numbered = std::min<std::size_t>(slot_end(), position_.size());
    std::fill_n(position_.begin(), numbered, no_position);
    contours_.clear();
    ordered_ = 0;
    order_.resize(std::max<std::size_t>(2 * run_padding, order_.size()));
    breaks_.assign(1, 0);
    changes_ = 0;
    order_known_ = true;
}

void LinkGraph::clear() {
    forget_order();
    SlotTable::clear();
}

void LinkGraph::release_ended(PlaneIndex plane) {
    const std::span<const Slot> ended = SlotTable::release_ended(plane);
    for (const Slot slot : ended) {
        break_after(position_[slot]);
        position_[slot] = no_position;
    }
    changes_ += ended.size();
}

void LinkGraph::connect(std::span<const Link> links) {
    constexpr std::size_t link_work = 2;
    worker_.in_stretches(0, links.size(), link_work,
                         [&](std::size_t begin, std::size_t end) { SlotTable::connect(links.subspan(begin, end - begin)); });
    grow_exactly(position_, capacity(), worker_, no_position);
    changes_ += fresh().size() + links.size();
    if (!most_changed()) {  // else the walk does not ask for runs
        for (const Link& link : links) {
            break_after(position_[slot_of(link.ends[source_port])]);
        }
    }
}

void LinkGraph::walk() {
    if (changes_ == 0) {
        return;
    }
    const bool one_orientation = mixed_count() == 0;
    by_links_ = !order_known_ || most_changed();
    if (const std::size_t room = live() + 1 + run_padding; order_next_.size() < room) {
        grow_exactly(order_next_, room + live() / 32, worker_);
    }
    filled_ = 0;
    old_contours_.swap(contours_);
    contours_.clear();
    if (!one_orientation) {
        walk_any_orientation();
    } else {
        if (open_count() > 0) {
            walk_open();
        }
        if (order_known_) {
            walk_old_starts();
        }
        if (!by_links_) {
            walk_old_runs();
        }
        walk_rest();
    }
    assert(filled_ == live() && "every slot is walked once");
    finish_order();
    order_known_ = one_orientation;
}

void LinkGraph::finish_order() {
    order_.swap(order_next_);
    ordered_ = filled_;
    breaks_.assign(ordered_ / 64 + 1, 0);
    for (const WalkedContour& contour : contours_) {
        break_after(contour.begin + contour.count);
    }
    changes_ = 0;
}

std::uint32_t LinkGraph::next_break(std::uint32_t position) const noexcept {
    std::size_t word = position >> 6;
    std::uint64_t bits = breaks_[word] >> (position & 63) << (position & 63);
    while (bits == 0) {
        bits = breaks_[++word];
    }
    return static_cast<std::uint32_t>(word * 64) + static_cast<std::uint32_t>(std::countr_zero(bits));
}

bool LinkGraph::walked(Slot slot) const noexcept {
    const std::uint32_t position = position_[slot];
    return position - 1 < filled_ && order_next_[position] == slot;
}

/// Open polylines, from the slots that no segment enters.
void LinkGraph::walk_open() {
    for (Slot slot = 0; slot < slot_end(); ++slot) {
        if (!is_free(slot) && !is_linked(slot, target_port)) {
            walk_from(slot);
        }
    }
}

/// Contours that go on from the first slot of the last plane's that is left, if it is near where that one began. They are
/// most, and what comes then finds their runs walked.
void LinkGraph::walk_old_starts() {
    constexpr std::uint32_t near = 16;
    for (const WalkedContour& contour : old_contours_) {
        const std::uint32_t end = contour.begin + 1 + std::min(contour.count, near);
        for (std::uint32_t position = contour.begin + 1; position < end; ++position) {
            const Slot slot = order_[position];
            if (walked(slot)) {
                break;
            }
            if (position_[slot] == position) {
                walk_from(slot);
                break;
            }
        }
    }
}

/// Contours that hold any slot of the last plane: parts that split off.
void LinkGraph::walk_old_runs() {
    for (std::uint32_t position = 1; filled_ < live() && position <= ordered_; position = next_break(position) + 1) {
        const Slot slot = order_[position];
        if (position_[slot] == position && !walked(slot)) {
            walk_from(slot);
        }
    }
}

/// Contours that begin at this plane, and all others that are left where links are followed.
void LinkGraph::walk_rest() {
    for (const Slot slot : fresh()) {
        if (filled_ == live()) {
            return;
        }
        if (!walked(slot)) {
            walk_from(slot);
        }
    }
    for (Slot slot = 0; filled_ < live() && slot < slot_end(); ++slot) {
        if (!is_free(slot) && !walked(slot)) {
            walk_from(slot);
        }
    }
}

void LinkGraph::walk_from(Slot start) {
    const std::uint32_t begin = filled_;
    const bool closed = by_links_ ? follow_links(start) : follow_runs(start);
    contours_.push_back({begin, filled_ - begin, closed, false});
    worker_.spend(slot_work * (filled_ - begin));
}

/// Appends the contour from `start` on, run by run; true if it closed.
bool LinkGraph::follow_runs(Slot start) {
    Slot* const out = order_next_.data() + 1;
    std::uint32_t* const positions = position_.data();
    const Port* const by_ref = ports();
    std::uint32_t filled = filled_;
    Slot slot = start;
    for (;;) {
        const std::uint32_t from = position_[slot];
        Slot last = slot;
        if (from == no_position) {
            out[filled] = slot;
            positions[slot] = ++filled;
        } else {
            const std::uint32_t length = next_break(from) - from + 1;
            const Slot* run = order_.data() + from;
            copy_run(run, length, out + filled);
            if (filled + 1 != from) {
                number_run(run, length, filled + 1, positions);
            }
            filled += length;
            last = run[length - 1];
        }
        const PortRef next = by_ref[port_of(last, source_port)].across;
        slot = slot_of(next);
        if (next == no_port || slot == start) {
            filled_ = filled;
            return next != no_port;
        }
    }
}

/// The same link by link: where runs are a few slots long this is the faster. Each link waits for the one before it, but the
/// last plane's order says which slots will soon be needed.
bool LinkGraph::follow_links(Slot start) {
    constexpr std::size_t ahead = 12;
    constexpr std::uint32_t slots_between_stops = std::uint32_t{1} << 15;
    static_assert(ahead < run_padding);
    Slot* const out = order_next_.data() + 1;
    std::uint32_t* const positions = position_.data();
    const Port* const by_ref = ports();
    const Slot* const old_order = order_.data();
    std::uint32_t filled = filled_;
    PortRef next = port_of(start, target_port);
    static_assert(target_port == 0 && source_port == 1, "a target port's reference | 1 is its slot's source port");
    for (std::uint32_t enough = filled + slots_between_stops;; enough += slots_between_stops) {
        do {
            const Slot slot = slot_of(next);
            const Slot soon = old_order[positions[slot] + ahead];
            prefetch_to_read(by_ref + port_of(soon, target_port));
            prefetch_to_write(positions + soon);
            out[filled] = slot;
            positions[slot] = ++filled;
            next = by_ref[next | source_port].across;
        } while (next != no_port && slot_of(next) != start && filled != enough);
        if (next == no_port || slot_of(next) == start) {
            filled_ = filled;
            return next != no_port;
        }
        worker_.ask();
    }
}

// --- Any orientation: where some slot joins two ends of the same orientation, links are followed by whichever port they
// lead to, and most segments decide which way a contour runs.

void LinkGraph::walk_any_orientation() {
    for (Slot slot = 0; slot < slot_end() && open_count() > 0; ++slot) {
        if (!is_free(slot) && has_any(slot, open_end) && !walked(slot)) {
            walk_polyline(slot, !is_linked(slot, target_port) ? source_port : target_port, false);
        }
    }
    for (Slot slot = 0; slot < slot_end(); ++slot) {
        if (!is_free(slot) && !walked(slot)) {
            walk_polyline(slot, source_port, true);
        }
    }
}

void LinkGraph::walk_polyline(Slot start, int leave_by, bool closed) {
    const std::uint32_t begin = filled_;
    const std::uint32_t forwards = follow_any_orientation(start, leave_by, closed);
    const std::span<Slot> slots(order_next_.data() + 1 + begin, filled_ - begin);
    const bool is_mixed = std::any_of(slots.begin(), slots.end(), [this](Slot slot) { return has_any(slot, mixed); });
    const auto segments = static_cast<std::uint32_t>(slots.size() - (closed ? 0 : 1));
    if (2 * forwards < segments || (2 * forwards == segments && is_smaller_backwards(slots, closed))) {
        std::reverse(slots.begin(), slots.end());
        for (std::uint32_t i = begin; i < filled_; ++i) {
            position_[order_next_[i + 1]] = i + 1;
        }
    }
    contours_.push_back({begin, filled_ - begin, closed, is_mixed});
}

/// Returns how many segments run along the walk.
std::uint32_t LinkGraph::follow_any_orientation(Slot start, int leave_by, bool closed) {
    std::uint32_t forwards = 0;
    for (Slot slot = start;;) {
        worker_.spend(slot_work);
        order_next_[filled_ + 1] = slot;
        position_[slot] = ++filled_;
        const PortRef port = port_of(slot, leave_by);
        const PortRef next = ports()[port].across;
        if (next == no_port) {
            return forwards;
        }
        forwards += runs_from(port) ? 1U : 0U;
        slot = slot_of(next);
        if (closed && slot == start) {
            return forwards;
        }
        leave_by = 1 - static_cast<int>(next & 1);
    }
}

/// True if the walk backwards is the smaller sequence of edges, a closed one from wherever it is smallest.
bool LinkGraph::is_smaller_backwards(std::span<const Slot> slots, bool closed) {
    struct Reading {
        std::size_t from;
        bool back;
    };
    const std::size_t count = slots.size();
    const auto key_at = [&](const Reading& reading, std::size_t i) {
        return to_key(edge(slots[(reading.back ? reading.from + count - i : reading.from + i) % count]));
    };
    const auto is_smaller = [&](const Reading& a, const Reading& b) {
        for (std::size_t i = 0; i < count; ++i) {
            worker_.spend(slot_work);
            if (key_at(a, i) != key_at(b, i)) {
                return key_at(a, i) < key_at(b, i);
            }
        }
        return false;
    };
    Reading best{0, false};
    for (std::size_t from = 0; from < count; ++from) {
        for (const bool back : {false, true}) {
            const bool begins = closed || from == (back ? count - 1 : 0);
            best = begins && is_smaller({from, back}, best) ? Reading{from, back} : best;
        }
    }
    return best.back;
}

}  // namespace lamella
