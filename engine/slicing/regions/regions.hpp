// The region of a layer by all its rules, stage by stage:
//
//     fill     what the closed contours bound by the fill rule
//     close    dilated, then eroded: gaps are filled
//     offset   dilated or eroded
//
// Each stage takes rings with the solid on their left and gives rings. A ring that a stage leaves as it is stays the same
// contour, so that most contours of most layers are never copied.
//
// Closing computes offset curves of all rings (see offset/raw_offset.hpp) and looks where they meet. A ring is left alone
// if and only if its curve keeps all directions, passes the limit at no inner corner, and meets no curve, itself included,
// and bounds the same side as before: then eroding would give it back. A ring with short edges in notches, which turn round,
// is first folded (see offset/fold.hpp): eroding would give the folded ring. The rest goes on as eroded curves, together
// with the rings that were left alone, since eroding by miters may reach those.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/region.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/offset/raw_offset.hpp"
#include "slicing/regions/fill.hpp"

namespace lamella {

/// What is done to the contours of a layer; lengths in grid units.
struct RegionSteps {
    FillRule rule = FillRule::non_zero;
    double close = 0;
    double offset = 0;
    double miter_limit = 3;
    bool always_list = false;  ///< rings() also where the region is unchanged
};

/// A contour of a region.
struct Ring {
    NestItem item;              ///< points, start and area
    std::int64_t given = -1;    ///< index of the given contour that it is, unchanged; -1: a stage made it
    std::int64_t touched = -1;  ///< made: see Arrangement::Traced, an index into the rings
    bool hole = false;
    std::uint32_t source = 0;  ///< of a curve: index of its ring; of a ring that is only marked: of its contour
};

/// Layer after layer; scratch is kept. One per thread.
class Regions {
public:
    explicit Regions(const Memory* memory);

    /// From here on run() and mark_near() throw Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept;

    /// Computes the region. `contours` are closed and sorted by start, equal ones side by side. O((q + c) log (q + c)) for q
    /// points and c contacts. Throws std::bad_alloc.
    void run(std::span<const NestItem> contours, const RegionSteps& steps, Nester& nester);

    /// In no order; empty where is_unchanged(), unless RegionSteps::always_list. Points that are not those of a given
    /// contour stay until the next call.
    std::span<const Ring> rings() const noexcept { return rings_; }
    /// Whether the region is the contours as they are. Then nested() are they, with the outputs of nesting.
    bool is_unchanged() const noexcept { return unchanged_; }
    std::span<const NestItem> nested() const noexcept { return filled_.nested(); }
    bool cancels() const noexcept { return filled_.cancels(); }

    /// Adds the flag near_contour to those of `contours`, closed ones with a role, that closing by `distance` would change.
    void mark_near(std::span<NestItem> contours, double distance, double miter_limit, Nester& nester);

private:
    void take_given(std::span<const NestItem> contours);
    void turn_backward_ones();
    void close(const RegionSteps& steps, Nester& nester);
    void list_dilated(const RegionSteps& steps);
    bool fold(const NestItem& ring, const RegionSteps& steps);
    void keep_origins(const NestItem& ring);
    Ring as_folded(std::uint32_t ring) const;
    bool find_alone();
    void offset(const RegionSteps& steps, Nester& nester);
    void list_eroded(const RegionSteps& steps);
    void append_curve(std::span<const Point> points, std::uint32_t part, double distance, double miter_limit,
                      RawOffset& curves);
    void list_moved(double distance, double miter_limit);
    void clear_curves(RawOffset& curves);
    void list_curves(RawOffset& curves);
    void fill_positive(Fill& fill, Nester& nester);
    void take(Fill& fill);

    Vector<Ring> rings_;
    Vector<Ring> input_;             // of a stage's fill, by start
    Vector<NestItem> items_;         // of input_
    Vector<RawCurve> curves_;        // of a stage's rings
    Vector<std::uint32_t> parts_;    // of curves_
    Vector<std::uint8_t> is_alone_;  // of each ring: closing leaves it alone
    Vector<Ring> alone_;
    Vector<std::uint32_t> turned_edges_;  // of a ring
    Vector<Point> from_start_;            // points of a ring
    Vector<Point> folded_;
    Vector<PointOrigin> folded_origins_;
    Vector<std::uint32_t> folded_of_;  // of a folded ring's points: which they were before
    Vector<std::size_t> folded_ends_;  // of each ring, in folded_
    Vector<Point> turned_;             // points of rings that were walked with the solid on their right
    Vector<PointOrigin> turned_origins_;
    bool unchanged_ = false;

    Fill filled_;
    Fill moved_;  // dilated for closing, or offset
    Fill closed_;
    RawOffset moved_curves_;
    RawOffset closed_curves_;
    StopPace pace_;
};

}  // namespace lamella
