// The algorithms that the paper describes or compares, behind one interface: a triangle soup and planes in, contours
// out. They serve only for measurements. They share the engine's grid and rounding, so that answers can be compared.
//
// A slicing method gives a list of segments for each plane. A contour method joins such lists. Any slicing method can
// be combined with any contour method. A whole method does both steps in its own way and passes more than segments
// between them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella::baselines {

using Facet = std::array<GridVertex, 3>;

/// The solid lies on its left.
struct Segment {
    Point from;
    Point to;
};
using SegmentLists = std::vector<std::vector<Segment>>;  ///< one list for each plane

struct Polyline {
    std::vector<Point> points;  ///< a closed polyline does not repeat its first point
    bool closed = false;
};
using Contours = std::vector<std::vector<Polyline>>;  ///< by plane; contours in any order, from any start point

struct Problem {
    std::span<const float> soup;       ///< mm, nine numbers a triangle
    double unit_mm = default_grid_mm;  ///< grid unit
    std::vector<std::int32_t> planes;  ///< grid units, odd, ascending
    bool uniform = false;              ///< whether plane i lies within a quarter of a step of first + i * step
    double first = 0;                  ///< grid units; for uniform planes only
    double step = 0;                   ///< grid units; for uniform planes only

    std::size_t facets() const noexcept { return soup.size() / 9; }
};

struct SlicingMethod {
    std::string_view name;
    bool uniform_only = false;
    SegmentLists (*slice)(const Problem&) = nullptr;
};

struct ContourMethod {
    std::string_view name;
    std::vector<Polyline> (*join_plane)(const std::vector<Segment>&) = nullptr;

    /// Joins the segments plane by plane.
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
    double slicing_s = 0;  ///< time up to the first step that joins segments; 0 where the two steps cannot be separated
};

struct WholeMethod {
    std::string_view name;
    bool takes_open_meshes = false;
    WholeOutcome (*run)(const Problem&) = nullptr;
};

}  // namespace lamella::baselines
