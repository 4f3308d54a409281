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
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/atomic_word.hpp"
#include "mesh/check/grid_mesh.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

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
