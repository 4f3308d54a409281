// The targets that a slice is made for: a result in memory, a sink, the host's own arrays. What makes layers, a sweep or the
// projection of faces or the union of parts, does not know which.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/result.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

// Where the points of each band go. Bands finish in any order and are placed in theirs. How many points a band has is known
// only when it is done: equal consecutive points are stored once, and open polylines have one more point than segments. But
// nearly every band has one point for each segment. A band is therefore swept straight to where its points will lie if that
// holds for the unfinished bands before it:
//
//     band        0       1          2           3
//               placed  placed   swept, head    done
//     points  [  0   |   1    |   2 ...       |  3        ]     2 has lost a point: 3 is moved down by one
//
// The ways that a band's points can take:
//
//     straight    swept to its place
//     moved       swept to a room above its place; moved down when it is placed
//     buffered    swept to a buffer and copied: its room might be another band's, or some band has outgrown its room
//     outgrown    begun in a room, finished in a buffer and copied
//     cleared     done in its room, copied to a buffer since a band below has outgrown its own
//     converted   swept to a buffer and given to a PointWriter, which all are where there is one
//     kept        beyond the room that the array has; copied when all bands are done and its size is known
//
// A thread waits while it is more than two bands a thread ahead of the first unfinished one, the head.

/// Takes points that are not to be kept as they are.
class PointWriter {
public:
    /// How many points there is room for.
    virtual std::uint64_t capacity() const noexcept = 0;
    /// The points from number `first` on; by several threads at once, no point twice.
    virtual void write(std::uint64_t first, std::span<const Point> points) const noexcept = 0;

protected:
    ~PointWriter() = default;
};

/// Where points go: to `points`, up to its size, or to `writer`, up to its capacity. Their origins go to `origins`, which is
/// as large, or empty.
struct PointRoom {
    std::span<Point> points{};
    std::span<PointOrigin> origins{};
    const PointWriter* writer = nullptr;
};

/// Outputs of bands, kept from call to call.
struct OutputPool {
    const Memory* memory;
    std::vector<std::unique_ptr<BandOutput>> outputs{};
};

/// The bands that are begun and not done with. The first of all that is not is the head: none is begun more than `lead`
/// beyond it.
class BandQueue : public BandTarget {
public:
    BandOutput* acquire(std::size_t band) final;
    void give_back(std::size_t band) final;
    void abort() final;

protected:
    explicit BandQueue(OutputPool& pool) : pool_(pool) {}
    ~BandQueue() = default;

    void begin(std::span<const Band> bands, std::size_t lead, bool origins);
    /// Where an empty output is to put the band's points. `lock` may be given up.
    virtual void make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) = 0;
    /// The output of a band that is done with. With mutex_ held.
    void put_idle(std::size_t band);

    struct InFlight {
        BandOutput* output = nullptr;  ///< from acquire() until its points are where they belong
        bool done = false;
    };

    OutputPool& pool_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::span<const Band> bands_;
    std::vector<InFlight> in_flight_;   ///< of each band
    std::atomic<std::size_t> head_{0};  ///< written with mutex_ held
    std::size_t lead_ = 0;
    bool with_origins_ = false;
    bool aborted_ = false;

private:
    std::vector<BandOutput*> idle_;
};

class Placement final : public BandQueue {
public:
    explicit Placement(OutputPool& pool) : BandQueue(pool) {}

    /// For a new run over `bands`, of which at most `lead` beyond the head may be begun. Points beyond `room` are lost.
    void begin(std::span<const Band> bands, std::size_t lead, const PointRoom& room, const StopCheck& stop = {});
    /// The same for finish() with `result`, whose points are the room: no points are lost.
    void begin(std::span<const Band> bands, std::size_t lead, bool origins, SliceResult& result, const StopCheck& stop);

    /// Places the band and all done bands that follow it. Throws Stopped where begin()'s `stop` asks for it.
    void submit(std::size_t band) override;
    /// Gives all memory back. To be called between runs.
    void trim() noexcept { placed_.clear(); }

    /// Completes `result` but for what its layers are: contours, points, origins, closed gaps, and which contours each layer
    /// has. After all bands were submitted. Precondition: `result` was begun with, and has its layers. Throws
    /// std::bad_alloc, Stopped.
    void finish(const Parallel& parallel, SliceResult& result);

    /// Of all bands that were placed; emptied layers are not counted.
    const LayerTotals& totals() const noexcept { return totals_; }
    /// In place of finish(): contours and the layers' contour ranges. layers[i] is plane i's.
    void write_contours(const Parallel& parallel, std::span<Contour> contours, std::span<Layer> layers) const;
    /// The same: closed gaps, by layer, then by `from` and `to`.
    void write_stitches(std::span<Stitch> gaps, const StopCheck& stop = {}) const;

private:
    /// Points [begin, end) of the result.
    struct Stretch {
        std::uint64_t begin;
        std::uint64_t end;
    };
    struct Placed {
        explicit Placed(const Memory* memory) : contours(memory), layer_contours(memory), stitches(memory) {}

        /// As it is before its band is begun, but for the memory that it holds.
        void clear() noexcept {
            contours.clear();
            layer_contours.clear();
            stitches.clear();
            room.reset();
        }

        std::uint64_t first_point = 0;
        std::uint64_t first_contour = 0;
        Vector<Contour> contours;
        Vector<std::uint32_t> layer_contours;
        Vector<Stitch> stitches;
        std::optional<Stretch> room;  // until the band is placed or moves to a buffer
    };

    void make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) override;
    std::optional<Stretch> find_room(std::size_t band);
    std::size_t begun_end() const noexcept { return std::min(head_ + lead_ + 1, placed_.size()); }
    bool clear_rooms(std::uint64_t end);
    void place_head();
    bool copy_points(std::size_t band) const;
    void write_band(std::size_t band, std::span<Contour> contours, std::span<Layer> layers, const Parallel& parallel) const;

    PointRoom room_;
    bool keeps_ = false;  // what the room does not hold
    StopCheck stop_{};
    std::vector<Placed> placed_;
    /// Some band had more points than segments, as open polylines do: places can no longer be predicted.
    bool outgrown_ = false;
    LayerTotals totals_;
};

/// Kept from call to call.
struct OutputScratch {
    explicit OutputScratch(const Memory* memory) : pool{memory} {}
    OutputPool pool;
    Placement placement{pool};
};

/// All that is known before layers are made.
struct OutputPlan {
    PlaneIndex layers;
    FunctionRef<Layer(PlaneIndex)> layer_at;  ///< without its contours; its segments when it has been made
    std::uint64_t segments;                   ///< of all layers: how many points there will be, but for a few
    std::uint64_t cutting;                    ///< layers that have segments
    std::span<const Band> bands;              ///< empty until they are cut
    const Parallel& parallel;
    OutputScratch& scratch;
    bool origins;                   ///< SliceOptions::origins
    SliceResult& result;            ///< unit, frame, plan and summary; arrays only where the slice is made for it
    std::size_t lead;               ///< how many bands may be begun beyond the first that is not done
    std::uint64_t first_index = 0;  ///< of the first layer, for sinks
};

/// The lead of bands that all threads sweep.
inline std::size_t usual_lead(const Parallel& parallel) noexcept {
    return 2 * static_cast<std::size_t>(parallel.threads());
}

/// The functions are called in their order.
class LayerTarget {
public:
    /// The number of layers is known, and of `info` what is known before anything is cut. Throws Refused where it is too
    /// much.
    virtual void admit_layers(std::uint64_t /*layers*/, const SliceInfo& /*info*/) const {}
    /// The same for the size of what a sweep makes, of which nothing is allocated yet.
    virtual void admit(const OutputPlan& plan, std::uint64_t /*memory_limit*/) const {
        admit_layers(plan.layers, plan.result.info);
    }
    /// How many segments a band should have at most.
    virtual std::uint64_t most_band_segments(int /*threads*/) const noexcept { return BandPlan::no_limit; }
    /// Where the bands go, all of which are then submitted there.
    virtual BandTarget& begin(const OutputPlan& plan) = 0;
    /// After the scratch of what made the bands has been released: completes result and summary.
    virtual void finish(const OutputPlan& plan) = 0;

protected:
    ~LayerTarget() = default;
};

/// A slice that is made for OutputPlan::result.
class ResultTarget final : public LayerTarget {
public:
    void admit(const OutputPlan& plan, std::uint64_t memory_limit) const override;
    BandTarget& begin(const OutputPlan& plan) override;
    void finish(const OutputPlan& plan) override;
};

/// Has the arrays of `result` take their memory from there. Those that take it from elsewhere are emptied.
void move_to(const Memory* memory, SliceResult& result);

/// The layer of a plane, without its contours.
inline Layer describe_layer(const PlaneSet& planes, PlaneIndex plane, std::uint64_t segments) {
    return {planes.bottom_mm(plane),     planes.height_mm(plane), planes.top_mm(plane), 0, 0, segments,
            PlaneHeight(planes.z(plane))};
}

/// Writes all layers, without their contours, to `layers`.
void fill_layers(const OutputPlan& plan, std::span<Layer> layers);

/// SliceInfo::layers, layer_of, first_layer and planned_layers; `list_heights`: the options have not chosen them.
void describe_plan(const PlaneSet& planes, bool list_heights, SliceInfo& info);

/// Adds what a part of a slice has read, swept and spent.
void add_work(const SliceInfo& part, SliceInfo& sum) noexcept;

}  // namespace lamella
