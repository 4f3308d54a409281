// Stage 6: which segment follows which, over an open-addressing hash map keyed by mesh edge (paper, Algorithm 4).
//
// The nodes are slots: the places where active mesh edges pierce the plane. A segment joins two of them; it leaves its
// source slot by port 1 and enters its target slot by port 0, with the solid on its left. An edge where more than two faces
// meet has one slot for each pair of segments that pass through it.
//
//          segment           segment
//       -----------> 0 [slot] 1 ----------->          links[2 * slot + port] = the port at the segment's other end
//
// All faces of an edge reach the sweep at the same plane, the first above the edge's lower end. An edge is therefore looked
// up at that plane only, and the map holds the edges that start at one plane: it is emptied by moving to the next epoch,
// stays within the cache, and never erases. Links are written when a triangle enters and when the sweep passes its middle
// vertex, and stay as they are from plane to plane; so does the order of the walk, which is patched where a link changed.
#pragma once

#include <cassert>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <utility>
#include <vector>

#include "6_contours/end_key.hpp"
#include "6_contours/pairing.hpp"
#include "base/parallel.hpp"

namespace lamella {

using Slot = std::uint32_t;
/// A slot's port: 2 * slot + port.
using PortRef = std::uint32_t;

inline constexpr std::uint32_t no_link = 0xFFFFFFFFU;
inline constexpr int target_port = 0;
inline constexpr int source_port = 1;

/// A segment that is being linked: ends[target_port] is where it enters, ends[source_port] where it leaves.
struct Link {
    PortRef ends[2];
};

/// A contour of the current plane: a run of LinkGraph::order().
struct WalkedContour {
    std::uint32_t begin;
    std::uint32_t count;
    bool closed;
    bool mixed;  ///< its segments do not all run the same way
};

class LinkGraph {
public:
    explicit LinkGraph(std::pmr::memory_resource* memory);

    /// Forgets all slots.
    void clear();
    /// Takes memory for `slots` slots at once rather than by growing.
    void reserve(std::size_t slots);

    // --- A plane's events: begin, attach both ends of each new link, settle, connect each, walk.

    /// Opens a new epoch of the map, sized for at most `attachments` ends.
    void begin_events(std::size_t attachments);

    /// The slot of `key`, made if need be.
    Slot find_or_add(const EndKey& key);

    /// Attaches an end of link `link` to `slot`. Returns the port's reference, which settle() may change where more than two
    /// meet.
    PortRef attach(Slot slot, int port, std::uint32_t link) {
        // Until it is connected, a new slot's port holds the link that came first.
        std::uint32_t& owner = links_[port][slot];
        if (owner == no_link) {
            owner = link;
        } else {
            crowd_.push_back({slot, link, port == source_port});
        }
        return 2 * slot + static_cast<unsigned>(port);
    }

    /// All ends are attached. Returns the slots made since begin_events().
    std::span<const Slot> end_attaching();

    /// Pairs what meets at the slots made. Where more than two ends meet, or two of the same sense, `order` sorts them
    /// counter-clockwise round the edge; further slots are made, `copied(to, from)` being called for each; and `links` is
    /// corrected.
    void settle(std::span<Link> links, FunctionRef<void(Slot, std::span<MeetingEnd>)> order,
                FunctionRef<void(Slot, Slot)> copied);

    /// Joins the two ports of `link`; the walk is patched at its source.
    void connect(const Link& link) {
        const PortRef source = link.ends[source_port];
        const PortRef target = link.ends[target_port];
        link_at(source) = target;
        link_at(target) = source;
        break_after(position_[source >> 1]);
        ++changes_;
    }

    /// The edge of `slot` ends below the plane; released() follows.
    void release(Slot slot);
    /// As many slots as that were released.
    void released(std::size_t count) noexcept {
        live_ -= count;
        changes_ += count;
    }

    /// Brings order() and contours() up to date. O(runs between changes + slots), and O(1) when nothing changed.
    void walk();

    // --- The plane as it stands

    std::span<const Slot> order() const noexcept { return {order_.data() + 1, ordered_}; }
    std::span<const WalkedContour> contours() const noexcept { return contours_; }
    const EndKey& key(Slot slot) const noexcept { return keys_[slot]; }
    /// Slots in use are below this; some below it are free.
    Slot slot_end() const noexcept { return slot_end_; }
    std::size_t live() const noexcept { return live_; }
    bool is_free(Slot slot) const noexcept { return flags_[slot] == unused; }

    /// Renumbers the slots 0, 1, 2, ... in walking order when fewer than half are in use, so that a plane costs what is
    /// active now. Calls moved(new_to_old) once if it did. Precondition: walk() has been called since the last change.
    bool compact(FunctionRef<void(std::span<const Slot> new_to_old)> moved);

private:
    static constexpr std::uint32_t no_position = 0;  // positions count from 1, so that marking it is harmless

    enum Flag : std::uint32_t {
        open_end = 1,
        mixed_target_is_source = 2,  // the end on port 0 leaves by it
        mixed_source_is_target = 4,  // the end on port 1 enters by it
        mixed = mixed_target_is_source | mixed_source_is_target,
        crowded = 8,  // more than two ends meet, or two of one sense
        unused = 16,  // no edge is here
    };

    struct Entry {
        std::uint32_t epoch;
        Slot slot;
    };

    void grow_table();
    /// The slot that the next new edge will take: the last freed, else one never used.
    Slot spare() const noexcept {
        return used_ < free_.size() ? free_[free_.size() - 1 - used_]
                                    : slot_end_ + (used_ - static_cast<Slot>(free_.size()));
    }
    void make(Slot slot);
    void settle_crowded(std::span<Link> links, FunctionRef<void(Slot, std::span<MeetingEnd>)> order,
                        FunctionRef<void(Slot, Slot)> copied);
    void settle_one(Slot slot, std::span<Link> links, FunctionRef<void(Slot, Slot)> copied);
    void seat(Slot slot, int port, const MeetingEnd& end, std::span<Link> links);
    void note_open(Slot slot);

    PortRef& link_at(PortRef ref) noexcept { return links_[ref & 1][ref >> 1]; }

    void break_after(std::uint32_t position) noexcept { breaks_[position >> 6] |= std::uint64_t{1} << (position & 63); }
    std::uint32_t next_break(std::uint32_t position) const noexcept;
    bool walked(Slot slot) const noexcept;
    void begin_order();
    void finish_order();
    void walk_sources();
    void walk_old_runs();
    void walk_old_starts();
    void walk_from(Slot start);
    bool follow_runs(Slot start);
    bool follow_links(Slot start);
    void walk_rest();
    void add_contour(std::uint32_t begin, bool closed, bool is_mixed);

    void walk_any_sense();
    void follow_any_sense(Slot start, int leave_by, bool closed);
    bool runs_backwards(std::uint32_t begin, bool closed) const;

    // slots
    std::pmr::vector<EndKey> keys_;
    std::pmr::vector<PortRef> links_[2];        // by port: what it is linked to
    std::pmr::vector<std::uint32_t> flags_;     // a byte would alias all that the loops keep in registers
    std::pmr::vector<std::uint32_t> position_;  // in order_, from 1
    std::pmr::vector<Slot> free_;
    Slot spare_ = 0;
    Slot capacity_ = 0;             // keys_.size()
    Slot used_ = 0;                 // slots made since begin_events(), from the end of free_ on
    std::pmr::vector<Slot> fresh_;  // they, after end_attaching()
    Slot slot_end_ = 0;
    std::size_t live_ = 0;
    std::size_t open_ = 0;   // slots with an open end
    std::size_t mixed_ = 0;  // slots that join two ends of the same sense

    // map
    std::pmr::vector<Entry> table_;
    std::size_t table_mask_ = 0;
    Slot table_limit_ = 0;  // new edges that it holds before it must grow
    int table_shift_ = 63;
    std::uint32_t epoch_ = 0;

    // meetings of more than two
    struct Crowded {
        Slot slot;
        std::uint32_t link;
        bool is_source;
    };
    std::pmr::vector<Crowded> crowd_;
    std::pmr::vector<MeetingEnd> meeting_;
    Pairing pairing_;

    // walk
    std::pmr::vector<Slot> order_;
    std::pmr::vector<Slot> order_next_;
    std::pmr::vector<std::uint64_t> breaks_;  // bit p: the walk does not go on from position p to p + 1
    std::pmr::vector<WalkedContour> contours_;
    std::pmr::vector<std::uint32_t> old_starts_;  // positions at which the last plane's contours began
    std::pmr::vector<std::uint8_t> leave_by_;     // of a walk in any sense: the port by which each slot was left
    std::uint32_t ordered_ = 0;
    std::uint32_t filled_ = 0;  // of order_next_
    std::size_t changes_ = 0;   // links written and slots freed since the last walk
    bool chase_ = false;        // this walk follows links rather than runs
    bool order_known_ = true;   // order_ can be patched
};

/// Nothing predicts whether an edge is met for the first or the second time, so no branch asks: the key is written to the
/// spare slot, which is compared with itself if the edge is new, and is taken by adding 0 or 1.
inline Slot LinkGraph::find_or_add(const EndKey& key) {
    const Slot new_slot = spare_;
    if (new_slot >= capacity_) {
        reserve(new_slot + new_slot / 2 + 1024);
    }
    EndKey* const keys = keys_.data();
    keys[new_slot] = key;
    links_[target_port][new_slot] = no_link;
    links_[source_port][new_slot] = no_link;
    Entry* const table = table_.data();
    for (std::size_t i = hash_key(key) >> table_shift_;; i = (i + 1) & table_mask_) {
        Entry& place = table[i];
        const Entry entry = place;
        // All bits set if the entry is of another epoch; compilers turn a comparison back into a branch.
        const std::uint32_t other = entry.epoch ^ epoch_;
        const std::uint32_t is_new = 0U - ((other | (0U - other)) >> 31);
        const Slot slot = entry.slot ^ ((entry.slot ^ new_slot) & is_new);
        if (keys[slot] == key) {
            place = {epoch_, slot};
            used_ += is_new & 1;
            spare_ = spare();
            if (used_ == table_limit_) {
                grow_table();
            }
            return slot;
        }
    }
}

inline void LinkGraph::release(Slot slot) {
    break_after(position_[slot]);
    position_[slot] = no_position;
    const std::uint32_t flags = std::exchange(flags_[slot], unused);
    if (flags != 0) {
        open_ -= (flags & open_end) != 0 ? 1 : 0;
        mixed_ -= (flags & mixed) != 0 ? 1 : 0;
    }
    free_.push_back(slot);
}

}  // namespace lamella
