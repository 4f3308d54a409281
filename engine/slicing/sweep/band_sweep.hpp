// The sweep of one band (Algorithm 1), which builds the contours of each plane as it goes (Algorithm 4).
//
// A crossed triangle links its long edge to one of its short edges, and changes to the other at its middle vertex:
//
//         upper
//          |`.           planes above `middle` link the long edge and the upper short one
//     long |  `.
//          |  middle     one event: the link is written anew
//          |  .'
//          |.'           planes below link the long edge and the lower short one
//         lower          the triangle enters at the first plane above
//
// Between events a triangle costs nothing. A plane costs one interpolation per active edge and one copy along the contours.
#pragma once

#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/slice.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/layer/layer_builder.hpp"

namespace lamella {

/// Thread time by phase, in ticks of sampled layers.
struct SweepTicks : LayerTicks {
    std::uint64_t sweep = 0;
    std::uint64_t contours = 0;
};

/// The mesh edges that pierce the current plane, as lines, by slot.
class ActiveEdges {
public:
    explicit ActiveEdges(const Memory* memory) : x_(memory), y_(memory), z_(memory), slope_x_(memory), slope_y_(memory) {}

    /// Makes room for at least `slots` slots.
    void reserve(std::size_t slots, StopPace& pace) {
        const std::size_t padded = (slots + padded_count - 1) / padded_count * padded_count;
        grow_exactly(y_, padded, pace);
        grow_exactly(z_, padded, pace);
        grow_exactly(slope_x_, padded, pace);
        grow_exactly(slope_y_, padded, pace);
        grow_exactly(x_, padded, pace);  // the last: arrays that could not grow have the capacity that they had
    }
    std::size_t capacity() const noexcept { return x_.size(); }

    void put(Slot slot, const MeshEdge& edge) {
        const GridVertex lower = edge.lower();
        const GridVertex upper = edge.upper();
        const double rise = static_cast<double>(upper.z) - lower.z;
        x_[slot] = lower.x;
        y_[slot] = lower.y;
        z_[slot] = lower.z;
        slope_x_[slot] = (static_cast<double>(upper.x) - lower.x) / rise;
        slope_y_[slot] = (static_cast<double>(upper.y) - lower.y) / rise;
    }

    /// From slot `first` on.
    EdgeArrays arrays(std::size_t first) const noexcept {
        return {x_.data() + first, y_.data() + first, z_.data() + first, slope_x_.data() + first, slope_y_.data() + first};
    }

private:
    Vector<std::int32_t> x_, y_, z_;
    Vector<double> slope_x_, slope_y_;
};

/// One per thread; scratch is kept from band to band.
class BandSweep {
public:
    BandSweep(const Memory* memory, InstructionSet instructions) : worker_(memory, instructions) {}

    /// One layer in so many is timed: reading clocks at every layer would slow small ones.
    static constexpr PlaneIndex timing_stride = 8;

    /// Appends the band's layers to `out`. Throws std::bad_alloc, and Stopped where `stop` asks for it: at every layer, and
    /// within large ones.
    void run(const Band& band, std::span<const std::uint32_t> seeds, const Buckets& buckets, const PlaneSet& planes,
             ContourForm form, const StopCheck& stop, BandOutput& out);

    /// Applies to bands swept after this call; `rules` must stay until then.
    void set_rules(const LayerRules& rules) noexcept { layers_.rules = &rules; }

    /// The most segments of a plane since construction: the size of the scratch.
    std::size_t most_segments() const noexcept { return most_segments_; }

    /// Time since the last call.
    SweepTicks take_ticks() noexcept;

private:
    class Events;
    /// A link of a triangle that another one stands for.
    struct Substitute {
        std::uint32_t link;
        std::uint32_t record;
    };
    /// A triangle whose middle vertex lies above the plane.
    struct Pending {
        std::uint32_t record;
        PortRef long_end;
    };

    void begin(const Band& band, const Buckets& buckets);
    void enter_active(PlaneIndex plane, std::span<const std::uint32_t> seeds);
    void take_events(PlaneIndex plane, std::span<const std::uint32_t> seeds, std::uint32_t list_begin);
    std::span<const Pending> take_passing(PlaneIndex plane);
    void reserve_events(std::size_t links, std::size_t middles);
    void link_events(PlaneIndex plane);
    void sort_meeting(std::span<MeetingEnd> ends);
    void note_substitutes();
    void put_origins(PlaneIndex plane);
    PointOrigin origin_of_link(std::uint32_t link, PlaneIndex plane) const noexcept;
    PointOrigin origin_by(std::uint32_t record, const Link& link) const noexcept;
    void correct_pending();
    void pierce(std::int32_t z);

    Worker worker_;
    const Kernels& kernels_ = best_of(kernel_forms(), worker_.instructions());
    LinkGraph graph_{worker_};
    ActiveEdges edges_{worker_.memory()};
    LayerBuilder layers_{worker_};
    Band band_{};
    const Buckets* buckets_ = nullptr;
    std::size_t most_segments_ = 0;
    Vector<Link> links_{worker_.memory()};  // of the plane's events: triangles that pass their middle vertex, then ...
    std::uint32_t link_count_ = 0;
    std::uint32_t first_entering_ = 0;  // ... from here on, triangles that enter
    Vector<Pending> pending_{worker_.memory()};
    Vector<PlaneIndex> pending_plane_{worker_.memory()};  // the first plane above each one's middle vertex
    std::uint32_t pending_count_ = 0;
    std::uint32_t first_new_pending_ = 0;
    Vector<Pending> passing_{worker_.memory()};           // scratch: those that pass at a plane, ...
    Vector<std::uint32_t> passing_at_{worker_.memory()};  // ... and where they were
    Vector<std::uint32_t> active_{worker_.memory()};      // assembled form: records that the plane cuts
    Vector<FaceAtEdge> faces_{worker_.memory()};
    Vector<Point> points_{worker_.memory()};  // by slot
    bool with_origins_ = false;
    Vector<SlotOrigins> origins_{worker_.memory()};     // by slot
    Vector<Substitute> substitutes_{worker_.memory()};  // of the plane's links
    SweepTicks ticks_;
};

}  // namespace lamella
