// The algorithms that the paper describes or compares, behind one interface: a triangle soup and planes in, contours out.
// They are for measuring alone; of the engine they share the grid and its rounding, so that their answers can be compared.
//
// A slicing method gives a list of segments for each plane, a contour method joins such lists; any of the one goes with any
// of the other. A whole method does both in its own way, with more than segments between its two steps.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella::baselines {

using Facet = std::array<GridVertex, 3>;

/// The solid lies on the left.
struct Segment {
    Point from;
    Point to;
};
using SegmentLists = std::vector<std::vector<Segment>>;  ///< one for each plane

struct Polyline {
    std::vector<Point> points;  ///< the first of a closed one is not repeated
    bool closed = false;
};
using Contours = std::vector<std::vector<Polyline>>;  ///< those of each plane, in any order, from any point

struct Problem {
    std::span<const float> soup;       ///< mm, nine numbers a triangle
    double unit_mm = default_unit_mm;  ///< of the grid
    std::vector<std::int32_t> planes;  ///< grid units, odd, ascending
    bool uniform = false;              ///< plane i lies within a quarter of a step of first + i * step:
    double first = 0;                  ///< grid units
    double step = 0;                   ///< grid units

    std::size_t facets() const noexcept { return soup.size() / 9; }
};

struct SlicingMethod {
    std::string_view name;
    std::string_view source;  ///< of the algorithm
    bool uniform_only = false;
    SegmentLists (*slice)(const Problem&) = nullptr;
};

struct ContourMethod {
    std::string_view name;
    std::string_view source;
    std::vector<Polyline> (*join_plane)(const std::vector<Segment>&) = nullptr;

    /// Plane by plane.
    Contours join(const SegmentLists& lists) const {
        Contours contours;
        contours.reserve(lists.size());
        for (const std::vector<Segment>& segments : lists) {
            contours.push_back(join_plane(segments));
        }
        return contours;
    }
};

struct WholeOutcome {
    Contours contours;
    std::uint64_t segments = 0;
    double slicing_s = 0;  ///< of its time, up to the first step that joins segments; 0 where the two cannot be told apart
};

struct WholeMethod {
    std::string_view name;
    std::string_view source;
    bool uniform_only = false;
    bool takes_open_meshes = false;
    WholeOutcome (*run)(const Problem&) = nullptr;
};

}  // namespace lamella::baselines
