// Accounts for every triangle of a sliced mesh: what lies between two planes is in no layer.
//
//     const lamella::Result<lamella::Ledger> ledger = lamella::make_ledger(mesh, result);
//     if (ledger) {
//         std::printf("%zu triangles are in no layer\n", static_cast<std::size_t>(ledger->between));
//         for (const lamella::SurfacePiece& piece : ledger->pieces) {
//             std::printf("%s below layer %zu\n", name_of(piece.kind).data(), static_cast<std::size_t>(piece.layer));
//         }
//     }
//
// Between two neighbouring planes (and below the first, and above the last) the surface falls into pieces, connected over
// its vertices. Those that join both planes go on in the layers below and above. The others end here, unseen by one layer or
// both:
//
//     plane ---------------------------+---+---      shell  meets neither plane: a whole part of the mesh
//                   .                   \ /          peak   rises from the plane below and ends before the one above
//             __   / \     shell         v           pit    hangs from the plane above and ends before the one below
//            |  | /   \     <>          pit
//     plane -+--+-+---+---------------------------
//            peaks
//
// Only the surface counts, not which side is solid: the roof of a cavity is a peak too. A part's own bottom is a pit below
// the first plane, and its top a peak above the last.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"

namespace lamella {

enum class SurfacePieceKind : std::uint8_t { shell, peak, pit };

/// "shell", "peak" or "pit".
std::string_view name_of(SurfacePieceKind kind) noexcept;

/// A piece of the surface that does not join two planes.
struct SurfacePiece {
    SurfacePieceKind kind = SurfacePieceKind::shell;
    std::uint64_t layer = 0;        ///< the plane above it, as in Slab
    std::array<double, 3> at_mm{};  ///< a peak's highest vertex, a pit's or shell's lowest; of equals the smallest (x, y)
    double height_mm = 0;           ///< from the plane below or above to there; of a shell, to its highest vertex
    std::uint64_t triangles = 0;    ///< of it that cross no plane; 0 for a tip
    friend bool operator==(const SurfacePiece&, const SurfacePiece&) = default;
};

/// Of one kind.
struct SurfacePieceCount {
    std::uint64_t count = 0;
    std::uint64_t triangles = 0;  ///< that cross no plane
    friend bool operator==(const SurfacePieceCount&, const SurfacePieceCount&) = default;
};

/// What lies between two neighbouring planes and crosses neither.
struct Slab {
    std::uint64_t layer = 0;  ///< the plane above it, as an index into SliceResult::layers; their number: above all planes
    std::uint64_t triangles = 0;  ///< wholly inside, horizontal ones among them
    double flat_up_mm2 = 0;       ///< horizontal faces that face up: where the part ends
    double flat_down_mm2 = 0;     ///< and down: where it begins
    std::uint64_t shells = 0;
    std::uint64_t peaks = 0;
    std::uint64_t pits = 0;
    friend bool operator==(const Slab&, const Slab&) = default;
};

/// triangles = cut + between + degenerate; those between are the slabs', and those of the pieces and of what goes on.
struct Ledger {
    std::uint64_t triangles = 0;
    std::uint64_t cut = 0;  ///< by at least one plane
    std::uint64_t between = 0;
    std::uint64_t degenerate = 0;  ///< two equal vertices on the grid; dropped
    std::uint64_t horizontal = 0;  ///< of those between planes
    double flat_up_mm2 = 0;
    double flat_down_mm2 = 0;
    SurfacePieceCount shells;
    SurfacePieceCount peaks;
    SurfacePieceCount pits;
    std::vector<Slab> slabs;           ///< those that hold something, from below
    std::vector<SurfacePiece> pieces;  ///< all, by layer, kind and place
    std::vector<std::uint64_t> gaps;   ///< layers without a contour that have some below and above
};

/// Counts again, from the mesh and the result's planes alone. `mesh` must be what was sliced. O(n + k) expected for n
/// triangles and k planes, O(log k) a triangle where planes crowd; 8 bytes a triangle and 4 a plane, and 50 a triangle while
/// its slab is examined. The answer does not depend on threads. Errors: those of certify_volume().
Result<Ledger> make_ledger(const MeshView& mesh, const SliceResult& result, const Control& control = {}) noexcept;

}  // namespace lamella
