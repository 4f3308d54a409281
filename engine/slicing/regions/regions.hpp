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
// is folded (see offset/moving_edges.hpp): eroding would give the folded ring. The rest goes on as eroded curves, together
// with the rings that were left alone, since eroding by miters may reach those.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "lamella/options.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/offset/raw_offset.hpp"
#include "slicing/regions/fill.hpp"

namespace lamella {

/// The steps from a layer's contours to its region; lengths in grid units.
struct RegionSteps {
    FillRule rule = FillRule::non_zero;
    double close = 0;
    double offset = 0;
    double miter = 3;
    bool always_list = false;  ///< paths() also where the region is unchanged
};

/// Layer after layer; scratch is kept. One per thread.
class Regions {
public:
    explicit Regions(Worker& worker) noexcept : worker_(worker) {}

    /// Computes the region. `contours` are closed and sorted by start, equal ones side by side. O((q + c) log (q + c)) for q
    /// points and c contacts. Throws std::bad_alloc.
    void run(std::span<const Path> contours, const RegionSteps& steps, Nester& nester);
    /// The steps after the fill rule, from a region that is filled already. The region must stay until all is read.
    void go_on(const Fill& filled, const RegionSteps& steps, Nester& nester);

    // Several steps sideways, each from the one before. start_from() or widen() comes first, then move() as often as wanted.
    // What they are given must stay until the first move().

    /// From a region that is known to be one; Path::hole tells the solid side of each contour.
    void start_from(std::span<const Path> region);
    /// From what lies within the distance of lines: open ones, and closed ones as if they came back to their start.
    void widen(std::span<const Path> lines, double distance, const Corners& corners, Nester& nester);
    /// By so many grid units; positive: outwards.
    void move(double distance, const Corners& corners, Nester& nester);
    /// The region after the last move() or widen(); its paths are paths() too.
    const Fill& moved() const noexcept { return *latest_; }

    /// In no order; empty where is_unchanged(), unless RegionSteps::always_list. Path::made tells those apart that are given
    /// contours; points of the others stay until the next call. Path::touched counts from the first of these paths.
    std::span<const Path> paths() const noexcept { return rings_; }
    /// True if the region is the contours as they are. Then nested() are they, with the outputs of nesting.
    bool is_unchanged() const noexcept { return unchanged_; }
    std::span<const NestItem> nested() const noexcept { return filled_.nested(); }
    bool cancels() const noexcept { return filled_.cancels(); }

    /// Adds the flag would_close to those of `contours`, closed ones with a role, that closing by `distance` would change.
    void mark_near(std::span<NestItem> contours, double distance, double miter, Nester& nester);

private:
    void turn_backward_ones();
    void close(const RegionSteps& steps, Nester& nester);
    std::optional<RawCurve> fold(const NestItem& ring, double distance, const Corners& corners);
    Path as_folded(std::uint32_t ring) const;
    bool find_alone();
    void list_eroded(const RegionSteps& steps);
    void list_moved(RawOffset& curves, double distance, const Corners& corners);
    void list_dilated(double distance, const Corners& corners);
    void clear(RawOffset& curves);
    void add_curve(const NestItem& ring, const RawCurve& curve);
    void list_curves(RawOffset& curves);
    void fill_positive(Fill& fill, Nester& nester);
    void take(const Fill& fill);

    Worker& worker_;
    Vector<Path> rings_{worker_.memory()};
    Vector<Path> input_{worker_.memory()};             // of a stage's fill, by start
    Vector<RawCurve> curves_{worker_.memory()};        // of a stage's rings
    Vector<std::uint32_t> parts_{worker_.memory()};    // of curves_
    Vector<std::uint8_t> is_alone_{worker_.memory()};  // of each ring: closing leaves it alone
    Vector<Point> from_start_{worker_.memory()};       // points of a ring
    Vector<Point> folded_{worker_.memory()};
    Vector<PointOrigin> folded_origins_{worker_.memory()};
    Vector<std::uint32_t> folded_of_{worker_.memory()};  // of a folded ring's points: which they were before
    Vector<std::size_t> folded_ends_{worker_.memory()};  // of each ring, in folded_
    Vector<Point> turned_{worker_.memory()};             // points of rings that were walked with the solid on their right
    Vector<PointOrigin> turned_origins_{worker_.memory()};
    bool unchanged_ = false;

    Fill filled_{worker_};
    Fill moved_{worker_};   // dilated for closing, or offset by the first step, the third and so on
    Fill closed_{worker_};  // or offset by the second step, the fourth and so on
    RawOffset moved_curves_{worker_};
    RawOffset closed_curves_{worker_};
    const Fill* latest_ = nullptr;  // what move() and widen() made last
};

}  // namespace lamella
