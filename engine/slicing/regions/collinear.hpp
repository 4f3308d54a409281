// Points within straight lines.
#pragma once

#include <cstdint>
#include <span>

#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/origins.hpp"

namespace lamella {

/// Takes the points that lie between their neighbours off a closed contour that has an area, in place; returns how many are
/// left. merge(i, j): edge j, which follows edge i, becomes part of it; move(i, j): edge i becomes edge j. O(points).
template <class Merge, class Move>
std::size_t drop_collinear(std::span<Point> ring, const Merge& merge, const Move& move) noexcept {
    std::size_t left = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        while (left >= 2 && side_of(ring[left - 2], ring[left - 1], ring[i]) == 0) {
            --left;
            merge(left - 1, left);
        }
        ring[left] = ring[i];
        move(i, left++);
    }
    while (left > 3 && side_of(ring[left - 2], ring[left - 1], ring[0]) == 0) {
        --left;
        merge(left - 1, left);
    }
    std::size_t first = 0;
    while (left - first > 3 && side_of(ring[left - 1], ring[first], ring[first + 1]) == 0) {
        merge(left - 1, first++);
    }
    for (std::size_t i = first; i < left && first > 0; ++i) {
        ring[i - first] = ring[i];
        move(i, i - first);
    }
    return left - first;
}

/// The same with the origins of the edges, or null. An edge that several become has the origin of the first of them, or of
/// the last where the contour will be turned round.
inline std::size_t drop_collinear(std::span<Point> ring, PointOrigin* origins, bool will_turn) noexcept {
    if (origins == nullptr) {
        return drop_collinear(
            ring, [](std::size_t, std::size_t) {}, [](std::size_t, std::size_t) {});
    }
    return drop_collinear(
        ring,
        [=](std::size_t into, std::size_t next) {
            origins[into] = stretch_of(origins[will_turn ? next : into], !will_turn, will_turn);
        },
        [=](std::size_t from, std::size_t to) { origins[to] = origins[from]; });
}

}  // namespace lamella
