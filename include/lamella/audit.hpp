// Is the result right?
//
//     const lamella::Result<lamella::Audit> found = lamella::audit(result, mesh);
//     if (found && found->volume->verdict == lamella::VolumeVerdict::holds) {
//         std::printf("certified: %g mm3\n", found->volume->mesh_mm3);
//     }
//
// Five questions, each asked alone or with others by AuditOptions:
//
//     question                                              answer      needs      costs
//     of which layers is the area not known, what helps?    open        result     a hundredth of a slice
//     do areas and volumes agree with the mesh?             volume      the mesh   about a slice
//     which triangles does no layer show, and where?        ledger      the mesh   about a slice
//     where do contours run through one another?            crossings   result     about a slice
//     is it as slice() makes results?                       structure   result     a tenth of a slice
//
// `open` and `volume` are for every slice that has to be right; `ledger` where thin parts matter, that lie between two
// planes; `crossings` where check() has not looked for crossing faces, which takes longer. `structure` is for tests, and for
// results that were read or changed: it holds for every result as slice() returns it. Each is computed otherwise than
// slicing does it.
//
// The ledger. Between two neighbouring planes (and below the first, and above the last) the surface falls into pieces,
// connected over its vertices. Those that join both planes go on in the layers below and above. The others end here, unseen
// by one layer or both:
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
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "lamella/source.hpp"

namespace lamella {

struct OpenLayers {
    std::uint64_t layers = 0;   ///< with open polylines
    std::uint64_t crossed = 0;  ///< layers that the mesh crosses
    std::uint64_t stuck = 0;    ///< of `layers`: those that stay open however far apart ends may be joined
    double height_mm = 0;       ///< of `layers`, from bottom to top
    double crossed_mm = 0;      ///< of `crossed`
    double reach_mm = 0;        ///< SliceOptions::stitch_mm that closes all but `stuck`, and what is closed already

    /// The share of the crossed height that `layers` stand for; of the crossed layers where these have no height.
    double share() const noexcept;
    /// Adds the layers of another range. Sums depend on the order in their last bits.
    void add(const OpenLayers& other) noexcept;
};

/// What one layer adds, its open polylines joined nearest first, each part by itself. O(contours), and for o open ones
/// O(o log o) unless they lie so that searches are slow. Errors: out_of_memory, cancelled.
Result<OpenLayers> find_open_layer(const LayerView& layer, StitchDirection direction = StitchDirection::oriented,
                                   const Context& context = {}) noexcept;

/// "37 of 412 layers (8.1 % of the height) have open contours: their area is not known; --stitch 0.73 would close
/// them", where `option` is what stands before the length, here "--stitch ". The length is reach_mm, rounded up to two
/// digits. May throw std::bad_alloc.
std::string describe(const OpenLayers& open, std::string_view option);

enum class VolumeVerdict : std::uint8_t {
    holds,
    areas_differ,    ///< some layer's contours enclose another area than the mesh has there
    volumes_differ,  ///< the slabs do not sum to the mesh's volume
    open_mesh,       ///< does not apply: some edge has more faces one way than the other, so there is no volume
    not_as_walked,   ///< does not apply: stitches, or rules other than FillRule::non_zero, changed the contours
    solid_differs,   ///< by FillRule::non_zero some layers' solid area is not what the mesh encloses there
};

/// "holds", "areas differ", ..., "solid is not what the mesh encloses".
std::string_view name_of(VolumeVerdict verdict) noexcept;

/// Computes the cross-section at every plane and the volume of every slab by Gauss's theorem, from what the faces and parts
/// of faces below each height cover seen from above; nothing is shared with the stages of slicing but the rounding to the
/// grid. A layer agrees if the area of its points is within what moving each point by half a unit along both axes can
/// change:
///
///     (|dx| + |dy|) / 2 summed over its edges, and a quarter for each crossed triangle
///
/// which is at most one unit x perimeter where edges are longer than a unit; three times that in a
/// layer whose contours FillRule::non_zero has cut. Volumes agree if they differ by at most 1e-12
/// of the mesh's, or by what rounding each face's share to 2^-49 of itself can change where that is more (shells that
/// cancel). A mesh is taken for closed if the sum of its directed edges' hashes vanishes, which an open one's does with a
/// chance of 2^-64.
///
/// Areas and volumes count a region as often as shells wind around it, by the orientation of the facets: what an inverted
/// shell encloses is negative.
struct VolumeCertificate {
    VolumeVerdict verdict = VolumeVerdict::open_mesh;
    OpenLayers open;  ///< of the result: which layers have no area to be compared
    /// Sum of signed tetrahedra, exact but for one rounding; NaN for an open mesh, of which all below is not known.
    double mesh_mm3 = std::numeric_limits<double>::quiet_NaN();
    /// Sum of `slab_mm3`; differs from mesh_mm3 by at most 1e-12 of it, but for rounding.
    double slabs_mm3 = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> slab_mm3;   ///< [i]: between planes i - 1 and i; the first and last: below and above all planes
    std::uint64_t worst_layer = 0;  ///< where area and contours differ most, as a share of what rounding allows; the lowest
    double worst_difference_mm2 = 0;
    double worst_allowed_mm2 = 0;
    /// Of solid_differs: in how many layers, and in those what the mesh encloses by the orientation of its facets and what
    /// is solid. Of a mesh turned inside out as a whole the opposite of what it encloses counts.
    std::uint64_t differing_layers = 0;
    double differing_signed_mm2 = 0;
    double differing_solid_mm2 = 0;

    bool applies() const noexcept { return verdict <= VolumeVerdict::volumes_differ; }
};

/// "certified", or "not certified: " and why; where solid_differs, with both areas.
std::string words_for(const VolumeCertificate& certificate);

enum class SurfacePieceKind : std::uint8_t { shell, peak, pit };

/// "shell", "peak" or "pit".
std::string_view name_of(SurfacePieceKind kind) noexcept;

/// A piece of the surface that does not join two planes.
struct SurfacePiece {
    SurfacePieceKind kind = SurfacePieceKind::shell;
    std::uint64_t layer = 0;        ///< the plane above it, as in LedgerSlab
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
struct LedgerSlab {
    std::uint64_t layer = 0;  ///< the plane above it, as an index into SliceResult::layers; their number: above all planes
    std::uint64_t triangles = 0;  ///< wholly inside, horizontal ones among them
    double flat_up_mm2 = 0;       ///< horizontal faces that face up: where the part ends
    double flat_down_mm2 = 0;     ///< and down: where it begins
    std::uint64_t shells = 0;
    std::uint64_t peaks = 0;
    std::uint64_t pits = 0;
    friend bool operator==(const LedgerSlab&, const LedgerSlab&) = default;
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
    std::vector<LedgerSlab> slabs;     ///< those that hold something, from below
    std::vector<SurfacePiece> pieces;  ///< all, by layer, kind and place
    std::vector<std::uint64_t> gaps;   ///< layers without a contour that have some below and above
};

/// Where a layer has so many, no more are searched for.
inline constexpr std::uint64_t most_crossings_in_layer = 4096;

/// The crossings in one layer that has any.
struct LayerCrossings {
    std::uint64_t layer = 0;  ///< index into SliceResult::layers
    std::uint64_t count = 0;
    bool at_least = false;                        ///< the search was cut short
    Point first;                                  ///< the one with the smallest x, then y, rounded to the grid
    std::array<std::uint64_t, 2> contours{0, 0};  ///< that cross there, as indices into SliceResult::contours, ascending
};

/// Counts where one path goes from one side of another to the other, exactly, on the points of the result: edges whose
/// insides cross, and corners in which a path passes through another's edge or corner. A path that only touches another, or
/// runs along a stretch of it, does not cross it there. The end of an open polyline crosses nothing. An outline that is
/// traced twice, as flat contours may be, crosses another twice.
struct Crossings {
    std::uint64_t count = 0;
    bool at_least = false;
    std::vector<LayerCrossings> layers;  ///< ascending
};

/// Which questions are asked.
struct AuditOptions {
    bool open = true;
    bool volume = true;
    bool ledger = true;
    bool crossings = true;
    bool structure = false;
};

/// The answers to what was asked; those that need the mesh are left out without it.
struct Audit {
    std::optional<OpenLayers> open;
    std::optional<VolumeCertificate> volume;
    std::optional<Ledger> ledger;
    std::optional<Crossings> crossings;
    /// The first promise of result.hpp that is broken (invalid_argument, with the layer as Error::plane): offsets
    /// contiguous, contours closed and in their order, oriented as their role says, areas exact, parents around their
    /// children and nested where contours do not cross, layers ordered, no segment lost. Of origins it looks at how many
    /// they are, their parts and edges, and with the mesh at the triangles: the plane cuts the edges that are named, and the
    /// point lies on them.
    std::optional<Status> structure;
};

/// `mesh` must be what was sliced: a MeshView, or for `structure` alone also a list of parts.
///
/// n triangles, k planes, m crossings: O(n + k + m) for open, volume and ledger, with 96 bytes a plane and thread, 8 bytes a
/// triangle, and 50 a triangle while its slab is examined; O(m log m + c) a layer of m edges with c crossings, of which at
/// most most_crossings_in_layer are counted; O(m log m) for the structure, on the calling thread. A layer that takes more
/// than 64 steps an edge for each bit of m (from 2^17 points on: one of its 64 shares more than an eighth of that) is not
/// searched for crossings to its end, and then has `at_least` so many. All sums are of integers, and the answers do not
/// depend on threads. Errors: invalid_argument (the mesh has not the result's number of triangles, or does not fit its grid;
/// layers, contours and points do not follow one another; negative threads), out_of_memory, cancelled.
Result<Audit> audit(const SliceResult& result, const Source& mesh = MeshView{}, const AuditOptions& questions = {},
                    const Context& context = {}) noexcept;

}  // namespace lamella
