// The faces that strands cut the plane into, their winding numbers, and the contours of a region made of faces.
//
// Each strand has two halves, one for each direction; a half has the face on its left. Around a vertex the halves that leave
// it are in counter-clockwise order, beginning at the left. A half that arrives is followed by the next one clockwise from
// the way that it came, so that both have the same face on their left:
//
//              \  1 /                  the half that comes along `a` goes on along `b`: between them lies face 0.
//            a  \  / b                 Across a strand the winding number changes by the number of contours along it.
//          ------><------
//               0
//
// A region's contour is traced in the same way, with the strands in its inside left out: a contour that arrives at a vertex
// goes on by the next end clockwise, the solid between them on its left. So each contour bounds one connected piece of
// solid. Pieces that touch in a point have a contour each; one that touches itself there has a contour that passes the
// point twice.
//
// O(s log s) for s strands, and a step for each point that is written.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/options.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/snap_rounding.hpp"

namespace lamella {

/// True if a point with the winding number is inside by `rule`, which is not `contours`.
constexpr bool fills(FillRule rule, std::int64_t winding) noexcept {
    return rule == FillRule::even_odd ? winding % 2 != 0 : (rule == FillRule::positive ? winding > 0 : winding != 0);
}

/// One layer after another; scratch is kept. One per thread.
class Arrangement {
public:
    using Half = std::uint32_t;

    explicit Arrangement(Worker& worker) noexcept : worker_(worker) {}

    /// A face of a component, by one half on whose left it is.
    struct Face {
        Half first;
        std::uint32_t component;
        std::int64_t winding;  ///< if it were zero around the component
    };

    /// Where points lie.
    struct Extent {
        FlatBox box = FlatBox::nothing();
        Point smallest{std::numeric_limits<std::int32_t>::max(), 0};

        void include(Point p) noexcept { include({{p, p}, p}); }
        void include(const Extent& other) noexcept {
            box.include(other.box);
            smallest = std::min(smallest, other.smallest);
        }
    };

    /// Finds faces and winding numbers. `snapped` must stay until all is read. Throws std::bad_alloc.
    void build(const SnapRounding& snapped);

    std::span<const Face> faces() const noexcept { return faces_; }
    /// The face around each component, which is all strands that hang together.
    std::span<const std::uint32_t> outer_faces() const noexcept { return outer_faces_; }
    /// Of each face: the box of the points around it, and the smallest of them.
    void list_extents(Vector<Extent>& faces);
    /// Appends the points around a face that does not lie around its component: counter-clockwise.
    void append_points_of(const Face& face, Vector<Point>& points);

    /// Appends the contours of the region of the faces that are filled, by face: how many points each has, and its part.
    /// Path::touched becomes the index of the contour that is met first from the contour's smallest point clockwise, with
    /// nothing solid in between; -1 if there is none. Points go to `points`, and their origins to `origins`, which is null
    /// where the strands have none.
    void trace(std::span<const std::uint8_t> filled, Vector<Path>& contours, Vector<Point>& points,
               Vector<PointOrigin>* origins);

private:
    static constexpr std::uint32_t none = 0xffffffff;
    static constexpr std::int64_t no_boundary = -2;
    static constexpr std::int64_t untraced = -1;

    const Strand& strand_of(Half half) const noexcept { return snapped_->strands()[half / 2]; }
    std::uint32_t from(Half half) const noexcept { return half % 2 == 0 ? strand_of(half).from : strand_of(half).to; }
    std::uint32_t to(Half half) const noexcept { return from(half ^ 1); }
    std::int64_t times(Half half) const noexcept { return half % 2 == 0 ? strand_of(half).times : -strand_of(half).times; }
    /// The i-th point, from the first vertex on.
    Point point_of(Half half, std::uint32_t i) const noexcept {
        const Strand& strand = strand_of(half);
        return snapped_->point_of(strand, half % 2 == 0 ? i : strand.edges - i);
    }
    /// The next half clockwise around the vertex that it leaves.
    Half clockwise_of(Half half) const noexcept {
        const std::uint32_t vertex = from(half);
        const std::uint32_t place = place_of_[half];
        return halves_[place == first_halves_[vertex] ? first_halves_[vertex + 1] - 1 : place - 1];
    }
    Half next_around_face(Half half) const noexcept { return clockwise_of(half ^ 1); }

    /// An end of a half at a vertex.
    struct End {
        std::uint32_t vertex;
        std::uint32_t place;  // in halves_
        friend constexpr auto operator<=>(const End&, const End&) = default;
    };

    void sort_halves();
    void find_faces();
    void spread_windings(std::uint32_t vertex);
    void find_outer_faces();
    void append(Half half, Vector<Point>& points, Vector<PointOrigin>* origins);
    End follow_boundary(Half first, std::int64_t contour, Vector<Point>& points, Vector<PointOrigin>* origins,
                        std::uint32_t& part);
    std::int64_t touched_at(std::int64_t contour, std::int64_t base, std::span<const End> first_ends) const noexcept;
    bool is_boundary(Half half) const noexcept { return contour_of_[half] != no_boundary; }

    Worker& worker_;
    const SnapRounding* snapped_ = nullptr;
    Vector<std::uint32_t> first_halves_{worker_.memory()};  // of each vertex, in halves_
    Vector<Half> halves_{worker_.memory()};                 // by vertex that they leave, counter-clockwise from the left
    Vector<std::uint32_t> place_of_{worker_.memory()};      // of each half in halves_
    Vector<std::uint32_t> face_of_{worker_.memory()};       // of each half
    Vector<Face> faces_{worker_.memory()};                  // by component
    Vector<std::uint32_t> outer_faces_{worker_.memory()};
    Vector<std::uint32_t> component_of_{worker_.memory()};  // of each vertex
    Vector<std::int64_t> contour_of_{worker_.memory()};     // of each half, while contours are traced
    Vector<std::uint32_t> stack_{worker_.memory()};
    Vector<Point> face_points_{worker_.memory()};
};

}  // namespace lamella
