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
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/result.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

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

class Placement final : public BandTarget {
public:
    explicit Placement(const Memory* memory) : memory_(memory) {}

    /// For a new run over `bands`, of which at most `lead` beyond the head may be begun. Points beyond `room` are lost.
    void begin(std::span<const Band> bands, std::size_t lead, const PointRoom& room, const StopCheck& stop = {});
    /// The same for finish() with `result`, whose points are the room: no points are lost.
    void begin(std::span<const Band> bands, std::size_t lead, bool origins, SliceResult& result, const StopCheck& stop);

    BandOutput* acquire(std::size_t band) override;
    void give_back(std::size_t band) override;
    /// Places the band and all done bands that follow it. Throws Stopped where begin()'s `stop` asks for it.
    void submit(std::size_t band) override;
    void abort() override;
    /// Gives back what the last run did not need. To be called between runs. Throws std::bad_alloc.
    void trim();

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
            output = nullptr;
            done = false;
            room.reset();
        }

        std::uint64_t first_point = 0;
        std::uint64_t first_contour = 0;
        Vector<Contour> contours;
        Vector<std::uint32_t> layer_contours;
        Vector<Stitch> stitches;
        BandOutput* output = nullptr;  // from acquire() until the band's points are where they belong
        bool done = false;
        std::optional<Stretch> room;  // until the band is placed or moves to a buffer
    };

    std::optional<Stretch> find_room(std::size_t band);
    std::span<Placed> begun();
    bool clear_rooms(std::uint64_t end);
    void place_head();
    bool copy_points(const Placed& placed) const;
    void write_band(std::size_t band, std::span<Contour> contours, std::span<Layer> layers, const Parallel& parallel) const;

    const Memory* memory_;
    std::span<const Band> bands_;
    PointRoom room_;
    bool with_origins_ = false;
    bool keeps_ = false;  // what the room does not hold
    StopCheck stop_{};
    std::mutex mutex_;
    std::condition_variable head_moved_;
    std::vector<std::unique_ptr<BandOutput>> buffers_;
    std::vector<BandOutput*> idle_;
    std::vector<Placed> placed_;
    std::size_t head_ = 0;
    std::size_t lead_ = 0;  // how many bands beyond the head may be begun
    /// Some band had more points than segments, as open polylines do: places can no longer be predicted.
    bool outgrown_ = false;
    LayerTotals totals_;
    bool aborted_ = false;
};

}  // namespace lamella
