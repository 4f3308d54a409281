// The region that a layer's closed contours bound by a fill rule, where they overlap, nest with equal orientation or are
// reversed.
//
//     contacts        which contours meet, and where
//     snap_rounding   those cut into strands that meet only in vertices of the grid
//     arrangement     the faces between strands, and their winding numbers
//     nesting         what lies around contours that meet no other, and around strands that hang together
//     arrangement     the contours of the region, where the rule holds on one side of a strand only
//
// A contour that meets no other stays if exactly one of its two sides is filled. Nesting gives the winding numbers of both:
//
//      0  +----------+     even-odd      non-zero, positive
//         | 1 +----+ |     both stay     the inner one goes: it is filled on both sides
//         |   | 2  | |
//         |   +----+ |
//         +----------+
//
// O((q + c) log (q + c)) for q points and c contacts; memory O(q + c).
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/arrangement.hpp"
#include "slicing/regions/contacts.hpp"
#include "slicing/regions/snap_rounding.hpp"

namespace lamella {

/// A contour of a region.
struct RegionContour {
    std::int64_t kept = -1;     ///< index of the given contour that it is, unchanged; -1: overlaying made it
    bool hole = false;          ///< kept: its role; solid is on the left of one that was made
    std::uint32_t first = 0;    ///< made: index of its first point
    std::uint32_t count = 0;    ///< made: number of its points
    std::int64_t touched = -1;  ///< made: see Arrangement::Traced, an index into the region
    std::uint32_t part = 0;     ///< as Contour::part
};

/// Layer after layer; scratch is kept. One per thread.
class Fill {
public:
    explicit Fill(const Memory* memory);

    /// From here on run() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept {
        pace_.follow(host);
        contacts_.follow(host);
        snapped_.follow(host);
        arrangement_.follow(host);
    }

    /// Computes the region. `contours` are closed and sorted by start, equal ones side by side. Throws std::bad_alloc.
    void run(std::span<const NestItem> contours, FillRule rule, Nester& nester);

    std::span<const RegionContour> region() const noexcept { return region_; }
    std::span<Point> points_of(const RegionContour& made) noexcept {
        return std::span(points_).subspan(made.first, made.count);
    }
    /// Null where no given contour has origins.
    const PointOrigin* origins_of(const RegionContour& made) const noexcept {
        return with_origins_ ? origins_.data() + made.first : nullptr;
    }
    /// Whether the region is the contours as they are. Then nested() are they, with the outputs of nesting.
    bool is_unchanged() const noexcept { return unchanged_; }
    std::span<const NestItem> nested() const noexcept { return items_; }
    /// Whether contours that meet have winding numbers below and above zero, in faces wider than what rounding makes: shells
    /// turned inwards and outwards overlap there, and cancel by the rules non_zero and outermost.
    bool cancels() const noexcept { return cancels_; }

private:
    /// What nesting is about: a contour that meets no other, or a face.
    struct Piece {
        std::int64_t contour;  // of items_, or -1
        std::int64_t face;     // of the arrangement, or -1
    };

    void merge_equal_ones(std::span<const NestItem> contours);
    void keep_or_drop_all(FillRule rule, Nester& nester);
    std::int64_t keep_or_drop(std::uint32_t contour, std::int64_t around, FillRule rule);
    void overlay(FillRule rule, Nester& nester);
    void list_pieces();
    void nest_pieces(Nester& nester);
    void find_windings(FillRule rule);
    void find_cancelled();
    bool is_wide(const Arrangement::Face& face);
    void take_traced(FillRule rule);

    Contacts contacts_;
    SnapRounding snapped_;
    Arrangement arrangement_;
    Vector<NestItem> items_;        // one of each group of equal contours
    Vector<std::uint32_t> firsts_;  // of each item: the index of the first of the equal contours
    Vector<std::int64_t> times_;    // of each item: how many there are
    Vector<std::int64_t> inside_;   // of each item or piece: the winding number just inside
    Vector<Piece> pieces_;
    Vector<NestItem> piece_items_;
    Vector<Point> face_points_;
    Vector<std::size_t> face_ends_;      // of each piece, in face_points_
    Vector<std::uint32_t> order_;        // of pieces, by start
    Vector<std::int64_t> around_;        // of each component: the winding number around it
    Vector<std::uint8_t> around_known_;  // of each component
    Vector<std::uint8_t> below_zero_;    // of each component: whether it has a wide face below zero
    Vector<Arrangement::Traced> traced_;
    Vector<RegionContour> region_;
    Vector<Point> points_;
    Vector<PointOrigin> origins_;  // of points_
    bool with_origins_ = false;
    bool unchanged_ = false;
    bool cancels_ = false;
    StopPace pace_;
};

}  // namespace lamella
