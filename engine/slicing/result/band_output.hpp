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

/// Numbers of what was made, for the summary.
struct LayerTotals {
#define END_COUNTER(name) std::uint64_t name = 0;
#include "options/counters.inc"

    void add(const Contour& contour) noexcept {
        ++contours;
        points += contour.point_count;
        holes += contour.role == Role::hole ? 1 : 0;
        open_contours += contour.role == Role::open ? 1 : 0;
        flat_contours += contour.role == Role::flat ? 1 : 0;
        overruled_contours += (contour.flags & orientation_overruled) != 0 ? 1 : 0;
        would_close_contours += (contour.flags & would_close) != 0 ? 1 : 0;
    }
    /// Precondition: its contours are counted in it.
    void add(const Layer& layer) noexcept {
        emptied_layers += layer.segments > 0 && layer.contour_count == 0 ? 1 : 0;
    }
    void add(const LayerTotals& other) noexcept;
    /// Sets them in the summary, whose options are known.
    void describe(SliceInfo& info) const noexcept;
};

class LayerTarget;

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
    LayerTotals totals;  ///< of all its layers, but for what is known of them when they are placed
    Vector<std::uint32_t> layer_contours{buffer.memory()};  ///< number of contours of each plane
    Vector<Stitch> stitches{buffer.memory()};
    std::uint64_t first_layer = 0;  ///< number of the layer that comes first
    LayerTarget* reader = nullptr;  ///< takes complete layers out; null: they stay until the band is done
    std::size_t band = 0;           ///< for the reader

    /// Empties the output; points go to `room` while it lasts, then to `buffer`. `origin_room` is as large, or empty where
    /// there are no origins.
    void begin(std::span<Point> room, std::span<PointOrigin> origin_room = {}) noexcept {
        points = room.data();
        origins = origin_room.data();
        capacity = room.size();
        point_count = 0;
        contours.clear();
        totals = {};
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
    void finish_layer();
    /// Empties the output, which goes on with the layer that comes next. `totals` stay.
    void drop_layers() noexcept;
    /// The size of points, contours and gaps.
    std::size_t bytes_used() const noexcept;
    std::size_t bytes_held() const noexcept;
    /// Gives all memory back.
    void release() noexcept;
};

/// All contours and points of `output`, in arrays that take their memory from `memory`. Throws std::bad_alloc, and Stopped
/// where the host that `pace` asks wants the call to end.
SliceResult copy_layer(const BandOutput& output, std::uint64_t segments, StopPace& pace, const Memory* memory);

}  // namespace lamella
