// What slicing gives: layers, contours and points.
//
//     for (const lamella::Layer& layer : result.layers) {
//         std::printf("z %g mm: %g mm2\n", layer.plane_mm, result.area_mm2(layer));
//         for (const lamella::Contour& contour : result.contours_of(layer)) {
//             for (const lamella::Point& point : result.points_of(contour)) {
//                 const lamella::PointMm mm = result.to_mm(point);
//                 std::printf("  %g %g\n", mm.x, mm.y);
//             }
//         }
//     }
//
// Three flat arrays, in one order that does not depend on threads, bands, or the order of triangles and of their vertices:
//
//     layers    [ L0 | L1 | L2 | ... ]              one per plane, ascending
//                 |    `------.
//     contours  [ outer, hole | outer | ... ]       per layer by start, each outer followed by its holes
//                 |      `--------.
//     points    [ x y, x y, x y | x y, x y, ... ]   per contour, from its start, solid on the left
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lamella/array.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/integer128.hpp"
#include "lamella/memory.hpp"
#include "lamella/mesh.hpp"
#include "lamella/planes.hpp"
#include "lamella/region.hpp"

namespace lamella {

enum class Role : std::uint8_t {
    outer,  ///< closed, counter-clockwise, solid inside
    hole,   ///< closed, clockwise, solid outside
    flat,   ///< closed without area; takes no part in nesting
    open,   ///< a polyline: the mesh lacks a face at both of its ends
};

/// Bits of Contour::flags.
enum ContourFlag : std::uint16_t {
    /// The facets' orientation gives a winding number below zero here or around here: an inverted shell, a flipped patch.
    /// The role was decided by the number of contours around, and the points run as the role demands.
    orientation_overruled = 1,
    /// Neighbouring facets disagree about which side is solid, or polylines that were joined over gaps by GapSense::any;
    /// the contour runs as most of its segments do.
    orientation_mixed = 2,
    /// Ends of open polylines were joined; see SliceResult::closed_gaps.
    gap_closed = 4,
    /// Closing by RegionRules::mark_near_mm would change it: it comes within twice that of another contour or of itself.
    near_contour = 8,
};

/// The part of a contour whose edges come from more than one.
inline constexpr std::uint32_t several_parts = 0xffffffff;

/// What the rules of regions are done to where there are several meshes.
enum class PartRegions : std::uint8_t {
    separate,  ///< each part by itself: contours of parts may overlap
    united,    ///< all parts of a layer together
};

/// 48 bytes. A closed contour starts at its smallest (x, y, mesh edge), edges in the order of EndKey, and the first point is
/// not repeated; an open one starts at its source end. Equal consecutive points are stored once; `segments` still counts
/// every crossed triangle.
struct Contour {
    std::uint64_t first_point = 0;  ///< index into SliceResult::points
    Integer128 twice_area;          ///< square grid units; positive for outer, negative for hole, 0 for flat and open
    std::int64_t parent = -1;  ///< index into SliceResult::contours: the smallest closed contour strictly around the start
                               ///< point (by a fill rule: the one that it lies directly in); -1 if none
    std::uint32_t point_count = 0;
    std::uint32_t segments = 0;
    Role role = Role::outer;
    std::int8_t orientation = 0;  ///< by the facets or the fill rule: 1 counter-clockwise, -1 clockwise, 0 flat, open
    std::uint16_t flags = 0;      ///< ContourFlag bits
    std::uint32_t part = 0;       ///< index of the mesh that it comes from, among those of slice_parts(), or several_parts
};

inline constexpr std::uint32_t no_triangle = 0xffffffff;
inline constexpr std::uint8_t no_edge = 3;  ///< edge e of a triangle leads from corner e to corner (e + 1) % 3

/// Where a point and the contour edge that begins at it come from. 8 bytes.
///
///           2              The plane cuts `triangle` from p to q: the contour edge. p lies on the triangle's edge `edge`,
///          / `.            here 2, and q on `end_edge`, here 1.
///         p----q
///        /      `.
///       0---------1
///
/// Of several triangles with the same corners on the grid, in the same order around, the one with the smallest index stands
/// for all. The last point of an open polyline names the triangle of the contour edge that ends there; no `end_edge`.
///
/// Equal consecutive points: the edge that has a length counts, that of the last of them. A contour that was turned round
/// against its facets: each edge keeps its triangle, and `edge` and `end_edge` change places. An edge that joins a gap comes
/// from no triangle.
///
/// Regions: a contour that no step changes keeps its origins. An edge along an edge of a given contour keeps its triangle,
/// the one of the smallest part and index where there are several; `edge` or `end_edge` is there only where the mesh's edge
/// makes the point, not a crossing of contours. Of contours equal in every point the first stands for all. What closing and
/// offset move comes from no triangle. Where drop_collinear makes one edge of several, it comes from the triangle of the
/// first. Where simplify_mm does, the edge comes from no triangle, and names no mesh edge at the points that it keeps; nor
/// does the last point of an open polyline that it leads to. All other edges keep theirs.
struct PointOrigin {
    std::uint32_t triangle = no_triangle;  ///< index in the mesh
    std::uint16_t part = 0;                ///< index of that mesh among those of slice_parts(); 0 where no_triangle
    std::uint8_t edge = no_edge;           ///< where the contour edge begins
    std::uint8_t end_edge = no_edge;       ///< where it ends
    friend constexpr auto operator<=>(const PointOrigin&, const PointOrigin&) = default;
};

/// Which ends of open polylines may be joined. Pairs are joined by distance, the nearest first, and at most one to each end.
enum class GapSense : std::uint8_t {
    kept,  ///< an end to a start: every polyline keeps its orientation
    any,   ///< also two ends or two starts, for facets that disagree: one of the two polylines is turned round. Of equally
           ///< near pairs those that keep the orientation come first.
};

/// Where two ends of open polylines were joined.
struct ClosedGap {
    std::uint64_t layer = 0;  ///< index into SliceResult::layers
    Point from;               ///< a polyline's end; of two ends or two starts the smaller point
    Point to;                 ///< a polyline's start; of two ends or two starts the larger point
};

/// One plane with the slab that it stands for.
struct Layer {
    double bottom_mm = 0;
    double plane_mm = 0;  ///< the height asked for; where it was really cut is `plane` times the unit
    double top_mm = 0;
    std::uint64_t first_contour = 0;  ///< index into SliceResult::contours
    std::uint64_t contour_count = 0;
    std::uint64_t segments = 0;  ///< triangles that the plane crosses
    PlaneHeight plane;           ///< grid units
};

struct StageTimes {  ///< wall time, ms; the sweep and its fused phases are split by thread time
    double bucket = 0;
    double sweep = 0;
    double contours = 0;
    double nesting = 0;
    double fill = 0;  ///< fill rule, closing, offset, simplification and marks, where asked for
};

/// What was done, for reports.
struct SliceSummary {
    std::uint64_t triangles = 0;   ///< in the input
    std::uint64_t degenerate = 0;  ///< dropped: two equal vertices after rounding
    std::uint64_t crossed = 0;     ///< crossed by at least one plane
    std::uint64_t segments = 0;
    std::uint64_t holes = 0;
    std::uint64_t open_contours = 0;
    std::uint64_t flat_contours = 0;
    std::uint64_t overruled_contours = 0;  ///< contours with orientation_overruled
    std::uint64_t near_contours = 0;       ///< contours with near_contour
    std::uint64_t emptied_layers = 0;      ///< layers that the mesh crosses, but of which the rules leave no contour
    /// Layers in which shells turned inwards overlap others, so that FillRule::non_zero or outermost takes solid away there:
    /// contours that meet have winding numbers below and above zero. Not kept in archives.
    std::uint64_t cancelled_layers = 0;
    std::uint64_t bands = 0;
    int unit_doublings = 0;  ///< how often the unit asked for, or the default, was doubled to fit the mesh
    int threads = 1;
    double min_mm[3] = {0, 0, 0};  ///< box of the transformed mesh
    double max_mm[3] = {0, 0, 0};
    StageTimes ms;
};

/// A point of a contour, in mm within its plane.
struct PointMm {
    double x = 0;
    double y = 0;
};

/// Heights, points and areas are in the frame of the slicing: after SliceOptions::transform.
struct SliceResult {
    /// Its arrays will take their memory from `memory`; null: operator new.
    explicit SliceResult(const Memory* memory = nullptr) noexcept
        : layers(memory), contours(memory), points(memory), origins(memory), closed_gaps(memory), layer_of(memory) {}

    Array<Layer> layers;
    Array<Contour> contours;
    Array<Point> points;
    Array<PointOrigin> origins;     ///< of each of `points`; empty unless SliceOptions::origins
    Array<ClosedGap> closed_gaps;   ///< by layer, then by `from` and `to`
    std::uint64_t first_layer = 0;  ///< of `layers[0]` among those of the plan: see SliceOptions::layers
    std::uint64_t all_layers = 0;   ///< of the plan
    /// The layer of each of ExplicitPlanes::heights_mm, an index into `layers` where these are all layers of the plan. Empty
    /// for other plans.
    Array<std::uint64_t> layer_of;
    std::uint32_t part_count = 1;  ///< meshes
    PartRegions part_regions = PartRegions::separate;
    RegionRules region;
    double close_gaps_mm = 0;  ///< ends at most so far apart were joined; of several parts the longest of their lengths
    GapSense gap_sense = GapSense::kept;
    double unit_mm = default_unit_mm;  ///< grid units times this give mm; to_mm() does it
    Transform frame;                   ///< from the caller's space to the space of layers and points
    LayerPlan plan;
    SliceSummary summary;

    std::span<const Contour> contours_of(const Layer& layer) const noexcept {
        return {contours.data() + layer.first_contour, layer.contour_count};
    }
    std::span<const Point> points_of(const Contour& contour) const noexcept {
        return {points.data() + contour.first_point, contour.point_count};
    }
    /// Precondition: there are origins.
    std::span<const PointOrigin> origins_of(const Contour& contour) const noexcept {
        return {origins.data() + contour.first_point, contour.point_count};
    }
    PointMm to_mm(Point point) const noexcept { return {point.x * unit_mm, point.y * unit_mm}; }
    /// Where a layer was really cut: `to_mm(layer.plane)`. How far from the height asked for: see grid.hpp.
    double to_mm(PlaneHeight height) const noexcept { return height.z() * unit_mm; }
    /// Net solid area of a layer, mm²: outers minus holes. O(contours). NaN, not known, where the layer has an open
    /// polyline: find_open_layers() says how many have, and check() where the mesh is open.
    double area_mm2(const Layer& layer) const noexcept;
    /// Area within a contour, mm²: positive for an outer one, negative for a hole, 0 for flat and open ones.
    double area_mm2(const Contour& contour) const noexcept;
    double length_mm(const ClosedGap& gap) const noexcept;
};

/// A 64-bit hash (FNV-1a over 8-byte little-endian words) of: k; per layer the plane (int32 as int64) and its number of
/// contours; per contour role, orientation, flags and part (one word: role | (orientation & 0xff) << 8 | flags << 16 |
/// part << 32), segments, point_count, parent minus the layer's first contour (or -1), area low, area high; per point x and
/// y (one word: x low, y high). Origins are left out. Equal on every platform, thread count and band size.
std::uint64_t hash_result(const SliceResult& result) noexcept;

}  // namespace lamella
