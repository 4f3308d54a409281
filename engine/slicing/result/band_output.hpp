// The layers of one band while it is swept and until it is placed in the result. Indices count from the band's first plane,
// contour and point.
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Numbers of contours, for the summary.
struct ContourCounts {
    std::uint64_t by_role[4] = {};  ///< index: Role
    std::uint64_t overruled = 0;
    std::uint64_t near = 0;

    void add(const Contour& contour) noexcept {
        ++by_role[static_cast<std::size_t>(contour.role)];
        overruled += (contour.flags & orientation_overruled) != 0 ? 1 : 0;
        near += (contour.flags & near_contour) != 0 ? 1 : 0;
    }
    void add(const ContourCounts& other) noexcept {
        for (std::size_t role = 0; role < 4; ++role) {
            by_role[role] += other.by_role[role];
        }
        overruled += other.overruled;
        near += other.near;
    }
    std::uint64_t of(Role role) const noexcept { return by_role[static_cast<std::size_t>(role)]; }
};

/// Sets what the summary counts of contours, and of layers that the rules have emptied. O(k).
void set_counts(const ContourCounts& counts, SliceResult& result) noexcept;

struct BandOutput {
    explicit BandOutput(const Memory* memory)
        : buffer(memory), contours(memory), layer_contours(memory), closed_gaps(memory) {}

    Point* points = nullptr;  ///< in the result's own array, or in `buffer`
    std::size_t point_count = 0;
    std::size_t capacity = 0;
    Array<Point> buffer;  ///< its size: what was needed in a run so far
    Vector<Contour> contours;
    ContourCounts counts;
    Vector<std::uint32_t> layer_contours;  ///< number of contours of each plane
    Vector<ClosedGap> closed_gaps;
    std::uint64_t first_layer = 0;  ///< number of the layer that comes first

    /// Empties the output; points go to `room` while it lasts, then to `buffer`.
    void begin(std::span<Point> room) noexcept {
        points = room.data();
        capacity = room.size();
        point_count = 0;
        contours.clear();
        counts = {};
        layer_contours.clear();
        closed_gaps.clear();
    }
    /// Between runs: gives back what the last one did not need. Throws std::bad_alloc.
    void trim();
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
};

}  // namespace lamella
