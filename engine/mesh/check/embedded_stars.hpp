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

#include <cstdint>

#include "mesh/check/edge_table.hpp"

namespace lamella {

class EmbeddedStars {
public:
    /// O(n), in three calls of run(). Throws std::bad_alloc.
    EmbeddedStars(const GridMesh& mesh, const EdgeTable& edges, const Parallel& parallel);

    /// True if the vertex is known to have one: then its faces form one closed fan, and no two meet but in an edge or vertex
    /// that they share.
    bool contains(std::uint32_t vertex) const noexcept {
        return (words_[vertex] & ~every_view) == one_round && (words_[vertex] & every_view) != 0;
    }

    /// True if a face has area.
    bool has_area(std::size_t face) const noexcept { return areas_[face] != 0; }

private:
    using Word = std::uint32_t;
    static constexpr Word every_view =
        0x3F;  ///< the low bits: from which ends of the axes all faces so far are seen in front
    static constexpr Word one_round = 0x40;  ///< the others count faces that hold the ray

    void find_views(const Parallel& parallel);
    void count_rounds(const Parallel& parallel);

    const GridMesh& mesh_;
    Array<Word> words_;          ///< by vertex
    Array<std::uint8_t> areas_;  ///< by face: 1 where it has one
};

}  // namespace lamella
