// A slicer that is easy to verify: it tests all planes against all triangles, links with std::map and nests by brute
// force. It follows the rules documented in include/lamella and shares only types with the engine.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lamella/grid.hpp"
#include "lamella/layers.hpp"
#include "lamella/result.hpp"
#include "rings.hpp"

namespace oracle {

using rings::Int128;

using Triangle = std::array<lamella::GridVertex, 3>;
using EdgeKey = std::pair<lamella::GridVertex, lamella::GridVertex>;  ///< lower end, upper end

/// Rounds nine numbers a triangle to the even grid. Drops triangles with two equal vertices.
std::vector<Triangle> quantise(std::span<const double> coordinates, double unit_mm);

/// Sorted, and of those that are equal on the grid the lowest.
std::vector<double> distinct(std::vector<double> heights, double unit_mm);
/// At which vertices lie, distinct.
std::vector<double> vertex_heights(std::span<const double> soup, double unit_mm);

/// A point of a contour and the mesh edge that it lies on.
struct Crossing {
    lamella::Point point;
    EdgeKey edge;
    friend auto operator<=>(const Crossing&, const Crossing&) = default;
};

struct Contour {
    std::vector<lamella::Point> points;
    Crossing start;
    bool start_is_unique = true;  ///< false: it passes through its start again, and either pass may be first
    Int128 twice_area = 0;
    int parent = -1;  ///< index into the layer, -1 if none
    std::uint32_t segments = 0;
    lamella::Role role = lamella::Role::open;
    int orientation = 0;
    unsigned flags = 0;
};

/// Contours in canonical order.
using Layer = std::vector<Contour>;

/// The segments of the plane at odd height `z`, with the keys and ranks that assemble() takes.
std::vector<lamella::Segment> segments_at(std::span<const Triangle> triangles, std::int32_t z);

/// The smallest contour strictly around each start. Points must run from their starts.
void find_parents(Layer& layer);

/// Roles by the orientations from the outside in: where a winding number is negative, by the number of contours around.
/// Contours are turned round to suit theirs. Parents must be known.
void decide_roles(Layer& layer);

Layer slice_at(std::span<const Triangle> triangles, std::int32_t z);

}  // namespace oracle
