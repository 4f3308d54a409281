// The layers of one band while it is swept and until it is placed in the result. Indices count from the band's first plane,
// contour and point.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/layers.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Numbers of contours, for the summary.
struct ContourCounts {
    std::uint64_t by_role[4] = {};  ///< index: Role
    std::uint64_t overruled = 0;
    std::uint64_t near = 0;
    std::uint64_t cancelled_layers = 0;

    void add(const Contour& contour) noexcept {
        ++by_role[static_cast<std::size_t>(contour.role)];
        overruled += (contour.flags & orientation_overruled) != 0 ? 1 : 0;
        near += (contour.flags & would_close) != 0 ? 1 : 0;
    }
    void add(const ContourCounts& other) noexcept {
        for (std::size_t role = 0; role < 4; ++role) {
            by_role[role] += other.by_role[role];
        }
        overruled += other.overruled;
        near += other.near;
        cancelled_layers += other.cancelled_layers;
    }
    std::uint64_t of(Role role) const noexcept { return by_role[static_cast<std::size_t>(role)]; }
};

/// Numbers of what was made.
struct LayerTotals {
    std::uint64_t contours = 0;
    std::uint64_t points = 0;
    std::uint64_t stitches = 0;
    std::uint64_t emptied = 0;  ///< layers that have segments but no contour
    ContourCounts counts;

    void add(const LayerTotals& other) noexcept;
    /// Sets them in the summary, whose options are known.
    void describe(SliceInfo& info) const noexcept;
};

/// Sets them in the summary of a result that has all its layers. O(k).
void set_counts(const ContourCounts& counts, SliceResult& result) noexcept;
/// How many of `layers` planes cut, but have no contour left.
std::uint64_t count_emptied(std::span<const Layer> layers) noexcept;

struct BandOutput;

/// Thrown where a band is no longer wanted, since another thread has called BandTarget::abort().
struct BandDropped {};

/// Where bands go when they are swept.
class BandTarget {
public:
    /// Where `band` puts its output; may wait for bands before it. Null after abort(). Bands must be acquired in ascending
    /// order, each by a thread that then submits it, gives it back or aborts.
    virtual BandOutput* acquire(std::size_t band) = 0;
    /// Takes back an unused output.
    virtual void give_back(std::size_t band) = 0;
    /// The band is done. Throws Stopped where the host wants the call to end.
    virtual void submit(std::size_t band) = 0;
    /// The run has failed: wakes all that wait.
    virtual void abort() = 0;
    /// A layer has been appended to `output`, whose complete layers may now be taken out: see BandOutput::drop_layers(). On
    /// the thread that sweeps the band, where BandOutput::reader asks for it.
    virtual void layer_done(BandOutput& /*output*/) {}

protected:
    ~BandTarget() = default;
};

struct BandOutput {
    explicit BandOutput(const Memory* memory) : buffer(memory) {}

    Point* points = nullptr;         ///< in the result's own array, or in `buffer`
    PointOrigin* origins = nullptr;  ///< of each point, in the same place, where `with_origins`
    std::size_t point_count = 0;
    std::size_t capacity = 0;
    Array<Point> buffer;  ///< its size: the most that was needed
    Array<PointOrigin> origin_buffer{buffer.memory()};
    bool with_origins = false;
    Vector<Contour> contours{buffer.memory()};
    ContourCounts counts;
    Vector<std::uint32_t> layer_contours{buffer.memory()};  ///< number of contours of each plane
    Vector<Stitch> stitches{buffer.memory()};
    std::uint64_t first_layer = 0;  ///< number of the layer that comes first
    BandTarget* reader = nullptr;   ///< null: layers stay until the band is done
    std::size_t band = 0;           ///< for the reader

    /// Empties the output; points go to `room` while it lasts, then to `buffer`. `origin_room` is as large, or empty where
    /// there are no origins.
    void begin(std::span<Point> room, std::span<PointOrigin> origin_room = {}) noexcept {
        points = room.data();
        origins = origin_room.data();
        capacity = room.size();
        point_count = 0;
        contours.clear();
        counts = {};
        layer_contours.clear();
        stitches.clear();
    }
    /// The same with all points in `buffer`, which takes `count` at once. Throws std::bad_alloc.
    void begin_in_buffer(std::size_t count) {
        begin({});
        move_to_buffer(count);
    }
    bool in_buffer() const noexcept { return points == buffer.data(); }

    /// Makes room for `count` more points and returns where they go. Throws std::bad_alloc.
    Point* reserve_points(std::size_t count) {
        if (point_count + count > capacity) {
            move_to_buffer(count);
        }
        return points + point_count;
    }
    /// Moves all points to `buffer`, with room for `count` more. Throws std::bad_alloc.
    void move_to_buffer(std::size_t count);

    void add_empty_layer() { layer_contours.push_back(0); }

    /// To be called after each layer.
    void finish_layer() {
        if (reader != nullptr) {
            reader->layer_done(*this);
        }
    }
    /// Empties the output, which goes on with the layer that comes next. `counts` stay.
    void drop_layers() noexcept;
    /// The size of points, contours and gaps.
    std::size_t bytes_used() const noexcept;
    std::size_t bytes_held() const noexcept;
    /// Gives all memory back.
    void release() noexcept;
};

/// Acquires `band`, calls fill(its output) and submits it. No thread is left waiting where something of it throws.
template <class Fill>
void fill_band(BandTarget& target, std::size_t band, Fill fill) {
    try {
        if (BandOutput* const output = target.acquire(band); output != nullptr) {
            fill(*output);
            target.submit(band);
        }
    } catch (const BandDropped&) {  // the thread that has failed throws
    } catch (...) {
        target.abort();
        throw;
    }
}

/// All contours and points of `output`, in arrays that take their memory from `memory`. Throws std::bad_alloc, and Stopped
/// where the host that `pace` asks wants the call to end.
SliceResult copy_layer(const BandOutput& output, std::uint64_t segments, StopPace& pace, const Memory* memory);

}  // namespace lamella
