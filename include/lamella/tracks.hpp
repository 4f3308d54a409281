// Islands followed from layer to layer: where they begin, merge, split and end, and what they enclose.
//
//     const auto tracks = lamella::find_tracks(result, {.pockets = true});
//     if (tracks) {
//         for (const lamella::Track& island : tracks->islands) {
//             if (island.below == 0 && island.layer > 0) {
//                 std::printf("layer %llu: supports at %g, %g\n", (unsigned long long)island.layer,
//                             island.centroid_mm[0], island.centroid_mm[1]);
//             }
//         }
//         for (const lamella::Pocket& pocket : tracks->pockets) {
//             std::printf("%s of %g mm3\n", pocket.is_cavity ? "cavity" : "cup", pocket.volume_mm3);
//         }
//     }
//
// An island is an outer contour with its holes. Two islands of neighbouring layers are linked if they share area; those that
// touch in points or along edges only are not:
//
//     layer 2    [    D    ]         links: A-B, B-D, C-D
//     layer 1    [ B ] [ C ]         A stands on the bed, C begins in the air: below == 0
//     layer 0    [ A ]               D merges B and C: below == 2; what splits has above > 1
//
// A void is a hole without the islands in it, or what lies outside of all. Voids that touch in points hang together, as in a
// region's contours. A pocket is what voids of neighbouring layers that share area enclose, as seen from below: a cavity is
// closed all around; a cup was closed up to a layer where it meets the outside, as a bowl's inside does at its rim. What is
// open at the lowest layer, a tube, is no pocket.
#pragma once

#include <array>
#include <cstdint>

#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/result.hpp"

namespace lamella {

struct TrackOptions {
    bool pockets = false;  ///< Tracks::pockets are found, which takes longer
};

/// An island. 64 bytes.
struct Track {
    std::uint64_t layer = 0;              ///< index into SliceResult::layers
    std::uint64_t contour = 0;            ///< index of its outer into SliceResult::contours
    double area_mm2 = 0;                  ///< without its holes; 0 where these leave nothing, as of contours that cross
    std::array<double, 2> centroid_mm{};  ///< its centre of mass; where there is no area the outer's start
    std::uint32_t first_above = 0;        ///< Tracks::links [first_above, first_above + above) lead up from it
    std::uint32_t above = 0;              ///< 0: it ends here; more than 1: it splits
    std::uint32_t first_below = 0;        ///< Tracks::links_by_upper [first_below, first_below + below) lead down from it
    std::uint32_t below = 0;              ///< 0: it begins here; more than 1: it merges
    std::uint32_t body = 0;               ///< islands that links connect have one number; ascending by first island
    std::uint32_t reserved = 0;
};

/// Two islands that share area, as indices into Tracks::islands.
struct TrackLink {
    std::uint32_t lower = 0;
    std::uint32_t upper = 0;
};

struct Pocket {
    std::uint64_t contour = 0;      ///< a hole of its lowest layer, the first: index into SliceResult::contours
    std::uint64_t first_layer = 0;  ///< it has layers [first_layer, end_layer)
    std::uint64_t end_layer = 0;    ///< a cup meets the outside in this layer, or above all of them
    double volume_mm3 = 0;          ///< areas of voids times the heights of their slabs
    bool is_cavity = false;         ///< closed above; false: a cup
    std::array<std::uint8_t, 7> reserved{};
};

struct Tracks {
    explicit Tracks(const Memory* memory = nullptr) noexcept
        : islands(memory), links(memory), links_by_upper(memory), pockets(memory) {}

    Array<Track> islands;                 ///< by layer and contour
    Array<TrackLink> links;               ///< by lower, then upper
    Array<std::uint32_t> links_by_upper;  ///< indices of links by upper, then lower
    Array<Pocket> pockets;                ///< by end_layer, then first_layer and contour
    std::uint64_t bodies = 0;
};

/// Layers are regions: those of RegionRules, of Overlay::combine(), and others as far as their contours do not cross. Where
/// contours of a layer do cross, or those of several parts lie in one another, what a contour's edges have on their left
/// counts, and of islands around one that they do not touch the smallest. Flat contours are left out. Links are exact, and
/// do not depend on threads or on the order of contours but for the order of islands.
///
/// Pairs of layers in parallel: O(q log q + c) for two layers of q points with c pairs of edges whose boxes meet; memory O(q
/// log q) for each thread, O(contours + links), and 40 bytes a contour. Errors: invalid_argument (an open contour, with its
/// layer; points beyond grid_limit; negative threads), result_too_large (2^32 - 1 contours, or links beyond the context's
/// limit), out_of_memory, cancelled.
Result<Tracks> find_tracks(const SliceResult& stack, const TrackOptions& options = {}, const Context& context = {}) noexcept;

}  // namespace lamella
