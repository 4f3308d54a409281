// Stage 6: the walk along the links of a plane; see link_graph.hpp.
#include <algorithm>
#include <bit>
#include <cstring>

#include "slicing/contours/copy_run.hpp"
#include "slicing/contours/link_graph.hpp"

namespace lamella {

// --- Walking along the segments' sense
//
// The last plane's order, with a break after each position whose link changed and at each contour's end:
//
//     order    a b c | d e | f g h i |            | break
//     runs     [---]  [-]   [-----]               a run is walked by copying it
//
// A link that changed has its source's position marked, so that no run is ever entered but at its first slot.

void LinkGraph::walk() {
    if (changes_ == 0) {
        return;
    }
    begin_order();
    if (mixed_ > 0) {
        walk_any_sense();
        finish_order();
        order_known_ = false;
        return;
    }
    chase_ = !order_known_ || most_changed();
    if (open_ > 0) {
        walk_sources();
    }
    if (chase_ && order_known_ && open_ == 0 && capacity() < first_mark / 2) {
        walk_pieces();
    } else {
        walk_old_starts();
    }
    if (!chase_) {
        walk_old_runs();
    }
    walk_rest();
    assert(filled_ == live() && "every slot is walked once");
    finish_order();
    order_known_ = true;
}

void LinkGraph::begin_order() {
    if (order_next_.size() < live() + 1 + run_padding) {
        order_next_.resize(std::max(live() + live() / 32 + 1 + run_padding, order_next_.size()));
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

/// A slot not yet walked has its old position; what order_next_ holds there tells.
bool LinkGraph::walked(Slot slot) const noexcept {
    const std::uint32_t position = position_[slot];
    return position - 1 < filled_ && order_next_[position] == slot;
}

void LinkGraph::walk_sources() {
    for (Slot slot = 0; slot < slot_end_; ++slot) {
        if (!is_free(slot) && !has(slot, target_port)) {
            walk_from(slot);
        }
    }
}

/// What the starts of the last plane's contours did not lead to: parts that split off.
void LinkGraph::walk_old_runs() {
    for (std::uint32_t position = 1; filled_ < live() && position <= ordered_; position = next_break(position) + 1) {
        const Slot slot = order_[position];
        if (position_[slot] == position && !walked(slot)) {
            walk_from(slot);
        }
    }
}

void LinkGraph::walk_old_starts() {
    for (const WalkedContour& contour : old_contours_) {
        const std::uint32_t position = contour.begin + 1;
        const Slot slot = order_[position];
        if (chase_ ? !is_free(slot) && !walked(slot) : position_[slot] == position && !walked(slot)) {
            walk_from(slot);
        }
    }
}

/// What began at this plane, and after a walk along links what split off.
void LinkGraph::walk_rest() {
    for (const Slot slot : fresh()) {
        if (filled_ == live()) {
            return;
        }
        if (!walked(slot)) {
            walk_from(slot);
        }
    }
    for (Slot slot = 0; filled_ < live() && slot < slot_end_; ++slot) {
        if (!is_free(slot) && !walked(slot)) {
            walk_from(slot);
        }
    }
}

void LinkGraph::walk_from(Slot start) {
    const std::uint32_t begin = filled_;
    const bool closed = chase_ ? follow_links(start) : follow_runs(start);
    add_contour(begin, closed, false);
}

/// Appends the contour from `start` on, run by run; true if it closed.
bool LinkGraph::follow_runs(Slot start) {
    Slot* const out = order_next_.data() + 1;
    std::uint32_t* const positions = position_.data();
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
        const PortRef next = links_[2 * last + source_port];
        slot = next >> 1;
        if (next == no_link || slot == start) {
            filled_ = filled;
            return next != no_link;
        }
    }
}

/// The same link by link: where runs are a few slots long this is the faster. Each link waits for the one before it, but the
/// last plane's order tells what will be asked for soon.
bool LinkGraph::follow_links(Slot start) {
    constexpr std::size_t ahead = 12;
    static_assert(ahead < run_padding);
    Slot* const out = order_next_.data() + 1;
    std::uint32_t* const positions = position_.data();
    const PortRef* const links = links_.data();
    const Slot* const old_order = order_.data();
    std::uint32_t filled = filled_;
    PortRef next = 2 * start;  // each target port's source port is beside it
    static_assert(target_port == 0 && source_port == 1);
    do {
        const Slot slot = next >> 1;
        const Slot soon = old_order[positions[slot] + ahead];
        __builtin_prefetch(links + 2 * soon);
        __builtin_prefetch(positions + soon, 1);
        out[filled] = slot;
        positions[slot] = ++filled;
        next = links[next | source_port];
    } while (next != no_link && (next >> 1) != start);
    filled_ = filled;
    return next != no_link;
}

void LinkGraph::add_contour(std::uint32_t begin, bool closed, bool is_mixed) {
    contours_.push_back({begin, filled_ - begin, closed, is_mixed});
}

// --- Walking where senses disagree

void LinkGraph::walk_any_sense() {
    leave_by_.resize(order_next_.size());
    const auto walk_along = [this](Slot slot, int leave_by, bool closed) {
        const std::uint32_t begin = filled_;
        follow_any_sense(slot, leave_by, closed);
        bool is_mixed = false;
        for (std::uint32_t i = begin; i < filled_; ++i) {
            is_mixed = is_mixed || (flags_[order_next_[i + 1]] & mixed) != 0;
        }
        if (runs_backwards(begin, closed)) {
            std::reverse(order_next_.begin() + 1 + begin, order_next_.begin() + 1 + filled_);
            for (std::uint32_t i = begin; i < filled_; ++i) {
                position_[order_next_[i + 1]] = i + 1;
            }
        }
        add_contour(begin, closed, is_mixed);
    };
    for (Slot slot = 0; slot < slot_end_ && open_ > 0; ++slot) {
        if (!is_free(slot) && (flags_[slot] & open_end) != 0 && !walked(slot)) {
            walk_along(slot, !has(slot, target_port) ? source_port : target_port, false);
        }
    }
    for (Slot slot = 0; slot < slot_end_; ++slot) {
        if (!is_free(slot) && !walked(slot)) {
            walk_along(slot, source_port, true);
        }
    }
    assert(filled_ == live() && "every slot is walked once");
}

void LinkGraph::follow_any_sense(Slot start, int leave_by, bool closed) {
    Slot slot = start;
    for (;;) {
        order_next_[filled_ + 1] = slot;
        leave_by_[filled_] = static_cast<std::uint8_t>(leave_by);
        position_[slot] = ++filled_;
        const PortRef next = links_[2 * slot + static_cast<unsigned>(leave_by)];
        if (next == no_link || (closed && (next >> 1) == start)) {
            return;
        }
        slot = next >> 1;
        leave_by = 1 - static_cast<int>(next & 1);
    }
}

/// Whether most segments of the walk run against it; where as many do as do not, whether the walk backwards reads smaller as
/// a sequence of edges, a closed one from its smallest edge on.
bool LinkGraph::runs_backwards(std::uint32_t begin, bool closed) const {
    const std::uint32_t count = filled_ - begin;
    const Slot* slots = order_next_.data() + 1 + begin;
    const std::uint32_t segments = closed ? count : count - 1;
    std::uint32_t forwards = 0;
    for (std::uint32_t i = 0; i < segments; ++i) {
        const unsigned flag = leave_by_[begin + i] == source_port ? mixed_source_is_target : mixed_target_is_source;
        forwards += ((flags_[slots[i]] & flag) == 0) == (leave_by_[begin + i] == source_port) ? 1 : 0;
    }
    if (2 * forwards != segments) {
        return 2 * forwards < segments;
    }
    const auto key_at = [&](std::uint32_t i) { return to_key(edges_[slots[i % count]]); };
    const auto smaller = [&](std::uint32_t a, bool a_back, std::uint32_t b, bool b_back) {
        for (std::uint32_t i = 0; i < count; ++i) {
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
