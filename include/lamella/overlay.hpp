// Layers combined with layers: unions, differences and intersections of whole stacks, and regions by label of many at once.
//
//     // Top surfaces: what the layer above leaves uncovered.
//     lamella::Overlay overlay;
//     lamella::SliceResult tops;
//     const lamella::LayerSet sets[] = {{.layers = result}, {.layers = result, .from = 1, .to = 1}};
//     if (overlay.combine(tops, sets, lamella::subtract)) {
//         for (const lamella::LayerView layer : tops) {
//             std::printf("%g mm: %g mm2 lie open\n", layer.plane_mm, layer.area_mm2());
//         }
//     }
//     // Two squares as two materials, of which the second wins where both are: parts 0 and 1.
//     const lamella::Point low[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
//     const lamella::Point high[] = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
//     const std::span<const lamella::Point> first[] = {low};
//     const std::span<const lamella::Point> second[] = {high};
//     const lamella::ContourSet plastic{.contours = first, .grid_mm = 1};
//     const lamella::ContourSet copper{.contours = second, .grid_mm = 1};
//     const lamella::LayerSet materials[] = {{.layers = plastic}, {.layers = copper}};
//     if (overlay.combine(tops, materials, {.last_wins = true})) {
//         for (const lamella::Contour& contour : tops.contours) {
//             std::printf("part %u: %g mm2\n", contour.part, tops[0].area_mm2(contour));
//         }
//     }
//     // Two walls and what is left inside them for infill, without slits narrower than 0.2 mm: parts 0, 1 and 2.
//     const lamella::OffsetStep steps[] = {{-0.2}, {-0.4}, {-0.3, false}, {0.1}};
//     if (overlay.offset(tops, {.layers = result}, steps, {.join = lamella::Join::round})) {
//         std::printf("%zu contours\n", tops.contours.size());
//     }
//
// A set is a stack of layers; or one layer or contours of the host's, which then stand at every height. All stacks have the
// same planes, or were asked for at the same heights, and all sets the same grid:
//
//     layer n of the answer      by the rule, of layers n + from to n + to of each set; beyond a stack's ends there are none
//     without any stack          one layer at height 0
//
// Points of the answer lie on the grid: those of the sets, and where contours cross, rounded. A set's boundary moves by half
// a unit at most, along each axis, and by as much again where its fill rule first makes the set a region.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "lamella/context.hpp"
#include "lamella/destination.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/options.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Contours of a caller's own. A contour's last point leads to its first, unless it is a polyline to be clipped; equal
/// consecutive points count once.
struct ContourSet {
    std::span<const std::span<const Point>> contours;
    double grid_mm = default_grid_mm;  ///< a grid unit of the points
};

/// Where a set's layers are, as a parameter only: what it was made of must stay.
class Layers {
public:
    Layers() noexcept = default;
    Layers(const SliceResult& stack) noexcept : stack_(&stack) {}  // NOLINT(google-explicit-constructor)
    Layers(const LayerView& layer) noexcept : layer_(&layer) {}    // NOLINT(google-explicit-constructor)
    Layers(const ContourSet& given) noexcept : given_(&given) {}   // NOLINT(google-explicit-constructor)

    // What it was made of, for the library: at most one is not null. None: no solid at all.
    const SliceResult* stack() const noexcept { return stack_; }
    const LayerView* layer() const noexcept { return layer_; }
    const ContourSet* given() const noexcept { return given_; }

private:
    const SliceResult* stack_ = nullptr;
    const LayerView* layer_ = nullptr;
    const ContourSet* given_ = nullptr;
};

/// One of the sets that are combined: for layer n of the answer the union of its layers n + from to n + to.
struct LayerSet {
    Layers layers{};
    std::int32_t from = 0;
    std::int32_t to = 0;
    double grow_mm = 0;  ///< that union's edges move outwards so far first, with mitred corners; negative: inwards
    FillRule fill_rule = FillRule::non_zero;  ///< of contours that bound no region yet; not `contours` or `outermost`
    std::optional<std::uint32_t> part{};      ///< contours of this Contour::part only
};

inline constexpr std::size_t most_layer_sets = 63;
inline constexpr std::uint32_t most_labels = 65535;

/// From membership (bit i: inside set i) to a label, at most most_labels. 0: empty; label l becomes part l - 1 of the
/// answer, as of several meshes side by side. Parts share every point of the boundary between them.
///
/// The label is 1 where all that the first five say holds.
struct Rule {
    std::uint64_t any = ~std::uint64_t{0};              ///< inside one of these
    std::uint64_t all = 0;                              ///< inside each of these
    std::uint64_t none = 0;                             ///< inside none of these
    std::uint64_t not_all = 0;                          ///< outside one of these; 0: no matter
    bool odd = false;                                   ///< and inside an odd number of sets
    bool last_wins = false;                             ///< the label is 1 + the number of the last set of `any`
    std::span<const std::uint32_t> labels{};            ///< instead of all that: 2^sets labels, by membership
    Callback<std::uint32_t(std::uint64_t)> label_of{};  ///< instead of all that: the same answer for the same membership
};

inline constexpr Rule unite{};
inline constexpr Rule subtract{.any = 1, .none = ~std::uint64_t{1}};  ///< the first without all others
inline constexpr Rule exclusive{.odd = true};
/// What all of the first `sets` have, from 1 to most_layer_sets.
constexpr Rule intersect(std::size_t sets) noexcept {
    return {.all = (std::uint64_t{1} << sets) - 1};
}

/// What the corners become that an offset moves apart: the sharp ones outside where it widens, inside where it narrows.
enum class Join : std::uint8_t {
    miter,   ///< edges run on to where they meet, at most miter_limit distances away, and are cut at the distance beyond
    round,   ///< an arc around the corner, from the distance to arc_tolerance_mm more
    square,  ///< cut at the distance, unless the corner lies within arc_tolerance_mm of it
};

/// What a contour is to an offset: the boundary of a region, or a line with ends.
enum class End : std::uint8_t {
    region,
    butt,    ///< lines end where they end
    square,  ///< lines are longer by the distance
    round,   ///< lines end with half an arc
};

/// One step of an offset: how far edges move, outwards where it is above 0, from where the step before left them.
struct OffsetStep {
    double mm = 0;
    bool keep = true;  ///< its region is a part of the answer
};

struct OffsetOptions {
    Join join = Join::miter;
    End end = End::region;
    double miter_limit = 3;
    double arc_tolerance_mm = 0.005;
};

/// What clip() keeps of polylines.
struct ClipOptions {
    bool inside = true;              ///< what lies inside; else what lies outside
    bool boundary_is_inside = true;  ///< what runs along a boundary, with solid on one side only
};

namespace detail {
struct OverlayImpl;
}

/// Combines layers, and keeps scratch for the next call. One for each call at the same time.
class Overlay {
public:
    Overlay() noexcept;
    ~Overlay();
    Overlay(Overlay&&) noexcept;
    Overlay& operator=(Overlay&&) noexcept;

    /// Layers of the sets by the rule, then by what `after` says (its fill rule is not looked at): a result like that of a
    /// slice, so that all that takes one takes it. Of a set whose contours are no region yet, its fill rule makes one. The
    /// answer depends neither on the order of sets, but for what the rule makes of it, nor on that of contours, nor on
    /// threads. There are no origins; Layer::segments are those of all stacks.
    ///
    /// Layers in parallel; O(q log q + c) for a layer of q points and c places where contours come within two units.
    /// Errors: invalid_argument (no sets or more than most_layer_sets, different grids or planes, from > to, a rule that is
    /// out of range, a label for membership 0, a length under a unit or beyond the grid, points beyond it, negative
    /// threads), result_too_large, out_of_memory, cancelled.
    Result<SliceInfo> combine(const Destination& to, std::span<const LayerSet> sets, const Rule& rule = unite,
                              const RegionRules& after = {}, const Context& context = {}) noexcept;

    /// The set's region moved step by step: kept steps are parts 0, 1, ... of the answer. So {-0.2}, {-0.4} are two walls,
    /// {-r, false}, {r} is an opening, and {r, false}, {-r} a closing. A region that has vanished does not come back.
    ///
    /// Where the options name an end, contours of the host's and open contours of layers are lines, closed ones of layers
    /// are lines without ends, and the first step makes the region within its distance of them.
    ///
    /// Each point lies within a unit along each axis of where arithmetic without rounding puts it, for each step. What
    /// combine() says of sets, `after`, threads, times and errors holds here too; errors besides: a step of 0 or under a
    /// unit, none that is kept, a first step inwards from lines, an arc tolerance that is not above 0 or finer than 3e-7 of
    /// a step.
    Result<SliceInfo> offset(const Destination& to, const LayerSet& of, std::span<const OffsetStep> steps,
                             const OffsetOptions& options = {}, const RegionRules& after = {},
                             const Context& context = {}) noexcept;

    /// The pieces of polylines that lie inside the region of `by`, or outside: open contours, by polyline and in order along
    /// it. Contour::part is the polyline's number in its layer, from 0. Polylines are all contours of `lines`: those of the
    /// host are open, those of layers as their role says. Pieces meet where a closed one starts, and if all of it is kept it
    /// comes as an open one that ends where it starts.
    ///
    ///     // Infill: lines over the whole plate, cut to what lies half a millimetre inside.
    ///     overlay.clip(infill, lines, {.layers = result, .grow_mm = -0.5});
    ///
    /// Given points stay. Where a polyline is cut lies a grid point, half a unit away at most along each axis; pieces that
    /// become a point are dropped. A polyline is not cut where it only touches a boundary, nor where it crosses itself or
    /// another. The answer depends on no order of contours of `by`, nor on threads.
    ///
    /// Layers in parallel; usually O((q + p) log p + c log c) for q points of polylines, p of the region, and c places where
    /// they cross. Contours around a point where a polyline starts, or that it passes aslant and near, cost as crossings do.
    /// Errors: those of combine(); in messages the lines are set 0, and `by` is set 1.
    Result<SliceInfo> clip(const Destination& to, const Layers& lines, const LayerSet& by, const ClipOptions& options = {},
                           const Context& context = {}) noexcept;

    /// Gives all memory back: before the host's Memory that it came from goes.
    void reset() noexcept;

private:
    std::unique_ptr<detail::OverlayImpl> impl_;
};

}  // namespace lamella
