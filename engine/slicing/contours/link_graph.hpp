// Which segment of a plane follows which: the links over the slot table, what happens where more than two segments meet, and
// the walk along the links, which gives the plane's contours (paper, Algorithm 4). The order in which it meets the slots is
// kept and patched from plane to plane.
//
//     slot_table.hpp    edges, links, the edge map       what a plane's events change; pairing at irregular edges
//     walker.cpp        order and contours
//
// The last plane's order has a break after each position whose link changed and at each contour's end. A link that changed
// has its source's position marked, so a run is never entered but at its first slot:
//
//     order_    a b c d | e f | g h i |          | break
//     runs      [-----]  [-]   [---]             a run is walked by copying it
//
// A slot's position is where it lies in the last order until it is walked, and in the next one from then on. A run that
// stays where it was is therefore not numbered again. Which of the two it is, the next order tells:
//
//     order_         a b c d e f            c has ended, x has begun, the walk has met a, b and d
//     order_next_    a b d . . .
//     position_      a 1, b 2, d 3: in order_next_; e 5, f 6: in order_; c and x: none
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/contours/slot_table.hpp"

namespace lamella {

/// A contour of the current plane: a run of LinkGraph::order().
struct WalkedContour {
    std::uint32_t begin;
    std::uint32_t count;
    bool closed;
    bool mixed;  ///< its segments do not all run the same way
};

class LinkGraph : public SlotTable {
public:
    explicit LinkGraph(Worker& worker) : SlotTable(worker) { forget_order(); }

    // The order follows what these do to the table:
    void clear();
    void release_ended(PlaneIndex plane);
    void connect(std::span<const Link> links);

    /// Brings order() and contours() up to date. O(runs between changes + slots), and O(1) when nothing changed.
    void walk();

    std::span<const Slot> order() const noexcept { return {order_.data() + 1, ordered_}; }
    std::span<const WalkedContour> contours() const noexcept { return contours_; }
    /// The port of `slot` from which a segment leads to `next`, whichever way its facet runs.
    PortRef port_towards(Slot slot, Slot next) const noexcept {
        const PortRef source = port_of(slot, source_port);
        const PortRef across = ports()[source].across;
        return across != no_port && slot_of(across) == next ? source : port_of(slot, target_port);
    }
    /// True if the facet of the segment at a port runs from there.
    bool runs_from(PortRef ref) const noexcept {
        return static_cast<int>(ref & 1) == source_port ? !has_any(slot_of(ref), mixed_source_is_target)
                                                        : has_any(slot_of(ref), mixed_target_is_source);
    }

private:
    static constexpr std::uint32_t no_position = 0;     // positions count from 1, so that a break after it does no harm
    static constexpr std::size_t slot_work = 4;         // as StopPace counts it
    static constexpr std::size_t slots_per_change = 3;  // with fewer, runs are too short to copy

    void forget_order();
    bool most_changed() const noexcept { return changes_ * slots_per_change > live(); }
    void break_after(std::uint32_t position) noexcept { breaks_[position >> 6] |= std::uint64_t{1} << (position & 63); }
    std::uint32_t next_break(std::uint32_t position) const noexcept;
    bool walked(Slot slot) const noexcept;
    void finish_order();

    void walk_open();
    void walk_old_starts();
    void walk_old_runs();
    void walk_rest();
    void walk_from(Slot start);
    bool follow_runs(Slot start);
    bool follow_links(Slot start);

    void walk_any_orientation();
    void walk_polyline(Slot start, int leave_by, bool closed);
    std::uint32_t follow_any_orientation(Slot start, int leave_by, bool closed);
    bool is_smaller_backwards(std::span<const Slot> slots, bool closed);

    Vector<std::uint32_t> position_{worker_.memory()};
    Vector<Slot> order_{worker_.memory()};  // from 1
    Vector<Slot> order_next_{worker_.memory()};
    Vector<std::uint64_t> breaks_{worker_.memory()};  // bit p: the walk does not go on from position p to p + 1
    Vector<WalkedContour> contours_{worker_.memory()};
    Vector<WalkedContour> old_contours_{worker_.memory()};  // the last plane's, while walking
    std::uint32_t ordered_ = 0;
    std::uint32_t filled_ = 0;  // of order_next_
    std::size_t changes_ = 0;   // links written, slots made and freed since the last walk
    bool by_links_ = false;     // this walk follows links rather than runs
    bool order_known_ = true;   // order_ can be patched
};

/// Room beyond the order's end that copy_run() may write and read.
inline constexpr std::size_t run_padding = 16;

/// Copies 64 bytes a step and writes beyond the end: most runs are short, and an exact length mispredicts.
inline void copy_run(const Slot* run, std::uint32_t length, Slot* to) {
    for (std::uint32_t i = 0; i < length; i += run_padding) {
        std::memcpy(to + i, run + i, run_padding * sizeof(Slot));
    }
}

/// positions[run[i]] = first + i.
inline void number_run(const Slot* run, std::uint32_t length, std::uint32_t first, std::uint32_t* positions) {
    std::uint32_t i = 0;
    for (; i + 4 <= length; i += 4) {
        positions[run[i]] = first + i;
        positions[run[i + 1]] = first + i + 1;
        positions[run[i + 2]] = first + i + 2;
        positions[run[i + 3]] = first + i + 3;
    }
    for (; i < length; ++i) {
        positions[run[i]] = first + i;
    }
}

}  // namespace lamella
