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
// up at that plane only, and the map holds the edges that start at one plane: it is cleared for each, stays within the
// cache, and never erases. Links are written when a triangle enters and when the sweep passes its middle vertex, and stay as
// they are from plane to plane; so does the order of the walk, which is patched where a link changed.
//
// New edges take the slots of those that ended last; where a plane has far fewer edges than one before it, slots are closed
// up.
#pragma once

#include <cassert>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/contours/mesh_edge.hpp"
#include "slicing/contours/pairing.hpp"
#include "slicing/planes/plane_set.hpp"

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

/// A vector left to itself takes twice the memory to grow by one element; these are large, one each a thread.
template <class T>
void resize_exactly(Vector<T>& array, std::size_t size, const T& value = {}) {
    array.reserve(size);
    array.resize(size, value);
}

/// array[i] = what was array[new_to_old[i]], by way of `scratch`.
template <class T>
void gather_slots(Vector<T>& array, std::span<const Slot> new_to_old, Vector<std::uint64_t>& scratch) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t words = (new_to_old.size() * sizeof(T) + 7) / 8;
    if (scratch.size() < words) {
        scratch.resize(words);
    }
    auto* to = reinterpret_cast<unsigned char*>(scratch.data());
    for (const Slot old : new_to_old) {
        std::memcpy(to, &array[old], sizeof(T));
        to += sizeof(T);
    }
    std::memcpy(static_cast<void*>(array.data()), scratch.data(), new_to_old.size() * sizeof(T));
}

class LinkGraph {
public:
    explicit LinkGraph(const Memory* memory);

    /// Forgets all slots.
    void clear();
    /// Takes memory for `slots` slots at once rather than by growing.
    void reserve(std::size_t slots);

    // --- A plane's events: release what ends, attach both ends of each new link, settle, connect, walk.

    /// Frees the slots of the edges that end at `plane`: it is the first one above them.
    void release_ended(PlaneIndex plane);

    class Attaching;
    /// Empties the map, which is sized for at most `attachments` ends.
    Attaching begin_attaching(std::size_t attachments);

    /// All ends are attached, which are `attachments`; fresh() are the slots made for them.
    void end_attaching(const Attaching& attaching, std::size_t attachments);

    /// Pairs what meets at the slots made. Where more than two ends meet, or two of the same sense, `order` sorts them
    /// counter-clockwise round the edge; further slots are made, `copied(to, from)` being called for each; `links` is
    /// corrected, and true returned.
    bool settle(std::span<Link> links, FunctionRef<void(Slot, std::span<MeetingEnd>)> order,
                FunctionRef<void(Slot, Slot)> copied);

    /// Joins the two ports of each link; the walk will be patched at their sources.
    void connect(std::span<const Link> links);

    /// Brings order() and contours() up to date. O(runs between changes + slots), and O(1) when nothing changed.
    void walk();

    // --- The plane as it stands

    std::span<const Slot> order() const noexcept { return {order_.data() + 1, ordered_}; }
    std::span<const WalkedContour> contours() const noexcept { return contours_; }
    const MeshEdge& edge(Slot slot) const noexcept { return edges_[slot]; }
    /// Slots in use are below this; some below it are free.
    Slot slot_end() const noexcept { return slot_end_; }
    /// Slots made since begin_attaching().
    std::span<const Slot> fresh() const noexcept { return {free_.data() + free_count_, fresh_count_}; }
    /// Slots are below this, in use or not.
    std::size_t capacity() const noexcept { return edges_.size(); }
    std::size_t live() const noexcept { return capacity() - free_count_; }
    bool is_free(Slot slot) const noexcept { return ends_[slot] == no_plane; }

    /// Renumbers the slots 0, 1, 2, ... in walking order when many have ended, so that a plane costs what is active now.
    /// Calls move(new_to_old) once if it does. Precondition: walk() has been called since the last change.
    bool compact(FunctionRef<void(std::span<const Slot> new_to_old)> move);
    /// While compact() calls move: what a port becomes.
    PortRef moved(PortRef ref) const noexcept { return 2 * (position_[ref >> 1] - 1) + (ref & 1); }

private:
    static constexpr std::uint32_t no_position = 0;  // positions count from 1, so that marking it is harmless
    static constexpr PlaneIndex no_plane = 0xFFFFFFFFU;
    static constexpr std::size_t slots_per_change = 3;  // with fewer, runs are too short to copy

    enum Flag : std::uint16_t {
        open_end = 1,
        mixed_target_is_source = 2,  // the end on port 0 leaves by it
        mixed_source_is_target = 4,  // the end on port 1 enters by it
        mixed = mixed_target_is_source | mixed_source_is_target,
        crowded = 8,  // more than two ends meet, or two of one sense
    };

    /// A stretch of a contour, from `head` to the next piece's; see link_pieces.cpp.
    struct Piece {
        Slot head;
        PortRef cut;  ///< whose link led to it
        Slot* slots;
        std::uint32_t count;  ///< 0 once it is part of a contour
        std::uint32_t next;   ///< the piece that follows
    };
    static constexpr PortRef first_mark = 0xF0000000U;  // of links: no port, but the piece of this number less the mark

    static constexpr Slot no_slot = 0xFFFFFFFFU;

    void clear_table(std::size_t size);
    void grow(std::uint32_t made);
    void take_spares(std::uint32_t count);
    void free_all_from(Slot first);
    Slot add_copy(Slot slot);
    void settle_crowded(std::span<Link> links, FunctionRef<void(Slot, std::span<MeetingEnd>)> order,
                        FunctionRef<void(Slot, Slot)> copied);
    void settle_one(Slot slot, std::span<Link> links, FunctionRef<void(Slot, Slot)> copied);
    void seat(Slot slot, int port, const MeetingEnd& end, std::span<Link> links);
    void note_open(Slot slot);
    bool most_changed() const noexcept { return changes_ * slots_per_change > live(); }

    bool has(Slot slot, int port) const noexcept { return links_[2 * slot + static_cast<unsigned>(port)] != no_link; }

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
    void walk_pieces();
    void add_piece(std::uint32_t begin, std::uint32_t end);
    void walk_four_at_once();
    void join_pieces();
    void add_contour(std::uint32_t begin, bool closed, bool is_mixed);

    void walk_any_sense();
    void follow_any_sense(Slot start, int leave_by, bool closed);
    bool runs_backwards(std::uint32_t begin, bool closed) const;

    const Kernels& kernels_;

    // slots
    Vector<MeshEdge> edges_;
    Vector<PortRef> links_;           // by port: what it is linked to
    Vector<PlaneIndex> ends_;         // the plane at which the edge will have ended; no_plane: the slot is free
    Vector<std::uint16_t> flags_;     // 0 if free. A byte would alias all that the loops keep in registers
    Vector<std::uint32_t> position_;  // in order_, from 1; no_position if free or new
    Vector<Slot> free_;               // a stack; those never used are at its bottom, highest first
    Vector<std::uint64_t> moving_;    // scratch: an array on its way to new slots
    std::size_t free_count_ = 0;
    std::size_t fresh_count_ = 0;  // they are still above the top of the stack
    Slot slot_end_ = 0;
    std::size_t open_ = 0;   // slots with an open end
    std::size_t mixed_ = 0;  // slots that join two ends of the same sense

    // map
    Vector<Slot> table_;  // no_slot: nothing is there
    std::size_t table_mask_ = 0;
    std::uint32_t limit_ = 0;  // new edges that there is room for
    int table_shift_ = 63;

    // meetings of more than two
    struct Crowded {
        Slot slot;
        std::uint32_t link;
        bool is_source;
    };
    Vector<Crowded> crowd_;
    Vector<MeetingEnd> meeting_;
    Pairing pairing_;

    // walk
    Vector<Slot> order_;
    Vector<Slot> order_next_;
    Vector<std::uint64_t> breaks_;  // bit p: the walk does not go on from position p to p + 1
    Vector<WalkedContour> contours_;
    Vector<WalkedContour> old_contours_;  // the last plane's
    Vector<Piece> pieces_;
    Vector<Slot> lanes_;             // what pieces are walked into
    Vector<std::uint8_t> leave_by_;  // of a walk in any sense: the port by which each slot was left
    std::uint32_t ordered_ = 0;
    std::uint32_t filled_ = 0;  // of order_next_
    std::size_t changes_ = 0;   // links written, slots made and freed since the last walk
    bool one_sided_ = false;    // some new slot has an end on one side only
    bool chase_ = false;        // this walk follows links rather than runs
    bool order_known_ = true;   // order_ can be patched
};

/// The ends of a plane's new links on their way to their slots. What each of them changes is a member here and not of the
/// graph: it stays in registers, where the graph's would be loaded again after every store to an array.
class LinkGraph::Attaching {
public:
    explicit Attaching(LinkGraph& graph) noexcept : graph_(graph) { load(); }

    /// The slot of `edge`, made if need be, which will have ended at plane `end`.
    ///
    /// Nothing predicts whether an edge is met for the first or the second time, so no branch asks: the edge is written to
    /// the spare slot, which is compared with itself if the edge is new, and is taken by adding 0 or 1.
    Slot find_or_add(const MeshEdge& edge, PlaneIndex end) {
        if (made_ == limit_) {
            graph_.grow(made_);
            load();
        }
        const Slot spare = *(free_top_ - made_);
        edges_[spare] = edge;
        ends_[spare] = end;
        links_[2 * spare + target_port] = no_link;
        links_[2 * spare + source_port] = no_link;
        for (std::size_t i = edge.hash() >> shift_;; i = (i + 1) & mask_) {
            const Slot found = table_[i];
            // All ones if nothing is there: slots have 31 bits. Reckoned, as compilers turn a comparison into a branch.
            const Slot is_new = static_cast<Slot>(static_cast<std::int32_t>(found) >> 31);
            const Slot slot = found ^ ((found ^ spare) & is_new);
            if (edges_[slot] == edge) {
                table_[i] = slot;
                made_ -= is_new;
                return slot;
            }
        }
    }

    /// Attaches an end of link `link` to `slot`. Returns the port's reference, which settle() may change where more than two
    /// meet.
    PortRef attach(Slot slot, int port, std::uint32_t link) {
        // Until it is connected, a new slot's port holds the link that came first.
        const PortRef ref = 2 * slot + static_cast<unsigned>(port);
        if (links_[ref] == no_link) {
            links_[ref] = link;
        } else {
            graph_.crowd_.push_back({slot, link, port == source_port});
        }
        return ref;
    }

private:
    friend class LinkGraph;

    void load() noexcept {
        free_top_ = graph_.free_.data() + graph_.free_count_ - 1;
        edges_ = graph_.edges_.data();
        ends_ = graph_.ends_.data();
        links_ = graph_.links_.data();
        table_ = graph_.table_.data();
        mask_ = graph_.table_mask_;
        shift_ = graph_.table_shift_;
        limit_ = graph_.limit_;
    }

    LinkGraph& graph_;
    const Slot* free_top_ = nullptr;
    MeshEdge* edges_ = nullptr;
    PlaneIndex* ends_ = nullptr;
    PortRef* links_ = nullptr;
    Slot* table_ = nullptr;
    std::size_t mask_ = 0;
    int shift_ = 0;
    std::uint32_t made_ = 0;
    std::uint32_t limit_ = 0;
};

}  // namespace lamella
