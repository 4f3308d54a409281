// The topology of a mesh, recovered from its soup: shared vertices, and the facet across each edge. Methods that trace
// contours from facet to facet begin with it. Its time counts as part of theirs.
//
// A half-edge is an edge as one facet runs along it: number 3 f + i leads from corner i of facet f to the next corner.
//
//            c                3 f + 0: a -> b
//          /   \              3 f + 1: b -> c
//        /   f   \            3 f + 2: c -> a
//      a --------- b
//        \   g   /            its twin leads from b to a: it is g's
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry.hpp"

namespace lamella::baselines {

using Corners = std::array<std::uint32_t, 3>;

struct SharedVertices {
    std::vector<GridVertex> vertices;
    std::vector<Corners> facets;

    std::uint32_t from(std::uint32_t half_edge) const noexcept { return facets[half_edge / 3][half_edge % 3]; }
    std::uint32_t to(std::uint32_t half_edge) const noexcept { return facets[half_edge / 3][(half_edge + 1) % 3]; }
};

/// Finds shared vertices by a sorted binary tree, as Béchet, Cuillière and Trochu (2002) do. O(n log n).
SharedVertices share_vertices_by_tree(const std::vector<Facet>& facets);

/// Finds shared vertices by a hash table. O(n) expected.
SharedVertices share_vertices_by_hash(const std::vector<Facet>& facets);

inline constexpr std::uint32_t no_half_edge = 0xFFFFFFFF;

/// The next half-edge around the same facet, and the one after that.
constexpr std::uint32_t next_in_facet(std::uint32_t half_edge) noexcept {
    return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}
constexpr std::uint32_t previous_in_facet(std::uint32_t half_edge) noexcept {
    return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1;
}

/// Pairs the half-edges of an edge that more than two facets share: by angle, as the engine does, so that the contours
/// are the same. If their number is odd, one stays alone. Two of the same direction become a pair only if no other
/// pairing exists.
std::vector<std::pair<std::uint32_t, std::uint32_t>> pair_round_edge(const SharedVertices& mesh,
                                                                     std::span<const std::uint32_t> edge);

/// By half-edge: the half-edge of the neighbouring facet. Empty if some half-edge has no partner of opposite direction,
/// because the mesh is not closed or its facets disagree about which side is solid. O(n), plus sorting for edges of
/// more than two facets.
std::vector<std::uint32_t> find_twins(const SharedVertices& mesh);

/// Runs a method that slices closed meshes only: no contours of others.
template <class Slicer>
WholeOutcome run_on_topology(const Problem& problem, SharedVertices (*share)(const std::vector<Facet>&)) {
    SharedVertices mesh = share(quantised(problem));
    std::vector<std::uint32_t> twins = find_twins(mesh);
    if (twins.empty()) {
        return {.contours = Contours(problem.planes.size())};
    }
    return Slicer(problem, std::move(mesh), std::move(twins)).run();
}

}  // namespace lamella::baselines
