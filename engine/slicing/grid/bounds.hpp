// The box of the mesh, from one read before the grid is chosen; checks that every coordinate and index can be used.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

struct Bounds {
    double min_mm[3];
    double max_mm[3];

    /// The box of nothing, to be added to.
    static constexpr Bounds empty() noexcept {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    }
    void add(int axis, double low, double high) noexcept {
        min_mm[axis] = std::min(min_mm[axis], low);
        max_mm[axis] = std::max(max_mm[axis], high);
    }
    void add(const Bounds& other) noexcept {
        for (int axis = 0; axis < 3; ++axis) {
            add(axis, other.min_mm[axis], other.max_mm[axis]);
        }
    }

    /// The largest magnitude of x and y, or of all three.
    double farthest_in_plane() const noexcept { return farthest(2); }
    double farthest(int axes = 3) const noexcept {
        double farthest = 0;
        for (int axis = 0; axis < axes; ++axis) {
            farthest = std::max({farthest, std::abs(min_mm[axis]), std::abs(max_mm[axis])});
        }
        return farthest;
    }
};

// What measure_bounds() keeps of each block of 64 triangles. A block that lies between two planes and has no two vertices
// near each other is not read again: on a fine mesh these are most blocks.

inline constexpr std::size_t block_triangles = 64;

struct TriangleBlock {
    double low_mm;  ///< least and greatest z, transformed
    double high_mm;
    bool near;  ///< two vertices of one triangle lie within BlockTable::near_mm of each other on every axis
};

struct BlockTable {
    explicit BlockTable(const Memory* memory) : blocks(memory) {}

    /// Vertices that share a grid vertex are at most two units apart; twice that leaves room for rounding.
    static double near_mm_for(double unit_mm) noexcept { return 4 * unit_mm; }

    /// Whether a triangle of the block may have two equal vertices on a grid of `unit_mm`.
    bool may_be_degenerate(std::size_t block, double unit_mm) const noexcept {
        return blocks[block].near || near_mm < near_mm_for(unit_mm);
    }

    Array<TriangleBlock> blocks;  ///< block b: triangles from 64 b on
    double near_mm = 0;
    InstructionSet instructions = instruction_set();
};

inline std::size_t block_count(std::size_t triangles) noexcept {
    return (triangles + block_triangles - 1) / block_triangles;
}

/// One parallel streaming read; O(n). The box is of the transformed mesh. `unit_mm` is the requested unit, 0 for the
/// default. `table` is filled in for this unit; for a larger one it names more blocks as possibly degenerate. Errors:
/// empty_mesh, invalid_argument (an index out of range), bad_coordinate; each names the first such triangle.
Result<Bounds> measure_bounds(const MeshView& mesh, const Placing& placing, double unit_mm, const Parallel& parallel,
                              BlockTable& table);

/// Error: invalid_argument, where types of numbers or the unit make no sense.
Status check_mesh(const MeshView& mesh);

/// Error: invalid_argument, where the transform flattens every mesh. What is not finite is for measure_bounds() to name.
Status check_transform(const Transform& transform);

struct ChosenUnit {
    double mm;
    int doublings;  ///< of the unit asked for, or of the default
};

/// The grid, and the box by which planes are chosen: of one mesh, or around all that are sliced as parts of one result.
struct SharedFrame {
    Bounds bounds;
    ChosenUnit unit;
    Number number;            ///< heights are rounded to it; see PlaneSet::build()
    std::int32_t raised = 0;  ///< even: the mesh stands so many units higher than its coordinates say
};

/// The unit to use: `asked_mm`, or if that is 0 the default, doubled until the box fits, or if that is finest_grid the
/// finest power of two that the box fits. `coarser`: a unit asked for is doubled as the default is. `reach_mm`: how far
/// contours may grow beyond the box in the plane; finest_grid and `coarser` leave room for it. Errors: invalid_argument,
/// bad_coordinate (the box does not fit the requested unit).
Result<ChosenUnit> choose_unit(const Bounds& bounds, double asked_mm, bool coarser = false, double reach_mm = 0);

/// The unit of finest_grid.
double finest_unit(double farthest_mm) noexcept;

/// For a mesh of which nothing is left on the grid: every triangle has two equal vertices, or there is none.
Error all_collapsed(std::size_t triangles, double unit_mm);

}  // namespace lamella
