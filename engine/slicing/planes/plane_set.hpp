// The planes on the grid (paper, 3.1), and which of them is the first above a vertex (Algorithms 2 and 3).
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/grid.hpp"
#include "lamella/options.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/tuning.hpp"

namespace lamella {

struct Layer;

/// Index of a plane, or one past the last. Plans with more than 2^31 planes are refused, so 32 bits hold it.
using PlaneIndex = std::uint32_t;

/// Heights from the lowest plane to the highest, cut into cells of 2^shift units, two to four a plane. The cell of a vertex
/// gives the first plane above it, up to planes within the cell.
///
///     planes       |  |          |  |||          |
///     cells      [   |   |   |   |   |   |   |   ]
///     first        0   2   2   2   3   6   6   6   7
struct HeightTable {
    explicit HeightTable(const Memory* memory) : first(memory) {}

    /// The cell of a height. Precondition: there are planes.
    std::size_t cell(std::int32_t z) const noexcept {
        const std::int32_t clamped = std::clamp(z, lowest, highest);
        return (static_cast<std::uint32_t>(clamped) - static_cast<std::uint32_t>(lowest)) >> shift;
    }

    Array<PlaneIndex> first;  ///< first plane at or above the start of each cell, and of one more
    std::int32_t lowest = 0;  ///< of the planes
    std::int32_t highest = 0;
    int shift = 0;
};

/// The planes [first, end).
struct PlaneRange {
    PlaneIndex first;
    PlaneIndex end;

    PlaneIndex size() const noexcept { return end - first; }
    bool meets(PlaneRange other) const noexcept { return first < other.end && end > other.first; }
};

/// Where the plane of a slab lies that has no height of its own.
inline double middle_of(const Slab& slab) noexcept {
    return (slab.bottom_mm + slab.top_mm) / 2;
}

/// k planes, ascending. Immutable once made, shared by all threads.
class PlaneSet {
public:
    explicit PlaneSet(const Memory* memory)
        : padded_(memory),
          heights_mm_(memory),
          plane_of_listed_(memory),
          slabs_(memory),
          listed_order_(memory),
          table_(memory) {}

    PlaneIndex size() const noexcept { return count_; }
    bool uniform() const noexcept { return inverse_step_ > 0; }
    /// z of plane i in grid units; -1 and size() are sentinels beyond every vertex.
    std::int32_t z(PlaneIndex i) const noexcept { return padded_[i + 1]; }
    /// z of planes -1 to size(); the pointer is to plane 0.
    const std::int32_t* heights() const noexcept { return padded_.data() + 1; }
    /// 0 when not uniform.
    double planes_per_unit() const noexcept { return inverse_step_; }
    /// The height asked for, before rounding.
    double height_mm(PlaneIndex i) const noexcept {
        return heights_mm_.empty() ? first_mm_ + (first_step_ + static_cast<double>(i)) * step_mm_
                                   : heights_mm_[first_kept_ + i];
    }
    /// Bottom and top of the slab that plane i stands for: given ones, or up to the middles between planes.
    double bottom_mm(PlaneIndex i) const noexcept;
    double top_mm(PlaneIndex i) const noexcept;
    /// The plane of each listed height; empty where heights are not listed.
    const Vector<double>& listed_mm() const noexcept { return heights_mm_; }
    const Vector<PlaneIndex>& plane_of_listed() const noexcept { return plane_of_listed_; }

    /// The first plane above a vertex at height z. Uniform planes by arithmetic, corrected by one either way (Algorithm 2,
    /// first case); others by a table of heights and a few steps from there, a binary search where planes crowd (Algorithm
    /// 3).
    PlaneIndex first_above(std::int32_t z) const noexcept { return uniform() ? by_division(z) : by_table(z); }
    /// The planes between two heights of vertices.
    PlaneRange between(std::int32_t low, std::int32_t high) const noexcept {
        const PlaneIndex first = first_above(low);
        return {first, z(first) < high ? first_above(high) : first};
    }
    bool any_between(std::int32_t low, std::int32_t high) const noexcept { return z(first_above(low)) < high; }
    /// first_above() by the table, for any spacing.
    PlaneIndex by_table(std::int32_t z) const noexcept;
    const HeightTable& table() const noexcept { return table_; }

    /// Makes the planes that are asked for, of a mesh in `frame`. Heights are rounded to the frame's number type first, so
    /// that a vertex at a plane's very height rounds as the plane does. O(k). Refused: invalid_argument, bad_planes,
    /// result_too_large (k layers alone exceed the limit).
    void build(const SliceOptions& options, const std::optional<RandomHeights>& random, const SharedFrame& frame,
               std::uint64_t memory_limit);
    /// Drops all planes but those of range_of(), which keep their heights, bottoms and tops. O(k).
    void keep(std::uint64_t first, std::uint64_t end);
    /// Every plane by so many units, which are even; beyond 32 bits they stay at either end. Heights in mm stay. O(k).
    void lower(std::int32_t by);
    /// Those of the layers [first, end) that there are. Refused: bad_planes (there are planes, but none of these).
    PlaneRange range_of(std::uint64_t first, std::uint64_t end) const;
    /// The plane that is now plane 0, and how many there were before.
    PlaneIndex first_kept() const noexcept { return first_kept_; }
    PlaneIndex planned() const noexcept { return planned_; }
    /// The planes of a result, with their heights on the grid only. Precondition: they ascend. O(k).
    void build(const Array<Layer>& layers);

private:
    // These throw Refused:
    void build_uniform(const SliceOptions& options, const Bounds& bounds, std::uint64_t memory_limit);
    void build_listed(std::span<const double> heights);
    void build_slabs(const SliceOptions& options);
    void build_random(const RandomHeights& random, const Bounds& bounds, std::uint64_t memory_limit);
    void check_count(double planes, std::uint64_t memory_limit) const;
    void check_distinct() const;
    bool share_plane(double below_mm, double above_mm) const noexcept;
    bool within_reach(double mm) const noexcept;
    void fill_from_heights();
    void make_table();
    std::int32_t round_height(double mm) const noexcept;

    PlaneIndex by_division(std::int32_t z) const noexcept {
        const double guess = (static_cast<double>(z) - first_z_) * inverse_step_;
        const double clamped = guess < 0 ? 0 : (guess > last_guess_ ? last_guess_ : guess);
        auto i = static_cast<std::int32_t>(clamped);
        const std::int32_t* plane = padded_.data() + 1;
        // Off by one at most unless steps are a few units, where each plane's own rounding weighs in.
        while (plane[i] < z) {
            ++i;
        }
        while (plane[i - 1] > z) {
            --i;
        }
        assert(plane[i] > z && plane[i - 1] < z);
        return static_cast<PlaneIndex>(i);
    }

    PlaneSide side_ = PlaneSide::below;
    double layer_height_mm_ = 0;  // 0 when not uniform
    double unit_mm_ = default_grid_mm;
    Number number_ = Number::f32;
    PlaneIndex count_ = 0;
    PlaneIndex first_kept_ = 0;
    PlaneIndex planned_ = 0;
    Array<std::int32_t> padded_;  // [lowest, plane 0, ..., plane k-1, highest]
    // uniform: plane i is at first_mm_ + (first_step_ + i) * step_mm_
    double first_mm_ = 0;
    double first_step_ = 0;
    double step_mm_ = 0;
    double first_z_ = 0;       // of plane 0, grid units
    double inverse_step_ = 0;  // planes per grid unit; 0 when not uniform
    double last_guess_ = 0;
    Vector<double> heights_mm_;           // when not uniform, of all planned
    Vector<PlaneIndex> plane_of_listed_;  // when heights are listed
    Vector<Slab> slabs_;                  // when given, of all planned
    Vector<PlaneIndex> listed_order_;     // scratch: which of the listed heights is lowest, and so on
    HeightTable table_;
};

}  // namespace lamella
