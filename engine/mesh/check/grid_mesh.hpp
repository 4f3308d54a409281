// The mesh that check() works on: vertices and faces on the grid, in an order that depends on nothing but coordinates.
// Faults found in this order are the same for any order of the input and any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "base/system/atomic_word.hpp"
#include "lamella/array.hpp"
#include "lamella/check.hpp"
#include "lamella/weld.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// Morton order (the Z-order curve) within a box: vertices that follow one another lie close to one another. Its bits take
/// turns:
///
///     x = 1 0 1      key = 1 0 0  0 1 1  1 1 0      of each axis the highest 21 bits that the box has
///     y = 0 1 1            x y z  x y z  x y z
///     z = 0 1 0
class MortonOrder {
public:
    /// In the box of `mesh`, on its grid.
    explicit MortonOrder(const MeshCheck& mesh) noexcept {
        std::int64_t extent = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis] = to_even_grid(mesh.box.min_mm[axis], mesh.grid_mm);
            extent = std::max(extent, std::int64_t{to_even_grid(mesh.box.max_mm[axis], mesh.grid_mm)} - low_[axis]);
        }
        shift_ = std::max(0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(extent))) - axis_bits);
    }

    /// Vertices that are closer than what 21 bits tell apart may have equal keys.
    std::uint64_t key(const GridVertex& v) const noexcept {
        return spread(v.x, low_[0]) << 2 | spread(v.y, low_[1]) << 1 | spread(v.z, low_[2]);
    }

private:
    static constexpr int axis_bits = 21;  ///< three fit 64

    /// Two zeros before each bit.
    std::uint64_t spread(std::int32_t coordinate, std::int64_t low) const noexcept {
        std::uint64_t bits = static_cast<std::uint64_t>(std::max<std::int64_t>(coordinate - low, 0)) >> shift_;
        bits &= 0x1FFFFF;
        bits = (bits | bits << 32) & 0x001F00000000FFFF;
        bits = (bits | bits << 16) & 0x001F0000FF0000FF;
        bits = (bits | bits << 8) & 0x100F00F00F00F00F;
        bits = (bits | bits << 4) & 0x10C30C30C30C30C3;
        return (bits | bits << 2) & 0x1249249249249249;
    }

    std::array<std::int64_t, 3> low_{};
    int shift_ = 0;
};

/// Corners as vertex numbers, the smallest first, in the orientation of the input; and its triangle there.
struct Face {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t source;
};

/// Faces with the same three vertices, in either orientation, have equal keys.
inline std::array<std::uint32_t, 3> vertex_set(const Face& face) noexcept {
    const auto [a, b, c] = face.corners;
    return b < c ? std::array{a, b, c} : std::array{a, c, b};
}

struct GridMesh {
    explicit GridMesh(const Memory* memory) noexcept : vertices(memory), faces(memory) {}

    Array<GridVertex> vertices;   ///< distinct, in Morton order
    Array<Face> faces;            ///< by vertex_set(), then orientation, then source; those with two equal vertices left out
    std::vector<Face> collapsed;  ///< these, in the same order
    double grid_mm = 0;
    bool joined = false;  ///< some vertex stands for corners that differ before rounding

    std::array<GridVertex, 3> corners(const Face& face) const noexcept {
        return {vertices[face.corners[0]], vertices[face.corners[1]], vertices[face.corners[2]]};
    }
};

/// O(n log n), in fourteen calls of run(). `measured` holds the box and the grid. Precondition: indices in range,
/// coordinates within the grid, fewer than 2^32 / 3 triangles. Throws std::bad_alloc.
GridMesh make_grid_mesh(const MeshView& mesh, const Frame& frame, const MeshCheck& measured, const Parallel& parallel);

/// The faces of a mesh whose equal vertices are one, with vertices that have no place.
GridMesh make_exact_mesh(const WeldedMesh& mesh, const Parallel& parallel);

/// The edges of a grid mesh with the faces at each. Sides are numbered 3 * face + corner, each running from that corner to
/// the next.
class EdgeTable {
public:
    struct Edge {
        std::uint32_t lower;
        std::uint32_t upper;
    };

    /// O(n log(faces at a vertex)), in eight calls of run(). `mesh` must outlive the table. Throws std::bad_alloc.
    EdgeTable(const GridMesh& mesh, const Parallel& parallel);

    /// By lower vertex, then upper.
    std::size_t size() const noexcept { return first_sides_.size() - 1; }
    Edge operator[](std::size_t edge) const noexcept;

    /// Ascending.
    std::span<const std::uint32_t> sides(std::size_t edge) const noexcept {
        return {sides_.data() + first_sides_[edge], first_sides_[edge + 1] - first_sides_[edge]};
    }
    static std::uint32_t face_of(std::uint32_t side) noexcept { return side / 3; }

    /// As many faces run one way along the edge as the other.
    bool is_balanced(std::size_t edge) const noexcept {
        const std::span<const std::uint32_t> own = sides(edge);
        const auto forward = std::count_if(own.begin(), own.end(), [&](std::uint32_t side) {
            const auto& corners = mesh_.faces[side / 3].corners;
            return corners[side % 3] < corners[(side % 3 + 1) % 3];
        });
        return 2 * static_cast<std::size_t>(forward) == own.size();
    }

    /// Edges that have not one face on either hand, ascending: one face, or more than two, or two that run the same way.
    const Array<std::uint32_t>& irregular() const noexcept { return irregular_; }
    /// Edges with one face, ascending.
    const std::vector<std::uint32_t>& boundary() const noexcept { return boundary_; }

    /// True if two vertices are joined by an edge. O(log n).
    bool joins(std::uint32_t a, std::uint32_t b) const noexcept;

private:
    const GridMesh& mesh_;
    Array<std::uint32_t> first_sides_;  ///< by edge, and the end of the last
    Array<std::uint32_t> sides_;
    Array<std::uint32_t> irregular_;
    std::vector<std::uint32_t> boundary_;
};

// Vertices whose faces need not be compared with one another: most of a real mesh, and most pairs of faces whose boxes meet.
//
// A vertex has an embedded star where, seen along some axis, its faces lie around it like the sectors of a disc:
//
//        p1 --- p0          Every face is seen from the same side, and every edge at v has one face on either hand, so
//       /  \   /  \         the faces go round v in closed cycles. They go round once in all: the ray from v to the right
//     p2 --- v -.-.- ->     lies in one of them. Then no two overlap in this view, and what two share in the view is an
//       \  /   \  /         edge or v. So they share nothing else in space.
//        p3 --- p4
//
// A face p, q at v that is seen counter-clockwise holds the ray if p lies no higher than v and q above it.

class EmbeddedStars {
public:
    /// O(n), in three calls of run(). Throws std::bad_alloc.
    EmbeddedStars(const GridMesh& mesh, const EdgeTable& edges, const Parallel& parallel)
        : mesh_(mesh), words_(parallel.memory()), areas_(parallel.memory()) {
        words_.resize_discarding(mesh.vertices.size());
        areas_.resize_discarding(mesh.faces.size());
        parallel.run_ranges(words_.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            std::fill(words_.begin() + begin, words_.begin() + end, every_view);
        });
        for (const std::uint32_t edge : edges.irregular()) {
            words_[edges[edge].lower] = 0;
            words_[edges[edge].upper] = 0;
        }
        find_views(parallel);
        count_rounds(parallel);
    }

    /// True if the vertex is known to have one: then its faces form one closed fan, and no two meet but in an edge or vertex
    /// that they share.
    bool contains(std::uint32_t vertex) const noexcept {
        return (words_[vertex] & ~every_view) == one_round && (words_[vertex] & every_view) != 0;
    }

    /// True if a face has area.
    bool has_area(std::size_t face) const noexcept { return areas_[face] != 0; }

private:
    using Word = std::uint32_t;
    /// The low bits: from which ends of the axes all faces so far are seen in front. The others count faces that hold the
    /// ray.
    static constexpr Word every_view = 0x3F;
    static constexpr Word one_round = 0x40;
    static constexpr std::size_t grain = std::size_t{1} << 14;

    /// Bit 2 * axis where the face is seen counter-clockwise from the axis's upper end, the next bit where from its lower
    /// end.
    static Word views_of(const std::array<GridVertex, 3>& corners) {
        const GridVector a = half(corners[0]);
        const GridVector normal = cross(half(corners[1]) - a, half(corners[2]) - a);
        const auto ends = [](std::int64_t component) { return component > 0 ? 1U : component < 0 ? 2U : 0U; };
        return ends(normal.x) | ends(normal.y) << 2 | ends(normal.z) << 4;
    }

    /// The coordinate that points upwards in a view along the axis, to whose right the axis after it points.
    static std::int32_t height_in(std::size_t axis, const GridVertex& v) { return axis == 0 ? v.z : axis == 1 ? v.x : v.y; }

    void find_views(const Parallel& parallel) {
        parallel.run_ranges(mesh_.faces.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i != end; ++i) {
                const Face& face = mesh_.faces[i];
                const Word views = views_of(mesh_.corners(face));
                areas_[i] = views != 0 ? 1 : 0;
                for (const std::uint32_t vertex : face.corners) {
                    AtomicWord<Word>(words_[vertex]).keep(views);
                }
            }
        });
    }

    void count_rounds(const Parallel& parallel) {
        parallel.run_ranges(mesh_.faces.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i != end; ++i) {
                const Face& face = mesh_.faces[i];
                const std::array<GridVertex, 3> corners = mesh_.corners(face);
                for (std::size_t corner = 0; corner < 3; ++corner) {
                    const AtomicWord<Word> word(words_[face.corners[corner]]);
                    const Word now = word.load();
                    if ((now & every_view) == 0 || now >= 2 * one_round) {
                        continue;
                    }
                    const auto view = static_cast<std::size_t>(std::countr_zero(now));
                    const std::int32_t v = height_in(view / 2, corners[corner]);
                    std::int32_t p = height_in(view / 2, corners[corner == 2 ? 0 : corner + 1]);
                    std::int32_t q = height_in(view / 2, corners[corner == 0 ? 2 : corner - 1]);
                    if (view % 2 != 0) {
                        std::swap(p, q);
                    }
                    if (p <= v && v < q) {
                        word.add(one_round);
                    }
                }
            }
        });
    }

    const GridMesh& mesh_;
    Array<Word> words_;          ///< by vertex
    Array<std::uint8_t> areas_;  ///< by face: 1 where it has one
};

}  // namespace lamella
