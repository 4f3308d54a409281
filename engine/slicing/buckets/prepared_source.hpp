// A mesh's triangles ordered so that few planes read little of them: they are sorted into cells by height and by place.
// A cell of level c is 2^c units high. It holds the triangles that begin in it and are lower than that, though not lower
// than half of it unless the level is the lowest.
//
//     z  ^  |    |        |
//        |  |    |--------|  t3
//        |  |----|        |           level c:      cells [ t0 t2 | t1 | ...   of height 2^c
//        |  | t2 |        |           level c + 1:  cells [ t3 | ...           of height 2^(c+1)
//        |  |----| t1     |
//        |  | t0 |        |           A plane meets triangles of two cells at most in each level.
//
// Triangles of a cell keep the order of the input, in which neighbours lie close together. Over all of them, from the lowest
// level up, lie blocks of 64 with their z range. Only blocks that a plane passes through are read.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "slicing/buckets/mesh_source.hpp"

namespace lamella {

namespace detail {

/// The inside of a PreparedMesh.
struct PreparedImpl {
    PreparedImpl(const MeshView& view, const Memory* memory) : mesh(view), order(memory), blocks(memory) {}

    /// The least and the greatest z of some triangles.
    struct Range {
        std::int32_t low;
        std::int32_t high;
    };

    /// Reads the mesh, of which the rest is known, twice: O(n). Memory: 12 bytes a triangle, and while it is made 8 for
    /// each cell and 2^16 triangles. Throws std::bad_alloc, Stopped.
    void build(const Parallel& parallel);

    std::size_t bytes() const noexcept;

    /// The frame that it was prepared in, with its grid: a call may repeat it or leave it out. Throws Refused.
    const Frame& frame_for(const Frame& given) const;

    MeshView mesh;
    struct Triangle {
        std::uint32_t number;
        Range range;
    };
    Array<Triangle> order;  ///< those that are not degenerate
    Array<Range> blocks;    ///< of 64 in that order
    Bounds bounds{};
    SharedFrame frame{};       ///< its bounds choose the planes: none where nothing is left on the grid
    Frame asked{};             ///< with the grid that was chosen
    double asked_grid_mm = 0;  ///< before
};

}  // namespace detail

/// Gives the lists of a mesh, but for the order within each. O(n / 64 + the triangles in blocks that planes pass through).
class PreparedSource final : public TriangleSource {
public:
    PreparedSource(const detail::PreparedImpl& prepared, const SourceTools& tools) noexcept
        : PreparedSource(prepared, prepared.frame, tools) {}
    /// With the planes of another box. Precondition: on the same grid.
    PreparedSource(const detail::PreparedImpl& prepared, const SharedFrame& frame, const SourceTools& tools) noexcept
        : TriangleSource({prepared.mesh.triangle_count, &frame}, tools),
          prepared_(prepared),
          placing_(placing_of(prepared.mesh, prepared.asked)) {}

    Bounds measure(double /*asked_mm*/) override { return prepared_.bounds; }
    void count(double unit_mm) override;
    std::size_t scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                        bool origins) override;

private:
    void find_touched();
    /// The first place in the order of the block whose first number among the touched ones is `begin`.
    std::size_t first_of_touched(std::size_t begin) const noexcept {
        return std::size_t{buckets_.touched[begin / block_triangles]} * block_triangles;
    }

    const detail::PreparedImpl& prepared_;
    const Placing placing_;
    AnySource any_whole_;
    TriangleSource* whole_ = nullptr;  // where planes pass through most blocks
};

}  // namespace lamella
