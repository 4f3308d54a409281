// The triangles of a mesh that a plane may meet: found by boxes around runs of triangles along a curve that fills space
// (Morton 1966), and boxes around runs of those.
//
//     triangles  .... .... .... | .... .... .... | ....          a plane reads the triangles of the boxes that it meets
//     boxes      [  ] [  ] [  ]   [  ] [  ] [  ]   [  ]          within the larger ones that it meets
//     larger     [            ]   [            ]   [  ]
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// z after a transform, and how far from 0 a triangle may lie that the plane still meets once it is on the grid. `room` is
/// at least 2^-19 of what is added up: distances are of floats.
struct PlaneReach {
    std::array<double, 4> row{};
    double room = 0;
};

class NearPlane {
public:
    /// Precondition: the mesh was checked, and has that box; it must outlive this.
    NearPlane(const MeshView& mesh, const Bounds& bounds, const Parallel& parallel);

    /// In no order; clears `found`.
    void find(const PlaneReach& plane, Vector<std::size_t>& found) const;

private:
    static std::size_t runs_in(std::size_t count) noexcept { return (count + run - 1) / run; }
    void find_in(std::size_t box, const PlaneReach& plane, Vector<std::size_t>& found) const;
    void sort_along_curve(const Bounds& bounds, const Parallel& parallel);

    struct CentredBox {
        std::array<double, 3> middle{};
        std::array<double, 3> half{};

        static CentredBox around(const Bounds& bounds) noexcept;
        bool meets(const PlaneReach& plane) const noexcept;
    };
    static constexpr std::size_t run = 32;  ///< triangles in a box, and boxes in a larger one

    /// Corners of a run, axis by axis: a plane's distances of all of them are one loop.
    struct Run {
        std::array<std::array<std::array<float, run>, 3>, 3> corners{};
    };
    const MeshView mesh_;
    const PlacedReader reader_;
    Vector<std::size_t> order_;  ///< triangles along the curve
    Vector<Run> runs_;
    Vector<CentredBox> boxes_;
    Vector<CentredBox> larger_;
};

}  // namespace lamella
