// The targets that a slice is made for: a result in memory, a sink, the host's own arrays. What makes layers, a sweep or the
// projection of faces or the union of parts, does not know which.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
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

/// A band whose points have their place in the result.
struct PlacedBand {
    explicit PlacedBand(const Memory* memory) : contours(memory), layer_contours(memory), stitches(memory) {}

    std::uint64_t first_point = 0;
    std::uint64_t first_contour = 0;
    Vector<Contour> contours;
    Vector<std::uint32_t> layer_contours;
    Vector<Stitch> stitches;
};

/// Points [begin, end) of an array; none where it is empty.
struct PointStretch {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
};

struct BandInFlight {
    BandOutput* output = nullptr;  ///< from acquire() until its points are where they belong
    bool done = false;
    PointStretch room{};  ///< of PlacedTarget: until the band is placed or moves to a buffer
};

/// Memory of targets, kept from call to call.
struct OutputScratch {
    explicit OutputScratch(const Memory* from) noexcept : memory(from) {}

    const Memory* memory;
    std::vector<std::unique_ptr<BandOutput>> outputs{};
    std::vector<BandOutput*> idle{};  ///< of outputs
    std::vector<BandInFlight> in_flight{};
    std::vector<PlacedBand> placed{};
};

/// All that is known before layers are made.
struct OutputPlan {
    PlaneIndex layers;
    FunctionRef<Layer(PlaneIndex)> layer_at;  ///< without its contours; its segments when it has been made
    std::uint64_t segments;                   ///< of all layers: how many points there will be, but for a few; 0: not known
    std::uint64_t cutting;                    ///< layers that have segments
    std::span<const Band> bands;              ///< empty until they are cut
    const Parallel& parallel;
    OutputScratch& scratch;
    bool origins;                   ///< SliceOptions::origins
    SliceInfo& info;                ///< unit, frame and plan are known; gets the summary
    std::uint64_t first_index = 0;  ///< of the first layer: of a file that is cut in ranges of layers
};

/// Thrown where a band is no longer wanted, since another thread has called LayerTarget::abort().
struct BandDropped {};

/// A slice has one plan or, of a file, several for ranges of layers, one after the other. For each, functions are called in
/// their order. The bands that are begun and not done with are in flight.
/// The first of all that is not done with is the head: none is begun more than a lead beyond it.
class LayerTarget {
public:
    LayerTarget() = default;
    virtual ~LayerTarget() = default;
    LayerTarget(const LayerTarget&) = delete;
    LayerTarget& operator=(const LayerTarget&) = delete;

    /// The number of layers is known, and of `info` what is known before anything is cut. Throws Refused where it is too
    /// much.
    virtual void admit_layers(std::uint64_t /*layers*/, const SliceInfo& /*info*/) {}
    /// The same for the size of what a sweep makes, of which nothing is allocated yet.
    virtual void admit(const OutputPlan& plan, std::uint64_t /*memory_limit*/) {
        admit_layers(plan.first_index + plan.layers, plan.info);
    }
    /// All that is known before the first layer of all plans. Later calls are ignored.
    virtual void announce(const SliceInfo& info) { admit_layers(info.layers, info); }
    /// How many segments a band should have at most.
    virtual std::uint64_t most_band_segments(int /*threads*/) const noexcept { return BandPlan::no_limit; }
    /// All bands of `plan`, which stays until finish(), are then acquired and submitted.
    virtual void begin(const OutputPlan& plan) = 0;
    /// Where `band` puts its output; may wait for bands before it. Null after abort(). Bands must be acquired in ascending
    /// order, each by a thread that then submits it or aborts.
    BandOutput* acquire(std::size_t band);
    /// The band is done. Throws Stopped where the host wants the call to end.
    virtual void submit(std::size_t band) = 0;
    /// The run has failed: wakes all that wait.
    void abort();
    /// A layer has been appended to `output`, whose complete layers may now be taken out: see BandOutput::drop_layers(). On
    /// the thread that sweeps the band, where BandOutput::reader asks for it.
    virtual void layer_done(BandOutput& /*output*/) {}
    /// After the scratch of what made the bands has been released: completes result and summary.
    virtual void finish() = 0;

protected:
    void begin_bands(const OutputPlan& plan, std::size_t lead, bool origins);
    /// Where an empty output is to put the band's points. `lock` may be given up.
    virtual void make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) = 0;
    /// The output of a band that is done with. With mutex_ held.
    void put_idle(std::size_t band);

    const OutputPlan* plan_ = nullptr;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::span<BandInFlight> in_flight_;  ///< of each band
    std::atomic<std::size_t> head_{0};   ///< written with mutex_ held
    std::size_t lead_ = 0;
    bool with_origins_ = false;
    bool aborted_ = false;
    LayerTotals totals_;  ///< of all bands of the plan that were placed or handed over
};

/// Sweeps bands [begin, end) side by side: fill(band, worker, output) appends the layers of one. No thread is left waiting
/// where something throws.
template <class Fill>
void fill_bands(LayerTarget& target, const Parallel& parallel, std::size_t begin, std::size_t end, const Fill& fill) {
    parallel.run(end - begin, [&](std::size_t i, int worker) {
        try {
            if (BandOutput* const output = target.acquire(begin + i); output != nullptr) {
                fill(begin + i, worker, *output);
                target.submit(begin + i);
            }
        } catch (const BandDropped&) {  // the thread that has failed throws
        } catch (...) {
            target.abort();
            throw;
        }
    });
}

// Where the points of each band go in one array. Bands finish in any order and are placed in theirs. How many points a band
// has is known only when it is done: equal consecutive points are stored once, and open polylines have one more point than
// segments. But nearly every band has one point for each segment. A band is therefore swept straight to where its points
// will lie if that holds for the unfinished bands before it:
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
//     converted   swept to a buffer and written by write(), which all are where there is no array
//     kept        beyond the room that the array has; copied when all bands are done and its size is known
//
// A thread waits while it is more than two bands a thread ahead of the head.

/// What places all bands in arrays: points where begin_placing() says, the rest when all bands are done.
class PlacedTarget : public LayerTarget {
public:
    void submit(std::size_t band) final;

protected:
    /// What `points` do not hold is kept for write_layers(), or lost. `origins` are as many, where there are some. What
    /// plans before made stays.
    void begin_placing(const OutputPlan& plan, std::span<Point> points, std::span<PointOrigin> origins, bool origins_asked,
                       bool keeps);
    /// How many points there is room for.
    virtual std::uint64_t capacity() const noexcept { return points_.size(); }
    /// Points from number `first` on, which come from a buffer; by several threads at once, no point twice.
    virtual void write(std::uint64_t first, std::span<const Point> points) const noexcept;
    /// Completes arrays that have room for all, and the summary. `stitches`: by layer, then by `from` and `to`, unless
    /// empty.
    void write_layers(std::span<Layer> layers, std::span<Contour> contours, std::span<Stitch> stitches);
    /// So many points are where they belong: all that is kept comes after them.
    std::uint64_t points_in_place() const noexcept;

    std::span<Point> points_;
    std::span<PointOrigin> origins_;
    LayerTotals before_;  ///< of plans before
    LayerTotals all_;     ///< the same, and of all bands that were placed: where the next one goes

private:
    void make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) override;
    PointStretch find_room(std::size_t band) const noexcept;
    bool clear_rooms(std::uint64_t end);
    void swap_lists(std::size_t band, BandOutput& output) const noexcept;
    void place_head();
    bool copy_points(std::size_t band) const;
    LayerTotals write_band(std::size_t band, std::span<Layer> layers, std::span<Contour> contours) const;
    void write_stitches(std::span<Stitch> stitches) const;

    std::vector<PlacedBand>* placed_ = nullptr;
    bool keeps_ = false;
    /// Some band had more points than segments, as open polylines do: places can no longer be predicted.
    bool outgrown_ = false;
};

/// Fills the arrays of a result anew. Its summary is the plan's.
class ResultTarget final : public PlacedTarget {
public:
    explicit ResultTarget(SliceResult& result) noexcept : result_(result) {}

    void admit(const OutputPlan& plan, std::uint64_t memory_limit) override;
    void begin(const OutputPlan& plan) override;
    void finish() override;

private:
    SliceResult& result_;
};

/// The layer of a plane, without its contours.
inline Layer describe_layer(const PlaneSet& planes, PlaneIndex plane, std::uint64_t segments) {
    return {planes.bottom_mm(plane),     planes.height_mm(plane), planes.top_mm(plane), 0, 0, segments,
            PlaneHeight(planes.z(plane))};
}

/// SliceInfo::layers, layer_of, first_layer and planned_layers; `list_heights`: the options have not chosen them.
void describe_plan(const PlaneSet& planes, bool list_heights, SliceInfo& info);

/// Adds what a part of a slice has swept and spent, and what it has read, so many times.
void add_work(const SliceInfo& part, std::uint64_t times, SliceInfo& sum) noexcept;

}  // namespace lamella
