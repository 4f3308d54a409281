// A plane with so many segments that all threads work on it together; few of them are shared with its neighbours.
//
// Each segment is linked to the one that leaves the edge it enters. Ends meet in one open-addressing table, by
// compare-and-swap: the first end of an edge is entered, the second links both. Contours are then walked in pieces, from one
// segment in 64 to the next of those. The pieces are put together, and walked again to write their points in place:
//
//     segments     64 -> 7 -> 130 -> 192 -> 3 -> 65 -> 64      two pieces: 64 7 130 | 192 3 65
//
// Only planes where each edge has one face on either side are built here; BandSweep builds those with open or irregular
// edges.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/system/processor.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/layer/layer_builder.hpp"

namespace lamella {

class WidePlane {
public:
    WidePlane(const Memory* memory, InstructionSet instructions, const Parallel& parallel, const LayerRules& rules)
        : worker_(memory, parallel.stop(), instructions), parallel_(parallel) {
        layer_.rules = &rules;
        layer_.ticks = &ticks_;
    }

    /// Appends the layer of `plane` to `out`; `seeds` are the triangles that cut it besides those of its own list. False,
    /// with nothing appended, if an edge is open or irregular. O(q) expected for linking, O(q log q) for order and nesting.
    /// Throws std::bad_alloc, and Stopped where the host wants the call to end.
    bool build(PlaneIndex plane, std::span<const std::uint32_t> seeds, const Buckets& buckets, const PlaneSet& planes,
               BandOutput& out);

    /// Ticks spent in nesting and with the fill rule.
    const LayerTicks& ticks() const noexcept { return ticks_; }

private:
    /// A stretch of a contour, from a segment divisible by 64 up to the next, or a whole contour that holds none.
    struct Piece {
        std::uint32_t first;
        std::uint32_t count;
        std::uint32_t next;    // the segment after the last
        std::uint64_t offset;  // of its first point among all
    };
    class Table;

    std::uint32_t record(std::uint32_t segment) const noexcept {
        return segment < seeds_.size() ? seeds_[segment]
                                       : list_begin_ + (segment - static_cast<std::uint32_t>(seeds_.size()));
    }
    const CrossedTriangle& triangle(std::uint32_t segment) const noexcept { return buckets_->records[record(segment)]; }
    MeshEdge edge_at(std::uint32_t segment, bool source) const noexcept;

    bool link();
    std::int64_t link_block(Table& table, std::uint32_t begin, std::uint32_t end);
    void cut_into_pieces();
    void walk_pieces();
    void add_contour_as_piece(std::uint32_t first);
    void string_together();
    void trace(std::int32_t z, bool with_origins);

    Worker worker_;  // the calling thread
    const Parallel& parallel_;
    const Buckets* buckets_ = nullptr;
    std::span<const std::uint32_t> seeds_;
    std::uint32_t list_begin_ = 0;
    std::uint32_t count_ = 0;  // segments
    PlaneIndex plane_ = 0;
    Array<std::uint32_t> next_{worker_.memory()};     // by segment: the one that follows
    Array<std::uint8_t> on_piece_{worker_.memory()};  // by segment: it lies on a piece found
    Array<std::uint32_t> order_{worker_.memory()};    // segments in walking order
    Array<Point> rings_{worker_.memory()};
    Array<PointOrigin> origins_{worker_.memory()};  // of rings_, where asked for
    Vector<Piece> pieces_{worker_.memory()};
    Vector<WalkedContour> contours_{worker_.memory()};
    LayerBuilder layer_{worker_};
    LayerTicks ticks_;
};

}  // namespace lamella
