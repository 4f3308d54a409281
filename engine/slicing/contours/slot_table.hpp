// The slots of a plane: the places where active mesh edges pierce it, and the segments that join them, over an
// open-addressing hash map keyed by mesh edge (paper, Algorithm 4).
//
// A segment leaves its source slot by port 1 and enters its target slot by port 0, with the solid on its left. An edge where
// more than two faces meet has one slot for each pair of segments that pass through it.
//
//          segment           segment
//       -----------> 0 [slot] 1 ----------->          port 2 * slot + port, across: the port at the segment's other end
//
// All faces of an edge reach the sweep at the same plane, the first above the edge's lower end. An edge is therefore looked
// up at that plane only, and the map holds the edges that start at one plane: it is cleared for each, stays within the
// cache, and never erases. The links themselves stay from plane to plane.
//
// New edges take the slots of those that ended last:
//
//     free_      [ never used, highest first | ended, last on top | fresh ]
//                                                                 ^ free_count_: the top of the stack
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "lamella/result.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

using Slot = std::uint32_t;
/// A slot's port: 2 * slot + port.
using PortRef = std::uint32_t;
/// A segment's number among those that a plane's events link.
using LinkIndex = std::uint32_t;

inline constexpr Slot no_slot = 0xFFFFFFFFU;
inline constexpr PortRef no_port = 0xFFFFFFFFU;
inline constexpr LinkIndex no_link = 0xFFFFFFFFU;
inline constexpr int target_port = 0;
inline constexpr int source_port = 1;

constexpr PortRef port_of(Slot slot, int port) noexcept {
    return 2 * slot + static_cast<PortRef>(port);
}
constexpr Slot slot_of(PortRef ref) noexcept {
    return ref >> 1;
}

/// A segment that is being linked: ends[target_port] is where it enters, ends[source_port] where it leaves.
struct Link {
    PortRef ends[2];
    std::uint32_t record = 0;  ///< of a sweep: the triangle's
};

/// The content of a port. The two share memory, as a second array adds 2 % of cache misses on dense meshes:
///
///     release_ended()   end_attaching()    settle()            connect()
///     |                 |                  |                   |
///     |    ports of fresh slots: first_link, or no_link        |    across, or no_port
///     |    ports of all other slots: across, or no_port        |
union Port {
    LinkIndex first_link;  ///< the link whose end came first
    PortRef across;        ///< the port at the other end of its segment
};

/// To at least `size`. A vector left to itself takes twice the memory to grow by one element; these are large, one each a
/// thread. In stretches, so that a stop that is asked for meanwhile is noticed: pages that are touched first cost more than
/// their bytes. What is thrown leaves the array somewhat larger.
template <class T>
void grow_exactly(Vector<T>& array, std::size_t size, StopPace& pace, const T& value = {}) {
    constexpr std::size_t words = (sizeof(T) + 7) / 8;
    array.reserve(size);
    pace.in_stretches(array.size(), size, words, [&](std::size_t, std::size_t end) { array.resize(end, value); });
}

/// An end of link `link` at an edge.
struct MeetingEnd {
    Slot slot;
    LinkIndex link;
    bool is_source;  ///< goes out from the edge
};

/// A face at a mesh edge.
struct FaceAtEdge {
    GridVertex apex;  ///< its vertex off the edge
    std::uint32_t triangle;
    MeetingEnd end;
};

/// Sorts the faces of the edge from `lower` to `upper` counter-clockwise seen from above, starting at the smallest apex. At
/// equal angles those that come in are first (they close the solid before them), by apex, then those that go out, in the
/// opposite order, so that brackets nest. Faces that are the same in all of this are interchangeable; the triangle's index
/// only keeps each of them in the same place at all its edges. Exact.
void sort_round_edge(const GridVertex& lower, const GridVertex& upper, std::span<FaceAtEdge> faces);

/// Pairs the ends that meet at one edge by orientation, then by angle: see slot_table.cpp.
class Pairing {
public:
    static constexpr std::uint32_t no_partner = 0xFFFFFFFFU;

    explicit Pairing(const Memory* memory) noexcept : pairs_(memory), unopened_(memory), unclosed_(memory) {}

    /// The pairs of `ends`, which lie counter-clockwise, by index. Where the orientations of two differ, the one that comes
    /// in is first. The second of the last may be no_partner. O(ends).
    std::span<const std::array<std::uint32_t, 2>> match(std::span<const MeetingEnd> ends);

private:
    Vector<std::array<std::uint32_t, 2>> pairs_;
    Vector<std::uint32_t> unopened_;  // ends that close a bracket which none opens before
    Vector<std::uint32_t> unclosed_;
};

class SlotTable {
public:
    explicit SlotTable(Worker& worker) noexcept : worker_(worker) {}

    /// Frees all slots.
    void clear();
    /// Takes memory for `slots` slots at once rather than by growing.
    void reserve(std::size_t slots);

    // --- A plane's events, in this order

    /// Frees the slots of the edges that end at `plane`, the first one above them, and returns these slots.
    std::span<const Slot> release_ended(PlaneIndex plane);

    class Attaching;
    /// Empties the map, which is sized for at most `attachments` ends.
    Attaching begin_attaching(std::size_t attachments);
    /// All ends are attached, which are `attachments`; fresh() are the slots made for them.
    void end_attaching(const Attaching& attaching, std::size_t attachments);

    /// Sorts the ends that meet at a slot counter-clockwise round its edge.
    using SortEnds = FunctionRef<void(std::span<MeetingEnd>)>;
    /// Pairs what meets at the fresh slots where more than two ends do, or two of one orientation. Marks open ends, and
    /// corrects `links` where it gives an end another slot; true if there is such an end. Precondition: end_attaching().
    bool settle(std::span<Link> links, SortEnds sort_ends);

    /// Joins the two ports of each link.
    void connect(std::span<const Link> links) noexcept;

    // --- Marks of slots that are not simply passed through

    enum Flag : std::uint16_t {
        open_end = 1,
        mixed_target_is_source = 2,  // the end on port 0 leaves by it
        mixed_source_is_target = 4,  // the end on port 1 enters by it
        mixed = mixed_target_is_source | mixed_source_is_target,
        irregular = 8,  // more than two ends meet, or two of one orientation
    };
    bool has_any(Slot slot, unsigned flags) const noexcept { return (flags_[slot] & flags) != 0; }
    /// Slots with an open end, and slots that join two ends of the same orientation.
    std::size_t open_count() const noexcept { return open_; }
    std::size_t mixed_count() const noexcept { return mixed_; }

    // --- The plane as it stands

    const MeshEdge& edge(Slot slot) const noexcept { return edges_[slot]; }
    bool is_free(Slot slot) const noexcept { return ends_[slot] == no_plane; }
    bool is_linked(Slot slot, int port) const noexcept { return ports_[port_of(slot, port)].across != no_port; }
    const Port* ports() const noexcept { return ports_.data(); }
    /// Slots made since begin_attaching().
    std::span<const Slot> fresh() const noexcept { return {free_.data() + free_count_, fresh_count_}; }
    /// Slots in use are below this; some below it are free.
    Slot slot_end() const noexcept { return slot_end_; }
    /// Slots are below this, in use or not.
    std::size_t capacity() const noexcept { return edges_.size(); }
    std::size_t live() const noexcept { return capacity() - free_count_; }

protected:
    Worker& worker_;

private:
    static constexpr PlaneIndex no_plane = 0xFFFFFFFFU;

    void take_spares(std::uint32_t count);
    void clear_map(std::size_t size);
    void grow_map(std::uint32_t made);
    Slot add_copy(Slot slot);
    void disconnect(Slot slot) noexcept;
    void add_flag(Slot slot, Flag flag) noexcept;
    void mark_open(Slot slot) noexcept;
    void gather_first_ends();
    void seat(Slot slot, int port, const MeetingEnd& end, std::span<Link> links) noexcept;
    void seat_pairs(std::span<const MeetingEnd> ends, std::span<Link> links);

    const Kernels& kernels_ = best_of(kernel_forms(), worker_.instructions());

    // slots
    Vector<MeshEdge> edges_{worker_.memory()};
    Vector<Port> ports_{worker_.memory()};       // see PortRef
    Vector<PlaneIndex> ends_{worker_.memory()};  // the plane at which the edge will have ended; no_plane: the slot is free
    Vector<std::uint16_t> flags_{worker_.memory()};  // 0 if free. A byte would alias all that the loops keep in registers
    Vector<Slot> free_{worker_.memory()};
    std::size_t free_count_ = 0;
    std::size_t fresh_count_ = 0;
    Slot slot_end_ = 0;
    std::size_t open_ = 0;
    std::size_t mixed_ = 0;

    // the map, of the edges that start at this plane
    Vector<Slot> map_{worker_.memory()};  // no_slot: nothing is there
    std::size_t map_mask_ = 0;
    int map_shift_ = 63;
    std::uint32_t map_limit_ = 0;  // edges that there is room for

    // irregular edges
    Vector<MeetingEnd> late_ends_{worker_.memory()};  // whose port was taken when they came, since begin_attaching()
    Pairing pairing_{worker_.memory()};
    bool one_sided_ = false;  // some fresh slot has an end on one side only
};

/// The ends of a plane's new links on their way to their slots. What each of them changes is a member here and not of the
/// table: it stays in registers, where the table's would be loaded again after every store to an array.
class SlotTable::Attaching {
public:
    explicit Attaching(SlotTable& table) noexcept : table_(table) { load(); }

    /// The slot of `edge`, made if need be. It will have ended at plane `end`.
    ///
    /// An edge is met for the first time as often as for the second, which no branch predictor foresees. So there is no
    /// branch: the edge is written to the spare slot, which is compared with itself if the edge is new, and is taken by
    /// adding 0 or 1.
    Slot find_or_add(const MeshEdge& edge, PlaneIndex end) {
        if (made_ == limit_) {
            table_.grow_map(made_);
            load();
        }
        const Slot spare = *(free_top_ - made_);
        edges_[spare] = edge;
        ends_[spare] = end;
        ports_[port_of(spare, target_port)].first_link = no_link;
        ports_[port_of(spare, source_port)].first_link = no_link;
        for (std::size_t i = edge.hash() >> shift_;; i = (i + 1) & mask_) {
            const Slot found = map_[i];
            // All ones if nothing is there: slots have 31 bits. Arithmetic, as compilers turn a comparison into a branch.
            const Slot is_new = static_cast<Slot>(static_cast<std::int32_t>(found) >> 31);
            const Slot slot = found ^ ((found ^ spare) & is_new);
            if (edges_[slot] == edge) {
                map_[i] = slot;
                made_ -= is_new;
                return slot;
            }
        }
    }

    /// Attaches an end of link `link` to `slot`. Returns the port, which settle() changes where more than two ends
    /// meet.
    PortRef attach(Slot slot, int port, LinkIndex link) {
        const PortRef ref = port_of(slot, port);
        if (ports_[ref].first_link == no_link) {
            ports_[ref].first_link = link;
        } else {
            table_.late_ends_.push_back({slot, link, port == source_port});
        }
        return ref;
    }

private:
    friend class SlotTable;

    void load() noexcept {
        free_top_ = table_.free_.data() + table_.free_count_ - 1;
        edges_ = table_.edges_.data();
        ends_ = table_.ends_.data();
        ports_ = table_.ports_.data();
        map_ = table_.map_.data();
        mask_ = table_.map_mask_;
        shift_ = table_.map_shift_;
        limit_ = table_.map_limit_;
    }

    SlotTable& table_;
    const Slot* free_top_ = nullptr;
    MeshEdge* edges_ = nullptr;
    PlaneIndex* ends_ = nullptr;
    Port* ports_ = nullptr;
    Slot* map_ = nullptr;
    std::size_t mask_ = 0;
    int shift_ = 0;
    std::uint32_t made_ = 0;
    std::uint32_t limit_ = 0;
};

/// By port: the origin of the segment there, as its facet runs.
struct SlotOrigins {
    PointOrigin by_port[2];
};

}  // namespace lamella
