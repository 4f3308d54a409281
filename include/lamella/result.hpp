// What slicing gives: layers, contours and points.
//
//     for (const lamella::LayerView layer : result) {
//         std::printf("z %g mm: %g mm2\n", layer.plane_mm, layer.area_mm2());
//         for (const lamella::Contour& contour : layer.contours) {
//             for (const lamella::Point& point : layer.points_of(contour)) {
//                 const lamella::PointMm mm = layer.to_mm(point);
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
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/integer128.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"

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
    /// Neighbouring facets disagree about which side is solid, or polylines that were stitched in StitchDirection::any; the
    /// contour runs as most of its segments do.
    orientation_mixed = 2,
    /// Ends of open polylines were joined; see SliceResult::stitches.
    stitched = 4,
    /// Closing by RegionRules::flag_closing_mm would change it: it comes within twice that of another contour or of itself.
    would_close = 8,
};

/// The part of a contour whose edges come from more than one.
inline constexpr std::uint32_t several_parts = 0xffffffff;

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
    std::uint32_t part = 0;       ///< index of the mesh that it comes from, among the parts, or several_parts

    bool encloses_area() const noexcept { return role == Role::outer || role == Role::hole; }
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
    std::uint16_t part = 0;                ///< index of that mesh among the parts; 0 where no_triangle
    std::uint8_t edge = no_edge;           ///< where the contour edge begins
    std::uint8_t end_edge = no_edge;       ///< where it ends
    friend constexpr auto operator<=>(const PointOrigin&, const PointOrigin&) = default;
};

/// Where two ends of open polylines were joined.
struct Stitch {
    std::uint64_t layer = 0;  ///< index into SliceResult::layers
    Point from;               ///< a polyline's end; of two ends or two starts the smaller point
    Point to;                 ///< a polyline's start; of two ends or two starts the larger point
};

/// One plane with the slab that it stands for.
struct Layer {
    double bottom_mm = 0;
    double plane_mm = 0;  ///< the height asked for; where it was really cut is `plane` times the grid's step
    double top_mm = 0;
    std::uint64_t first_contour = 0;  ///< index into SliceResult::contours; in a sink 0
    std::uint64_t contour_count = 0;
    std::uint64_t segments = 0;  ///< triangles that the plane crosses, or pieces of faces that project onto it
    PlaneHeight plane;           ///< grid units
};

/// A point of a contour, in mm within its plane.
struct PointMm {
    double x = 0;
    double y = 0;
};

/// A copy of a part that shares its points with another: see SliceOptions::share_copies.
struct PartCopy {
    std::uint32_t part = 0;   ///< Contour::part where copies share nothing
    std::uint32_t first = 0;  ///< the part whose contours are its own when they are moved
    Point move;               ///< by so much, grid units
    friend bool operator==(const PartCopy&, const PartCopy&) = default;
};

struct StageTimes {  ///< wall time, ms; the sweep and its fused phases are split by thread time
    double bucket = 0;
    double sweep = 0;
    double contours = 0;
    double nesting = 0;
    double fill = 0;  ///< fill rule, closing, offset, simplification and marks, where asked for
};

/// All that is known of a slice but its layers: what every destination is told. Heights, points and areas are in the frame
/// of the slicing: after Frame::transform.
struct SliceInfo {
    /// As asked, but that stitch_mm is the length in mm, of several parts the longest of theirs, and that slabs without
    /// heights have their middles for heights_mm.
    SliceOptions options;
    double grid_mm = default_grid_mm;  ///< grid units times this give mm
    int grid_doublings = 0;            ///< how often the step asked for, or the default, was doubled to fit the mesh
    Box box;                           ///< of the transformed mesh
    std::uint64_t part_count = 1;      ///< meshes
    std::uint64_t first_layer = 0;     ///< of the first layer among those of the plan: see PlaneOptions::first_layer
    std::uint64_t planned_layers = 0;  ///< of the plan
    /// The layer of the plan that each of SliceOptions::heights_mm has; the result's own begin with `first_layer`.
    std::vector<std::uint64_t> layer_of;
    std::vector<PartCopy> copies;  ///< by part, with SliceOptions::share_copies. Not kept in archives

    std::uint64_t triangles = 0;   ///< in the input
    std::uint64_t degenerate = 0;  ///< dropped: two equal vertices after rounding
    std::uint64_t crossed = 0;     ///< crossed by at least one plane
    std::uint64_t layers = 0;
    std::uint64_t segments = 0;
    // What follows is known at the end only.
    std::uint64_t contours = 0;
    std::uint64_t points = 0;
    std::uint64_t stitches = 0;
    std::uint64_t holes = 0;
    std::uint64_t open_contours = 0;
    std::uint64_t flat_contours = 0;
    std::uint64_t overruled_contours = 0;    ///< with orientation_overruled
    std::uint64_t would_close_contours = 0;  ///< with would_close
    std::uint64_t emptied_layers = 0;        ///< layers that the mesh crosses, but of which the rules leave no contour
    /// Layers in which shells turned inwards overlap others, so that FillRule::non_zero or outermost takes solid away there:
    /// contours that meet have winding numbers below and above zero. Not kept in archives.
    std::uint64_t cancelled_layers = 0;
    std::uint64_t bands = 0;
    int threads = 1;
    StageTimes ms;
};

/// An outer contour and what is cut out of it: what a host calls an ExPolygon or a polygon with holes.
struct Island {
    const Contour* outer = nullptr;
    std::span<const Contour> holes;
};

/// The islands of a layer: a forward range; nothing is allocated. It rests on the order of contours, in which each outer is
/// followed by its holes. Contours of role flat and open belong to no island.
class Islands {
public:
    class Iterator {
    public:
        using value_type = Island;
        using difference_type = std::ptrdiff_t;
        using iterator_category = std::input_iterator_tag;  // since an Island is made, not referred to
        using iterator_concept = std::forward_iterator_tag;

        Iterator() = default;
        Iterator(const Contour* at, const Contour* end) noexcept : at_(at), end_(end) { find(); }

        Island operator*() const noexcept { return {at_, {at_ + 1, next_}}; }
        Iterator& operator++() noexcept {
            at_ = next_;
            find();
            return *this;
        }
        Iterator operator++(int) noexcept {
            const Iterator before = *this;
            ++*this;
            return before;
        }
        friend bool operator==(const Iterator& a, const Iterator& b) noexcept { return a.at_ == b.at_; }

    private:
        void find() noexcept {
            while (at_ != end_ && at_->role != Role::outer) {
                ++at_;
            }
            next_ = at_ == end_ ? end_ : at_ + 1;
            while (next_ != end_ && next_->role == Role::hole) {
                ++next_;
            }
        }

        const Contour* at_ = nullptr;    // an outer, or the end
        const Contour* next_ = nullptr;  // past its holes
        const Contour* end_ = nullptr;
    };

    explicit Islands(std::span<const Contour> contours) noexcept : contours_(contours) {}
    Iterator begin() const noexcept { return {contours_.data(), contours_.data() + contours_.size()}; }
    Iterator end() const noexcept { return {contours_.data() + contours_.size(), contours_.data() + contours_.size()}; }

private:
    std::span<const Contour> contours_;
};

/// One layer, of a result or in a sink, where it is valid until the sink returns: code that reads layers is written once.
struct LayerView : Layer {
    std::uint64_t index = 0;               ///< as in SliceResult::layers
    std::span<const Contour> contours;     ///< of this layer
    std::span<const Point> points;         ///< of this layer, grid units
    std::span<const PointOrigin> origins;  ///< of each of `points`; empty unless SliceOptions::origins
    std::span<const Stitch> stitches;      ///< of this layer, by `from` and `to`
    std::uint64_t first_point = 0;         ///< what Contour::first_point counts from
    double grid_mm = default_grid_mm;

    std::span<const Point> points_of(const Contour& contour) const noexcept {
        return detail::span_of(points.data() + (contour.first_point - first_point), contour.point_count);
    }
    /// Precondition: there are origins.
    std::span<const PointOrigin> origins_of(const Contour& contour) const noexcept {
        return detail::span_of(origins.data() + (contour.first_point - first_point), contour.point_count);
    }
    /// Null where there is none.
    const Contour* parent_of(const Contour& contour) const noexcept {
        return contour.parent < 0 ? nullptr : contours.data() + (static_cast<std::uint64_t>(contour.parent) - first_contour);
    }
    Islands islands() const noexcept { return Islands(contours); }
    PointMm to_mm(Point point) const noexcept { return {point.x * grid_mm, point.y * grid_mm}; }
    /// Where the layer was really cut. How far from `plane_mm`: see grid.hpp.
    double cut_mm() const noexcept { return plane.z() * grid_mm; }
    /// Net solid area, mm²: outers minus holes. O(contours). NaN, not known, where a contour is open: audit() says how many
    /// layers have one, and check() where the mesh is open.
    double area_mm2() const noexcept;
    /// Area within a contour, mm²: positive for an outer one, negative for a hole, 0 for flat and open ones.
    double area_mm2(const Contour& contour) const noexcept;
};

/// Three flat arrays, and a range of LayerViews. Move-only; copy() copies on purpose.
struct SliceResult {
    /// Its arrays will take their memory from `memory`; null: operator new.
    explicit SliceResult(const Memory* memory = nullptr) noexcept
        : layers(memory), contours(memory), points(memory), origins(memory), stitches(memory) {}

    Array<Layer> layers;
    Array<Contour> contours;
    Array<Point> points;
    Array<PointOrigin> origins;  ///< of each of `points`; empty unless SliceOptions::origins
    Array<Stitch> stitches;      ///< by layer, then by `from` and `to`
    SliceInfo info;

    class Iterator {
    public:
        using value_type = LayerView;
        using difference_type = std::ptrdiff_t;
        using iterator_category = std::input_iterator_tag;  // since a view is made, not referred to
        using iterator_concept = std::forward_iterator_tag;

        Iterator() = default;
        Iterator(const SliceResult* result, std::size_t at) noexcept : result_(result), at_(at) {}
        LayerView operator*() const noexcept { return (*result_)[at_]; }
        Iterator& operator++() noexcept {
            ++at_;
            return *this;
        }
        Iterator operator++(int) noexcept { return {result_, at_++}; }
        friend bool operator==(const Iterator&, const Iterator&) = default;

    private:
        const SliceResult* result_ = nullptr;
        std::size_t at_ = 0;
    };

    /// O(1), but O(log stitches) where there are some.
    LayerView operator[](std::size_t layer) const noexcept;
    std::size_t size() const noexcept { return layers.size(); }
    Iterator begin() const noexcept { return {this, 0}; }
    Iterator end() const noexcept { return {this, size()}; }

    std::span<const Contour> contours_of(const Layer& layer) const noexcept {
        return detail::span_of(contours.data() + layer.first_contour, layer.contour_count);
    }
    std::span<const Point> points_of(const Contour& contour) const noexcept {
        return detail::span_of(points.data() + contour.first_point, contour.point_count);
    }
    /// Precondition: there are origins.
    std::span<const PointOrigin> origins_of(const Contour& contour) const noexcept {
        return detail::span_of(origins.data() + contour.first_point, contour.point_count);
    }
    PointMm to_mm(Point point) const noexcept { return {point.x * info.grid_mm, point.y * info.grid_mm}; }

    /// Errors: out_of_memory.
    Result<SliceResult> copy(const Memory* memory = nullptr) const noexcept;

    /// A 64-bit hash (FNV-1a over 8-byte little-endian words) of: k; per layer the plane (int32 as int64) and its number of
    /// contours; per contour role, orientation, flags and part (one word: role | (orientation & 0xff) << 8 | flags << 16 |
    /// part << 32), segments, point_count, parent minus the layer's first contour (or -1), area low, area high; per point x
    /// and y (one word: x low, y high). Origins are left out. Equal on every platform, thread count and band size.
    std::uint64_t hash() const noexcept;
};

/// SliceResult::hash() of layers that are never held together: add() each in ascending order. The number of layers must be
/// known first.
class LayerHash {
public:
    explicit LayerHash(std::uint64_t layers) noexcept;
    void add(const LayerView& layer) noexcept;
    std::uint64_t value() const noexcept { return hash_; }

private:
    std::uint64_t hash_;
};

}  // namespace lamella
