// Everything that can be asked of a slice. Written for the most part by engine/options/generate.py from options.toml there.
//
//     lamella::SliceOptions options;
//     options.layer_height_mm = 0.1;                                   // a plane every 0.1 mm, or
//     options.heights_mm = std::vector<double>{1.5, 2, 7.25};          // planes at these heights
//     options.stitch_mm = lamella::stitch_by_mesh;                     // close what the mesh left open
//     options.region.fill_rule = lamella::FillRule::non_zero;          // unite what overlaps
//     options.region.closing_mm = 0.049;                               // and fill narrow gaps
//
// Layers. A layer is a slab of material with a bottom, a top and one plane between them, whose cross-section stands for the
// slab. Heights are absolute, in mm along the slicing direction. Every plane's height is computed by itself (z0 + i·h, never
// by adding rounded steps), rounded first exactly as a vertex of that height would be (to the mesh's number type, then to
// the even grid), then moved one unit down (PlaneSide::below, the default) or up. A flat face drawn at that very height is
// therefore always on the same side of it.
//
// Stitching. Ends of open polylines are joined nearest first. By the mesh's own length, stitch_by_mesh, no joint longer than
// a tenth of it crosses a contour of its layer or a shorter joint; a length that is given joins whatever lies between.
//
//       .-------------.     .-------------.      .----------.    An end to a start: `ab`.
//       |             |     |             |      |    ||    |    Where a wall lies between them, they stay open: `cd`.
//       '----a   b----'     '----a---b----'      '---c||d---'
//
// Regions. The steps follow in this order; each is left out where it is not asked for:
//
//     fill_rule       contours that meet are cut where they cross; what bounds the region is kept
//     closing_mm      dilated, then eroded by as much: gaps under twice that are filled
//     offset_mm       dilated, or eroded where it is negative
//     outermost       holes, and what lies in them, go
//     largest_only    all but the outer contour of the largest area, with its holes, go
//     drop_collinear  points within straight lines go
//     simplify_mm     points within so much of the lines that replace them go
//     flag_closing_mm contours that closing would change now are flagged
//
// Contents. What upward and downward faces project onto each layer: its top and bottom surfaces. Planes cut the faces into
// pieces. A piece projects straight down or up to the nearest plane on the side of its solid, which lies below an upward
// face and above a downward one:
//
//                    .---.                  upward: to plane 2
//     plane 2   -----|---|-------------
//                    |   '.                 upward, cut in two by plane 1: to planes 1 and 0
//     plane 1   -----|-----'.----------
//                    '--.    '.             downward: to plane 1
//     plane 0   --------|-----|--------
//                       '-----'             downward: to plane 0
//
// So the upward faces of a closed mesh between planes i and i + 1 are the top surface of layer i: where nothing overhangs
// between these planes, what layer i has and layer i + 1 has not. Upward pieces below the lowest plane and downward pieces
// above the highest one project to none. A horizontal face at a plane's very height lies where a vertex of that height does:
// by PlaneSide::below above the plane.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

/// Asked for as SliceOptions::stitch_mm: a hundredth of the diagonal of the mesh's box, after the transform; of several
/// parts each has its own. For meshes that lack faces here and there, as most bones of an atlas do.
inline constexpr double stitch_by_mesh = -1;

/// PlaneOptions::end_layer where all are cut.
inline constexpr std::uint64_t all_layers = std::numeric_limits<std::uint64_t>::max();

// begin choices
/// Which ends of open polylines may be stitched. Pairs are joined by distance, the nearest first, and at most one to each
/// end.
enum class StitchDirection : std::uint8_t {
    /// An end to a start: every polyline keeps its orientation.
    oriented,
    /// Also two ends or two starts, for facets that disagree: one of the two polylines is turned round. Of equally near
    /// pairs those that keep the orientation come first.
    any,
};
/// What a layer shows: the section at its plane, or what faces project onto it.
enum class LayerContent : std::uint8_t {
    /// The cross-section at the plane.
    section,
    /// The region that upward faces project down onto the plane: top surfaces.
    upward_faces,
    /// The region that downward faces project up onto the plane: bottom surfaces.
    downward_faces,
};
enum class Datum : std::uint8_t { mesh_min, zero };
enum class PlaneSide : std::uint8_t { below, above };
/// What is solid where contours overlap, nest in the same direction or run backwards. A point's winding number is how many
/// times contours run counter-clockwise around it.
enum class FillRule : std::uint8_t {
    /// The contours as the mesh gives them: nothing is joined or cut.
    contours,
    /// Solid within an odd number of contours.
    even_odd,
    /// Solid where the winding number is not 0.
    non_zero,
    /// Solid where the winding number, by the facets' orientation, is more than 0.
    positive,
    /// As non-zero, without holes.
    outermost,
};
// end choices

/// As the tool and Python spell it: "even-odd".
std::string_view name_of(StitchDirection direction) noexcept;
std::string_view name_of(LayerContent content) noexcept;
std::string_view name_of(Datum datum) noexcept;
std::string_view name_of(PlaneSide side) noexcept;
std::string_view name_of(FillRule rule) noexcept;

/// From this layer on another rule.
struct FillFrom {
    std::uint64_t first_layer = 0;  ///< among those of the plan
    FillRule rule = FillRule::contours;
    friend bool operator==(const FillFrom&, const FillFrom&) = default;
};

/// The material between two heights, which a layer stands for.
struct Slab {
    double bottom_mm = 0;
    double top_mm = 0;
    friend bool operator==(const Slab&, const Slab&) = default;
};

/// Where planes lie.
struct PlaneOptions {
    // begin PlaneOptions
    /// Height of the first plane above the datum; not given, half a layer.
    std::optional<double> first_height_mm{};
    /// Where heights of uniform layers count from: the mesh's lowest vertex, or z = 0.
    Datum datum = Datum::mesh_min;
    /// Where a plane passes a vertex of exactly its height.
    PlaneSide side = PlaneSide::below;
    /// Cut the layers of the plan from this one on only; they have the bytes that they have in the whole.
    std::uint64_t first_layer = 0;
    /// One past the last layer that is cut; may lie beyond the plan's end.
    std::uint64_t end_layer = all_layers;
    // end PlaneOptions
    friend bool operator==(const PlaneOptions&, const PlaneOptions&) = default;
};

/// The space of planes and points: shared by slice(), prepare(), check() and the result.
struct Frame {
    // begin Frame
    /// From the mesh in mm to the space of planes and points: planes are horizontal after it.
    Transform transform{};
    /// Step of the integer grid; 0: 2^-20 mm, doubled until the mesh fits. finest_grid: the finest that it fits.
    double grid_mm = 0;
    /// A grid that is too fine for the mesh is doubled until it fits, instead of refused.
    bool coarser_if_needed = false;
    /// The transform is computed in floats where the mesh has floats, and heights are rounded to floats. A host that moves
    /// meshes of floats by a matrix of floats has flat faces where float arithmetic puts them, and asks for planes there. In
    /// double the same faces lie up to half a step of float beside them, so that a face on a plane may be missed; by this it
    /// never is.
    bool as_mesh_numbers = false;
    // end Frame
    friend bool operator==(const Frame&, const Frame&) = default;
};

/// What is done to the closed contours of a layer. Open polylines bound nothing: they are left as they are, and
/// SliceInfo::open_contours counts them. Layers of which nothing is left are empty; SliceInfo::emptied_layers counts them.
/// Closing, offset, largest_only and drop_collinear need a rule other than `contours` in every layer.
///
/// All rules but `contours` change contours: one that meets no other is kept as it is, or dropped; those that meet are cut,
/// and the points where they cross are rounded to the grid. Every point of the region lies within a unit per axis of a point
/// of the exact one, and the two differ only within a unit of the contours' edges. The bytes do not depend on the order of
/// contours, their starts, threads or the platform.
///
/// Lengths are 0, which does nothing, or at least a grid unit. Edges are moved one by one, with miter joins. What they may
/// reach must lie on the grid: the farthest coordinate plus max(2, miter_limit) times the larger of closing_mm + |offset_mm|
/// and flag_closing_mm is at most grid_limit units. What cannot be done is invalid_argument before anything is cut.
struct RegionRules {
    // begin RegionRules
    /// What is solid where contours overlap, nest in the same direction or run backwards. A point's winding number is how
    /// many times contours run counter-clockwise around it.
    FillRule fill_rule = FillRule::contours;
    /// Fill gaps narrower than twice this, between contours and within one. Contours that closing would give back are not
    /// touched.
    double closing_mm = 0;
    /// Grow what is solid by so much, or shrink it where negative. What is thinner than twice a negative offset vanishes.
    double offset_mm = 0;
    /// Cut corners off that closing or offset would move farther than so many times its length.
    double miter_limit = 3;
    /// Drop points that lie within so much of the lines left, last of all. In whole grid units; the line lies as near to the
    /// contour that was. Any fill rule will do; open polylines are simplified too. Starts, ends of polylines, three points
    /// of a closed contour and the sign of its area stay; contours without area stay whole. No line crosses or touches
    /// another edge, or passes a contour by on the other side: where it would, and where contours met before, points stay.
    /// Contour::segments stays too, but for contours that were made, whose edges it counts. Layers stay whole where edges
    /// come near one another so often that to compare them would take more than O(m log m) for m points.
    double simplify_mm = 0;
    /// Flag contours that closing by so much would change, and change nothing. They get ContourFlag::would_close; any fill
    /// rule will do. A contour is flagged where its offset by so much meets itself or the offset of another contour (closer
    /// than twice so much, by miters from farther), turns an edge round (a hole or notch that is narrower, a short edge
    /// between two inner corners), or passes the miter limit at an inner corner (a sharp notch). Closing gives back those
    /// without the flag to the unit.
    double flag_closing_mm = 0;
    /// Drop points exactly on the line between their neighbours.
    bool drop_collinear = false;
    /// Keep the outer contour of the largest area of a layer only, with its holes; of equal areas the one that starts first.
    bool largest_only = false;
    /// Other fill rules from these layers of the plan on, ascending.
    std::vector<FillFrom> fill_from{};
    // end RegionRules

    FillRule rule_of(std::uint64_t layer) const noexcept;
    /// Whether every layer keeps its contours as the mesh gives them, but for simplify_mm.
    bool keeps_contours() const noexcept;
    /// Whether nothing at all is done.
    bool leaves_contours() const noexcept { return keeps_contours() && simplify_mm == 0 && flag_closing_mm == 0; }
    friend bool operator==(const RegionRules&, const RegionRules&) = default;
};

struct SliceOptions {
    // begin SliceOptions
    /// Height of uniform layers. The first plane lies in the middle of the lowest layer, or at planes.first_height_mm; only
    /// planes strictly inside the mesh's z range are kept.
    double layer_height_mm = 0.2;
    /// Cut at these heights instead, in any order; an empty list cuts nothing. Heights that round to one plane share one
    /// layer, whose plane_mm is the least of them: SliceInfo::layer_of names the layer of each. Heights outside the mesh
    /// give empty layers. Without slabs, a layer reaches from the middle between its plane and the one below to the middle
    /// between it and the one above.
    std::optional<std::vector<double>> heights_mm{};
    /// Bottoms and tops of the layers, which are kept; a plane lies in the middle of each, or at the heights given, one in
    /// each. adaptive_layers() finds some. Empty: none are given. A layer of several heights reaches from the lowest of
    /// their bottoms to the highest of their tops.
    std::vector<Slab> slabs{};
    /// Join ends of open polylines at most so far apart, the nearest first; 0 joins none. stitch_by_mesh: a hundredth of the
    /// diagonal of the mesh's box. Each joint is listed in SliceResult::stitches.
    double stitch_mm = 0;
    /// Which ends of open polylines may be stitched. Pairs are joined by distance, the nearest first, and at most one to
    /// each end.
    StitchDirection stitch_direction = StitchDirection::oriented;
    /// Say which triangle each contour edge comes from. SliceResult::origins lists them.
    bool origins = false;
    /// The rules of regions are done to all parts of a layer together, and not to each by itself. No layer's fill rule may
    /// then be `contours`. A contour names the part that all its edges come from, or several_parts.
    bool unite_parts = false;
    /// Copies of a part (Part::at_mm) at one height share the contours of the first of them. The result has these alone,
    /// once, and SliceInfo::copies says where the others stand: nothing but the host's own code reads that, so that files,
    /// audits and overlays have the first copies only. Without it each copy is written out. Not with unite_parts or origins.
    bool share_copies = false;
    /// A mesh without triangles, or of which none is left on the grid, is no error. Given heights then give empty layers,
    /// other plans none. The box of a mesh without triangles is a point at zero.
    bool allow_empty = false;
    /// What a layer shows: the section at its plane, or what faces project onto it.
    LayerContent content = LayerContent::section;
    // end SliceOptions
    PlaneOptions planes{};
    Frame frame{};
    RegionRules region{};
    friend bool operator==(const SliceOptions&, const SliceOptions&) = default;
};

}  // namespace lamella
