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

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/arrangement.hpp"
#include "slicing/regions/snap_rounding.hpp"

namespace lamella {

/// Layer after layer; scratch is kept. One per thread.
class Fill {
public:
    explicit Fill(Worker& worker) noexcept : worker_(worker) {}

    /// Computes the region. `contours` are closed and sorted by start, equal ones side by side; they must stay. Throws
    /// std::bad_alloc.
    void run(std::span<const Path> contours, FillRule rule, Nester& nester);

    // The same in two steps, for several regions of the same contours.

    /// Finds winding numbers, by which a contour counts as often as its weight says. Each counts once without weights.
    void find_windings(std::span<const Path> contours, std::span<const std::int64_t> weights, Nester& nester);
    /// Each winding number that occurs, ascending; they stay until the next call.
    std::span<const std::int64_t> list_windings();
    /// Makes the region of what has a filled winding number.
    void select(FunctionRef<bool(std::int64_t)> fills);

    /// First kept(), then made(), of which points stay until the next call.
    std::span<const Path> region() const noexcept { return region_; }
    /// The given contours that belong to the region as they are, but for Path::hole.
    std::span<const Path> kept() const noexcept { return region().first(kept_); }
    std::span<const Path> made() const noexcept { return region().subspan(kept_); }
    /// True if the region is the contours as they are. Then nested() are they, with the outputs of nesting.
    bool is_unchanged() const noexcept { return unchanged_; }
    std::span<const NestItem> nested() const noexcept { return pieces_; }
    /// True if contours that meet have winding numbers below and above zero, in faces wider than what rounding makes: shells
    /// turned inwards and outwards overlap there, and cancel by the rules non_zero and outermost.
    bool cancels() const noexcept { return cancels_; }

private:
    void merge_equal_ones(std::span<const std::int64_t> weights);
    void overlay();
    void list_pieces();
    void list_faces();
    void spread_windings();
    std::int64_t around(std::uint32_t piece) const noexcept {
        return pieces_[piece].parent < 0 ? 0 : inside_[static_cast<std::size_t>(pieces_[piece].parent)];
    }
    std::int64_t winding_of(const Arrangement::Face& face) const noexcept { return around_[face.component] + face.winding; }
    void keep_or_drop(std::uint32_t piece, FunctionRef<bool(std::int64_t)> fills);
    void find_cancelled(FillRule rule);
    bool is_wide(const Arrangement::Face& face);
    void take_traced(FunctionRef<bool(std::int64_t)> fills);

    Worker& worker_;
    std::span<const Path> contours_;  // the given ones
    Contacts contacts_{worker_};
    SnapRounding snapped_{worker_};
    Arrangement arrangement_{worker_};
    Vector<NestItem> items_{worker_.memory()};               // one of each group of equal contours
    Vector<std::uint32_t> firsts_{worker_.memory()};         // of each item: the index of the first of the equal contours
    Vector<std::int64_t> times_{worker_.memory()};           // of each item: how many there are
    Vector<NestItem> pieces_{worker_.memory()};              // to be nested: contours that meet no other, then faces
    Vector<Arrangement::Extent> extents_{worker_.memory()};  // of all faces
    Vector<Point> starts_{worker_.memory()};                 // of contours that meet no other, then of components
    PointTree start_tree_{worker_};
    Vector<std::uint32_t> numbers_{worker_.memory()};  // of each piece: of an item, or of a face of the arrangement
    std::size_t apart_ = 0;                            // as many of pieces_ are contours
    Vector<std::int64_t> inside_{worker_.memory()};    // of each piece: the winding number just inside
    Vector<Point> face_points_{worker_.memory()};
    Vector<std::size_t> face_ends_{worker_.memory()};      // of each piece that is a face, in face_points_
    Vector<std::uint32_t> order_{worker_.memory()};        // of pieces, by start
    Vector<std::int64_t> around_{worker_.memory()};        // of each component: the winding number around it
    Vector<std::uint8_t> around_known_{worker_.memory()};  // of each component
    Vector<std::uint8_t> below_zero_{worker_.memory()};    // of each component: whether it has a wide face below zero
    Vector<std::int64_t> windings_{worker_.memory()};
    Vector<std::uint8_t> filled_{worker_.memory()};  // of each face
    Vector<Path> region_{worker_.memory()};
    std::size_t kept_ = 0;  // of region_
    Vector<Point> points_{worker_.memory()};
    Vector<PointOrigin> origins_{worker_.memory()};  // of points_
    bool with_origins_ = false;
    bool merged_ = false;  // some contours are equal
    bool unchanged_ = false;
    bool cancels_ = false;
};

}  // namespace lamella
