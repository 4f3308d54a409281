// The obvious slicer: all planes times all triangles, std::map for linking, brute force for nesting. It follows the rules
// that are documented in include/lamella and shares no code with the engine but its types.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lamella/assemble.hpp"
#include "lamella/grid.hpp"
#include "lamella/result.hpp"

namespace oracle {

__extension__ using Int128 = __int128;

using Triangle = std::array<lamella::GridVertex, 3>;
using EdgeKey = std::pair<lamella::GridVertex, lamella::GridVertex>;  ///< lower end, upper end

/// Nine numbers a triangle to the even grid; triangles with two equal vertices are dropped.
std::vector<Triangle> quantise(std::span<const double> coordinates, double unit_mm);

/// A point of a contour and the mesh edge that it lies on.
struct Crossing {
    lamella::Point point;
    EdgeKey edge;
    friend auto operator<=>(const Crossing&, const Crossing&) = default;
};

struct Contour {
    std::vector<lamella::Point> points;
    Crossing start;
    bool start_is_unique = true;  ///< false: passes through its start again, so where it starts is a matter of taste
    Int128 twice_area = 0;
    int parent = -1;  ///< index into the layer, -1 if none
    std::uint32_t segments = 0;
    lamella::Role role = lamella::Role::open;
    int sense = 0;
    unsigned flags = 0;
};

/// Contours in canonical order.
using Layer = std::vector<Contour>;

/// The segments of the plane at odd height `z`, with keys and ranks as assemble() wants them.
std::vector<lamella::Segment> segments_at(std::span<const Triangle> triangles, std::int32_t z);

Layer slice_at(std::span<const Triangle> triangles, std::int32_t z);

}  // namespace oracle
