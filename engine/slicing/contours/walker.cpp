#include "slicing/contours/link_graph.hpp"

#include <algorithm>
#include <bit>
#include <cassert>

namespace lamella {

/// To be called before the slots are freed.
void LinkGraph::forget_order() {
    const std::size_t numbered = std::min<std::size_t>(slots_.slot_end(), position_.size());
    std::fill_n(position_.begin(), numbered, no_position);
    contours_.clear();
    ordered_ = 0;
    order_.resize(std::max<std::size_t>(2 * run_padding, order_.size()));
    breaks_.assign(1, 0);
    changes_ = 0;
    order_known_ = true;
}

void LinkGraph::release_ended(PlaneIndex plane) {
    const std::span<const Slot> ended = slots_.release_ended(plane);
    for (const Slot slot : ended) {
        break_after(position_[slot]);
        position_[slot] = no_position;
    }
    changes_ += ended.size();
}

void LinkGraph::connect(std::span<const Link> links) {
    constexpr std::size_t link_work = 2;
    worker_.in_stretches(0, links.size(), link_work,
                         [&](std::size_t begin, std::size_t end) { slots_.connect(links.subspan(begin, end - begin)); });
    grow_exactly(position_, slots_.capacity(), worker_, no_position);
    changes_ += slots_.fresh().size() + links.size();
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
    const bool one_orientation = slots_.mixed_count() == 0;
    by_links_ = !order_known_ || most_changed();
    const bool in_pieces = one_orientation && by_links_ && order_known_ && slots_.open_count() == 0;
    if (in_pieces) {
        cut_pieces();
    }
    begin_order();
    if (!one_orientation) {
        walk_any_orientation();
    } else {
        if (slots_.open_count() > 0) {
            walk_open();
        }
        if (in_pieces) {
            walk_pieces();
        } else if (!by_links_) {
            walk_old_starts();
            walk_old_runs();
        }
        walk_rest();
    }
    assert(filled_ == slots_.live() && "every slot is walked once");
    finish_order();
    order_known_ = one_orientation;
}

void LinkGraph::begin_order() {
    const std::size_t live = slots_.live();
    if (order_next_.size() < live + 1 + run_padding) {
        grow_exactly(order_next_, std::max(live + live / 32 + 1 + run_padding, order_next_.size()), worker_);
    }
    filled_ = 0;
    old_contours_.swap(contours_);
    contours_.clear();
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
    for (Slot slot = 0; slot < slots_.slot_end(); ++slot) {
        if (!slots_.is_free(slot) && !slots_.is_linked(slot, target_port)) {
            walk_from(slot);
        }
    }
}

/// Contours that go on from where one of the last plane's began. They are most, and walk_old_runs() then finds their runs
/// walked.
void LinkGraph::walk_old_starts() {
    for (const WalkedContour& contour : old_contours_) {
        const std::uint32_t position = contour.begin + 1;
        const Slot slot = order_[position];
        if (position_[slot] == position && !walked(slot)) {
            walk_from(slot);
        }
    }
}

/// Contours that hold any slot of the last plane: parts that split off.
void LinkGraph::walk_old_runs() {
    for (std::uint32_t position = 1; filled_ < slots_.live() && position <= ordered_; position = next_break(position) + 1) {
        const Slot slot = order_[position];
        if (position_[slot] == position && !walked(slot)) {
            walk_from(slot);
        }
    }
}

/// Contours that begin at this plane, and all others that are left where links are followed.
void LinkGraph::walk_rest() {
    for (const Slot slot : slots_.fresh()) {
        if (filled_ == slots_.live()) {
            return;
        }
        if (!walked(slot)) {
            walk_from(slot);
        }
    }
    for (Slot slot = 0; filled_ < slots_.live() && slot < slots_.slot_end(); ++slot) {
        if (!slots_.is_free(slot) && !walked(slot)) {
            walk_from(slot);
        }
    }
}

void LinkGraph::walk_from(Slot start) {
    const std::uint32_t begin = filled_;
    const bool closed = by_links_ ? follow_links(start) : follow_runs(start);
    add_contour(begin, closed, false);
    worker_.spend(slot_work * (filled_ - begin));
}

/// Appends the contour from `start` on, run by run; true if it closed.
bool LinkGraph::follow_runs(Slot start) {
    Slot* const out = order_next_.data() + 1;
    std::uint32_t* const positions = position_.data();
    const Port* const ports = slots_.ports();
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
        const PortRef next = ports[port_of(last, source_port)].across;
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
    const Port* const ports = slots_.ports();
    const Slot* const old_order = order_.data();
    std::uint32_t filled = filled_;
    PortRef next = port_of(start, target_port);
    static_assert(target_port == 0 && source_port == 1, "a target port's reference | 1 is its slot's source port");
    for (std::uint32_t enough = filled + slots_between_stops;; enough += slots_between_stops) {
        do {
            const Slot slot = slot_of(next);
            const Slot soon = old_order[positions[slot] + ahead];
            __builtin_prefetch(ports + port_of(soon, target_port));
            __builtin_prefetch(positions + soon, 1);
            out[filled] = slot;
            positions[slot] = ++filled;
            next = ports[next | source_port].across;
        } while (next != no_port && slot_of(next) != start && filled != enough);
        if (next == no_port || slot_of(next) == start) {
            filled_ = filled;
            return next != no_port;
        }
        worker_.ask();
    }
}

void LinkGraph::add_contour(std::uint32_t begin, bool closed, bool is_mixed) {
    contours_.push_back({begin, filled_ - begin, closed, is_mixed});
}

}  // namespace lamella
