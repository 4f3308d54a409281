// Which segment of a plane follows which: the slot table, what happens where more than two segments meet, and the walk.
//
//     slot_table.hpp    edges, links, the edge map       what a plane's events change
//     meetings.hpp      pairing at irregular edges       a rare step between attaching and connecting
//     walker.hpp        order and contours               patched from plane to plane
#pragma once

#include <cassert>
#include <span>

#include "base/parallel.hpp"
#include "slicing/contours/pairing.hpp"
#include "slicing/contours/slot_table.hpp"
#include "slicing/contours/walker.hpp"

namespace lamella {

class LinkGraph {
public:
    explicit LinkGraph(Worker& worker) : worker_(worker) {}
    LinkGraph(const LinkGraph&) = delete;  // the walker refers to the slots
    LinkGraph& operator=(const LinkGraph&) = delete;

    /// Forgets all slots.
    void clear() {
        walker_.clear();
        slots_.clear();
    }
    /// Takes memory for `slots` slots at once rather than by growing.
    void reserve(std::size_t slots) { slots_.reserve(slots); }

    // --- A plane's events, in this order

    /// Frees the slots of the edges that end at `plane`: it is the first one above them.
    void release_ended(PlaneIndex plane) { walker_.note_ended(slots_.release_ended(plane)); }

    /// For at most `attachments` ends of new links.
    SlotTable::Attaching begin_attaching(std::size_t attachments) { return slots_.begin_attaching(attachments); }
    /// All ends are attached, which are `attachments`.
    void end_attaching(const SlotTable::Attaching& attaching, std::size_t attachments) {
        slots_.end_attaching(attaching, attachments);
    }

    /// See Meetings::settle().
    bool settle(std::span<Link> links, Meetings::Order order, Meetings::Copied copied) {
        return meetings_.settle(slots_, links, order, copied);
    }

    /// Joins the two ports of each link.
    void connect(std::span<const Link> links) {
        constexpr std::size_t link_work = 2;
        worker_.in_stretches(0, links.size(), link_work,
                             [&](std::size_t begin, std::size_t end) { slots_.connect(links.subspan(begin, end - begin)); });
        walker_.note_connected(links, slots_.fresh().size());
    }

    /// Brings order() and contours() up to date.
    void walk() { walker_.walk(); }

    // --- The plane as it stands

    std::span<const Slot> order() const noexcept { return walker_.order(); }
    std::span<const WalkedContour> contours() const noexcept { return walker_.contours(); }
    const MeshEdge& edge(Slot slot) const noexcept { return slots_.edge(slot); }
    /// The port of `slot` from which a segment leads to `next`, whichever way its facet runs.
    PortRef port_towards(Slot slot, Slot next) const noexcept {
        const PortRef source = port_of(slot, source_port);
        const PortRef across = slots_.ports()[source].across;
        return across != no_port && slot_of(across) == next ? source : port_of(slot, target_port);
    }
    /// True if the facet of the segment at a port runs from there.
    bool runs_from(PortRef ref) const noexcept {
        return static_cast<int>(ref & 1) == source_port ? !slots_.has_any(slot_of(ref), SlotTable::mixed_source_is_target)
                                                        : slots_.has_any(slot_of(ref), SlotTable::mixed_target_is_source);
    }
    /// Slots made since begin_attaching().
    std::span<const Slot> fresh() const noexcept { return slots_.fresh(); }
    /// Slots in use are below this; some below it are free.
    Slot slot_end() const noexcept { return slots_.slot_end(); }
    /// Slots are below this, in use or not.
    std::size_t capacity() const noexcept { return slots_.capacity(); }
    std::size_t live() const noexcept { return slots_.live(); }

    /// Renumbers the slots 0, 1, 2, ... in walking order when many have ended, so that a plane costs what is active now.
    /// Calls move(new_to_old) once if it does. Precondition: walk() has been called since the last change.
    bool compact(FunctionRef<void(std::span<const Slot> new_to_old)> move) {
        assert(!walker_.has_changes());
        if (!slots_.is_sparse()) {
            return false;
        }
        const std::span<const Slot> new_to_old = order();
        slots_.renumber(new_to_old, [this](PortRef ref) { return moved(ref); });
        move(new_to_old);
        walker_.renumber();
        slots_.free_from(static_cast<Slot>(order().size()));
        return true;
    }
    /// While compact() calls move: what a port becomes.
    PortRef moved(PortRef ref) const noexcept { return port_of(walker_.place_of(slot_of(ref)), static_cast<int>(ref & 1)); }

private:
    Worker& worker_;
    SlotTable slots_{worker_};
    Meetings meetings_{worker_.memory()};
    Walker walker_{worker_, slots_};
};

}  // namespace lamella
